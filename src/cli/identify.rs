//! `lostmotion identify --model M --data F...`.

use std::path::PathBuf;

use clap::Args;

use crate::diagnose::mistakes;
use crate::effects::{Catalogue, applied};
use crate::error::Result;
use crate::identify::{self, Options};
use crate::report::files::planned;
use crate::report::identification::report;

use super::console::{OutputOptions, Progress};
use super::folder::{Folder, Request};
use super::input;
use super::{Outcome, console};

/// Identify friction and backlash from recorded data: the paper's procedure and the full friction fit
#[derive(Debug, Args)]
pub struct Identify {
    /// Model file, or the name of a robot of the catalogue
    #[arg(long, value_name = "MODEL")]
    model: PathBuf,
    /// Recordings in any format that is read, or manifests (`lostmotion data FILE` prints one)
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    data: Vec<PathBuf>,
    #[command(flatten)]
    output: OutputOptions,
}

impl Identify {
    /// Reads, identifies, reports.
    pub fn run(self) -> Result<Outcome> {
        let model = input::model(&self.model)?;
        let input::Recordings { model, data: sessions, drawn, .. } =
            input::Recordings::read(&self.data, &[], &[], &model, &identify::CHANNELS)?;
        let folder = Folder::reserve(
            self.output.out.as_deref(),
            Request {
                verb: "identify",
                name: &model.name,
                files: planned(Some(&model), []),
                inputs: input::files(&model, &[&self.data], &[&sessions]),
            },
        )?;
        let progress = Progress::start("identifying", self.output.quiet);
        let notes = input::notes(&sessions);
        let series = input::series(sessions);
        let suspected = mistakes::suspected(&model, &series.iter().collect::<Vec<_>>());
        // What the model file lists of the machine belongs to its torques.
        let trusted = applied(&model, &Catalogue::default())?.model;
        let found = identify::identify(&trusted, &series, &Options::default())?;
        drop(progress);
        let mut report = report(&model.name, &found, None, &model, drawn);
        report.document.warnings.extend(notes);
        report.document.warnings.extend(mistakes::warnings(&suspected));
        console::finish(&report, &folder, &self.output)
    }
}

//! `lostmotion replay --model M --data F...`.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::diagnose::mistakes;
use crate::error::Result;
use crate::replay::{self, Loop, Options};
use crate::report::files::envelope;
use crate::report::recording::Motion;
use crate::report::{Report, replay as rendering};

use super::console::{OutputOptions, Progress};
use super::folder::Folder;
use super::{Outcome, console, input};

/// Simulate a model under the recorded inputs, beside the data: error figures per channel
#[derive(Debug, Args)]
pub struct Replay {
    /// Model file, or the name of a robot of the catalogue
    #[arg(long, value_name = "MODEL")]
    model: PathBuf,
    /// Recordings: canonical CSV, or manifests
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    data: Vec<PathBuf>,
    /// Drive the model by the recorded torque or current alone: no controller corrects it, and its position drifts away
    #[arg(long)]
    open_loop: bool,
    #[command(flatten)]
    output: OutputOptions,
}

impl Replay {
    /// Reads, simulates, reports.
    pub fn run(self) -> Result<Outcome> {
        let model = input::model(&self.model)?;
        let sessions = input::sessions(&self.data, &model)?;
        let folder = Folder::reserve(self.output.out.as_deref(), &model.name)?;
        let progress = Progress::start("replaying", self.output.quiet);
        let control = if self.open_loop { Loop::Open } else { Loop::Closed };
        let options = Options { control, ..Options::default() };
        let suspected = mistakes::suspected(&model, &sessions.iter().map(|one| &one.series).collect::<Vec<_>>());
        let mut replays = Vec::new();
        for (index, session) in sessions.iter().enumerate() {
            #[expect(clippy::cast_precision_loss, reason = "a handful of sessions")]
            progress.set(index as f64 / sessions.len() as f64);
            replays.push(replay::replay(&model, session, &options)?);
        }
        drop(progress);
        let mut document = rendering::document(&model.name, &replays, control);
        document.warnings.extend(input::notes(&sessions));
        document.warnings.extend(mistakes::warnings(&suspected));
        let content: Vec<_> = replays
            .iter()
            .map(|one| json!({ "session": one.recorded.name, "errors": one.errors, "notes": one.notes }))
            .collect();
        let motions = replays
            .iter()
            .map(|one| Motion { traces: rendering::traces(one), ..Motion::new(&model.robot, &one.simulated) })
            .collect();
        let json = envelope("lostmotion/replay/1", &model.name, json!({ "loop": control, "sessions": content }));
        console::finish(&Report { document, json, motions, model: None, extra: Vec::new() }, &folder, &self.output)
    }
}

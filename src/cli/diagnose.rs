//! `lostmotion diagnose --model M --data F...`.

use std::path::PathBuf;

use clap::Args;

use crate::diagnose::{Judgement, Verdict, judge};
use crate::error::Result;
use crate::report::Report;
use crate::report::diagnosis::report;
use crate::report::files::planned;
use crate::scenario::channels;

use super::console::{OutputOptions, Progress};
use super::folder::{Folder, Request};
use super::{Outcome, console, input};

/// Find what the simulation gets wrong: the named cause, the extended model, the gain
#[derive(Debug, Args)]
pub struct Diagnose {
    /// Nominal model: a file, or the name of a robot of the catalogue
    #[arg(long, value_name = "MODEL")]
    model: PathBuf,
    /// Recordings in any format that is read, or manifests (`lostmotion data FILE` prints one)
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    data: Vec<PathBuf>,
    /// Recordings of the same machine when it was healthy: find what has changed between them and --data
    #[arg(long, value_name = "FILE", num_args = 1..)]
    reference: Vec<PathBuf>,
    /// Recordings to judge on [default: the last 30 % of each session of --data, or of each of its blocks where joints move one by one]
    #[arg(long, value_name = "FILE", num_args = 1..)]
    hold_out: Vec<PathBuf>,
    /// Then let the simulation judge sets of effects by every sample, reversals and rests included; this takes minutes
    #[arg(long, conflicts_with = "reference")]
    judge: bool,
    /// Exit with 1 if the nominal model does not explain the data
    #[arg(long)]
    fail_on_gap: bool,
    #[command(flatten)]
    output: OutputOptions,
}

impl Diagnose {
    /// Reads, diagnoses, replays the nominal and the extended model, reports.
    pub fn run(self) -> Result<Outcome> {
        let model = input::model(&self.model)?;
        let recordings = input::Recordings::read(&self.data, &self.hold_out, &self.reference, &model, &channels())?;
        let (name, notes) = (recordings.model.name.clone(), recordings.notes());
        let request = Request {
            verb: "diagnose",
            name: &name,
            files: planned(Some(&recordings.model), []),
            inputs: recordings.files(&[&self.data, &self.hold_out, &self.reference]),
        };
        let folder = Folder::reserve(self.output.out.as_deref(), request)?;
        let sessions = self.judge.then(|| (recordings.data.clone(), recordings.hold_out.clone()));
        let (mut found, drawn) = recordings.findings(self.output.quiet)?;
        if let Some((train, hold_out)) = sessions {
            // Minutes follow: what is found is written before them. A folder that refuses now may not at the end, which reports it.
            found.diagnosis.judgement = Some(Judgement::not_applied("It had not ended when this was written."));
            let _ = noted(report(&found, &name, drawn.clone()), &notes).files().and_then(|files| folder.write(&files));
            let progress = Progress::start("judging", self.output.quiet);
            found.judge(train, hold_out, &judge::Options::default(), &mut |doing, share| progress.show(doing, share));
        }
        let report = noted(report(&found, &name, drawn), &notes);
        let outcome = console::finish(&report, &folder, &self.output)?;
        let gap = !matches!(found.diagnosis.verdict, Verdict::NothingFound | Verdict::MistakeSuspected);
        Ok(if self.fail_on_gap && gap { Outcome::Failed } else { outcome })
    }
}

/// A report with what was noted while reading.
fn noted<'a>(mut report: Report<'a>, notes: &[String]) -> Report<'a> {
    report.document.warnings.extend_from_slice(notes);
    report
}

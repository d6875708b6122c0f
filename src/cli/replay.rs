//! `lostmotion replay --model M --data F...`.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::dataset::Session;
use crate::diagnose::mistakes;
use crate::error::Result;
use crate::replay::{self, Loop, Options, prediction};
use crate::report::files::{envelope, planned};
use crate::report::recording::Motion;
use crate::report::replay::Shown;
use crate::report::{Report, replay as rendering};
use crate::robot::Model;
use crate::timeseries::Channel;

use super::console::{OutputOptions, Progress};
use super::folder::{Folder, Request};
use super::{Outcome, console, input};

/// Simulate a model under the recorded inputs, beside the data: error figures per channel
#[derive(Debug, Args)]
pub struct Replay {
    /// Model file, or the name of a robot of the catalogue
    #[arg(long, value_name = "MODEL")]
    model: PathBuf,
    /// Recordings in any format that is read, or manifests (`lostmotion data FILE` prints one)
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
        let input::Recordings { model, data: sessions, .. } = input::Recordings::read(
            &self.data,
            &[],
            &[],
            &model,
            &[replay::CHANNELS.as_slice(), &[Channel::Velocity]].concat(),
        )?;
        let folder = Folder::reserve(
            self.output.out.as_deref(),
            Request {
                verb: "replay",
                name: &model.name,
                files: planned(None, []),
                inputs: input::files(&model, &[&self.data], &[&sessions]),
            },
        )?;
        let progress = Progress::start("replaying", self.output.quiet);
        let control = if self.open_loop { Loop::Open } else { Loop::Closed };
        let options = Options { control, ..Options::default() };
        let notes = input::notes(&sessions);
        let suspected = mistakes::suspected(&model, &sessions.iter().map(|one| &one.series).collect::<Vec<_>>());
        let count = sessions.len();
        let mut replays = Vec::new();
        for (index, session) in sessions.into_iter().enumerate() {
            #[expect(clippy::cast_precision_loss, reason = "a handful of sessions")]
            progress.set(index as f64 / count as f64);
            replays.push(shown(&model, &session, &options)?);
        }
        drop(progress);
        let mut document = rendering::document(&model.name, &replays, control);
        document.warnings.extend(notes);
        document.warnings.extend(mistakes::warnings(&suspected));
        let content: Vec<_> = replays
            .iter()
            .map(|(one, shown)| {
                let predictions = shown.predictions();
                json!({ "session": one.session, "errors": one.errors, "predictions": predictions, "notes": one.notes })
            })
            .collect();
        let motions = replays
            .into_iter()
            .map(|(one, drawn)| Motion { traces: drawn.traces, ..Motion::new(&model.robot, one.simulated) })
            .collect();
        let json = envelope("lostmotion/replay/1", &model.name, json!({ "loop": control, "sessions": content }));
        console::finish(&Report { document, json, motions, model: None, extra: Vec::new() }, &folder, &self.output)
    }
}

/// The replay of one session, and its curves for display.
fn shown(model: &Model, session: &Session, options: &Options) -> Result<(replay::Replay, Shown)> {
    let mut shown = Shown::default();
    let mut replay = replay::replay_seen(model, session, options, &mut |side| shown.add(&session.series.name, side))?;
    match prediction::predict(model, session, options) {
        Ok(predicted) => {
            shown.predicted = predicted.made;
            replay.notes.extend(predicted.diverged.iter().map(|why| format!("not predicted: {why}")));
        }
        Err(why) => replay.notes.push(format!("nothing was predicted: {why}")),
    }
    Ok((replay::Replay { time: Vec::new(), ..replay }, shown))
}

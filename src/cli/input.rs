//! What a command reads: the model and the recordings.

use std::path::{Path, PathBuf};

use crate::dataset::{self, Session};
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::{Channel, Drawn, TimeSeries};

use super::catalogue::Source;

/// The model of a file, a folder with a `model.toml`, or a robot of the catalogue.
///
/// # Errors
/// There is none of that name, or its file is refused.
pub fn model(given: &Path) -> Result<Model> {
    Model::load(&Source::find(given, "robots", "model.toml")?.path)
}

/// Reads recordings one by one, and keeps of each the channels that are wanted and how all of it is drawn.
///
/// # Errors
/// A file cannot be read or used.
pub fn drawn(files: &[PathBuf], model: &Model, wanted: &[Channel]) -> Result<(Vec<Session>, Vec<Drawn>)> {
    let joints = dataset::joints_of(model);
    let read = |file: &PathBuf| {
        let mut session = dataset::load(file, &joints)?;
        let drawn = Drawn::of(&session.series);
        session.series.keep(wanted);
        Ok((session, drawn))
    };
    Ok(files.iter().map(read).collect::<Result<Vec<_>>>()?.into_iter().unzip())
}

/// What was noticed or mended while reading.
pub fn notes(sessions: &[Session]) -> Vec<String> {
    sessions.iter().flat_map(|session| session.notes.iter().map(ToString::to_string)).collect()
}

/// The signals alone.
pub fn series(sessions: Vec<Session>) -> Vec<TimeSeries> {
    sessions.into_iter().map(|session| session.series).collect()
}

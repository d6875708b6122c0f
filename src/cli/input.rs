//! What a command reads: the model and the recordings.

use std::path::{Path, PathBuf};

use crate::dataset::{self, Session};
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::TimeSeries;

use super::catalogue::Source;

/// The model of a file, a folder with a `model.toml`, or a robot of the catalogue.
///
/// # Errors
/// There is none of that name, or its file is refused.
pub fn model(given: &Path) -> Result<Model> {
    Model::load(&Source::find(given, "robots", "model.toml")?.path)
}

/// Reads recordings of the joints of a model.
///
/// # Errors
/// A file cannot be read or used.
pub fn sessions(files: &[PathBuf], model: &Model) -> Result<Vec<Session>> {
    let joints = dataset::joints_of(model);
    files.iter().map(|file| dataset::load(file, &joints)).collect()
}

/// What was noticed or mended while reading.
pub fn notes(sessions: &[Session]) -> Vec<String> {
    sessions.iter().flat_map(|session| session.notes.iter().map(ToString::to_string)).collect()
}

/// The signals alone.
pub fn series(sessions: Vec<Session>) -> Vec<TimeSeries> {
    sessions.into_iter().map(|session| session.series).collect()
}

//! What a command reads: the model and the recordings.

use std::path::{Path, PathBuf};

use crate::dataset::{self, Session};
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::TimeSeries;

use super::catalogue;

/// The model of a file, a folder with a `model.toml`, or a robot of the catalogue.
///
/// # Errors
/// There is none of that name, or its file is refused.
pub fn model(given: &Path) -> Result<Model> {
    Model::load(&catalogue::find(given, "robots", "model.toml")?)
}

/// Reads recordings of the joints of a model.
///
/// # Errors
/// A file cannot be read or used.
pub fn sessions(files: &[PathBuf], model: &Model) -> Result<Vec<Session>> {
    let joints = dataset::joints_of(model);
    files.iter().map(|file| dataset::load(file, &joints)).collect()
}

/// The files that a command reads: those of the model, those that were given, and those of the recordings that manifests name.
pub fn files(model: &Model, given: &[&[PathBuf]], sessions: &[&[Session]]) -> Vec<PathBuf> {
    let of_model = [&model.source, &model.urdf];
    let of_data = sessions.iter().copied().flatten().map(|session| &session.source);
    of_model.into_iter().chain(given.iter().copied().flatten()).chain(of_data).cloned().collect()
}

/// What was noticed or mended while reading.
pub fn notes(sessions: &[Session]) -> Vec<String> {
    sessions.iter().flat_map(|session| session.notes.iter().map(ToString::to_string)).collect()
}

/// The signals alone.
pub fn series(sessions: Vec<Session>) -> Vec<TimeSeries> {
    sessions.into_iter().map(|session| session.series).collect()
}

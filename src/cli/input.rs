//! What a command reads: the model and the recordings.

use std::path::{Path, PathBuf};

use crate::dataset;
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

/// Recordings of a machine, and what was mended while reading them.
#[derive(Debug, Default)]
pub struct Recordings {
    /// One a session.
    pub series: Vec<TimeSeries>,
    /// What the user must know.
    pub warnings: Vec<String>,
}

impl Recordings {
    /// Reads all files, for the joints of the model.
    ///
    /// # Errors
    /// A file cannot be read or used.
    pub fn load(files: &[PathBuf], model: &Model) -> Result<Self> {
        let joints = dataset::joints_of(model);
        let mut all = Self::default();
        for file in files {
            let session = dataset::load(file, &joints)?;
            all.warnings.extend(session.notes.iter().map(ToString::to_string));
            all.series.push(session.series);
        }
        Ok(all)
    }
}

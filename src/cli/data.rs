//! `lostmotion data FILE...`.

use std::path::PathBuf;

use clap::Args;

use crate::dataset;
use crate::error::Result;

use super::{Outcome, console};

/// Show what files of data hold, with a first manifest
#[derive(Debug, Args)]
pub struct Data {
    /// CSV or MATLAB 5 files, or manifests
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
}

impl Data {
    /// Prints a survey of each file; for an unknown layout also a first manifest; for a manifest its session.
    pub fn run(self) -> Result<Outcome> {
        for (index, file) in self.files.iter().enumerate() {
            if index > 0 {
                console::print("\n")?;
            }
            console::print(&describe(file)?)?;
        }
        Ok(Outcome::Done)
    }
}

fn describe(file: &std::path::Path) -> Result<String> {
    if file.extension().is_some_and(|extension| extension == "toml") {
        let session = dataset::load_alone(file)?;
        return Ok(dataset::survey_session(&session));
    }
    let table = dataset::read_table(file)?;
    let mut text = dataset::survey(&table);
    if !dataset::is_canonical(&table) {
        text += "\nA manifest to begin with, to be saved beside the file and passed to --data:\n\n";
        text += &dataset::first_manifest(&table);
    }
    Ok(text)
}

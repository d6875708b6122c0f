//! `lostmotion new ROBOT.urdf`.

use std::path::PathBuf;

use clap::Args;

use crate::error::{Error, Place, Result};
use crate::plant::first_model;

use super::check::noted;
use super::{Outcome, console};

/// Write a first model.toml for a URDF, to be completed with the machine's own numbers
#[derive(Debug, Args)]
pub struct New {
    /// The URDF
    #[arg(value_name = "ROBOT.urdf")]
    urdf: PathBuf,
    /// Where to write it [default: model.toml beside the URDF]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl New {
    /// Reads the URDF and writes the model; an existing file is not replaced.
    pub fn run(self) -> Result<Outcome> {
        let model = first_model(&self.urdf)?;
        let file = self.out.unwrap_or_else(|| self.urdf.with_file_name("model.toml"));
        // A broken symbolic link counts as an existing file.
        if file.symlink_metadata().is_ok() {
            return Err(Error::input(&file, Place::File, "--out", "", "a file that does not exist yet"));
        }
        model.save(&file)?;
        let joints: Vec<&str> = model.joints.iter().map(|joint| joint.name.as_str()).collect();
        console::print(&format!(
            "{}: joints {}{}\nReplace gear, rotor, motor and sensors by your machine's numbers; friction and backlash are left to `lostmotion identify`. Where a motor moves several joints, as in many wrists, add `[coupling]`.\n",
            file.display(),
            joints.join(", "),
            noted(&model.notes())
        ))?;
        Ok(Outcome::Done)
    }
}

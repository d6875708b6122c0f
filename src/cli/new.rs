//! `lostmotion new ROBOT`.

use std::path::PathBuf;

use clap::Args;

use crate::error::{Error, Place, Result};
use crate::plant::first_model;
use crate::scenario::first_experiment;
use crate::toml_input::write_atomically;

use super::check::noted;
use super::{Outcome, console};

/// Write a first model.toml for a robot file, to be completed with the machine's own numbers
#[derive(Debug, Args)]
pub struct New {
    /// The robot file: URDF or MJCF
    #[arg(value_name = "ROBOT.urdf")]
    robot: PathBuf,
    /// Where to write the model [default: model.toml beside the robot file]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write a first experiment as well, beside the model: first_experiment.toml to rehearse it, first_experiment.csv to play it on the machine
    #[arg(long)]
    staircase: bool,
}

impl New {
    /// Reads the robot file and writes the model; an existing file is not replaced.
    pub fn run(self) -> Result<Outcome> {
        let first = first_model(&self.robot)?;
        let model = &first.model;
        let file = self.out.unwrap_or_else(|| self.robot.with_file_name("model.toml"));
        let [scenario, references] =
            ["first_experiment.toml", "first_experiment.csv"].map(|name| file.with_file_name(name));
        let further: &[&PathBuf] = if self.staircase { &[&scenario, &references] } else { &[] };
        for place in further.iter().copied().chain([&file]) {
            // A broken symbolic link counts as an existing file.
            if place.symlink_metadata().is_ok() {
                return Err(Error::input(place, Place::File, "--out", "", "a file that does not exist yet"));
            }
        }
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let experiment = self.staircase.then(|| first_experiment(&first, &name)).transpose()?;
        first.save(&file)?;
        let mut written = String::new();
        if let Some(experiment) = experiment {
            write_atomically(&references, &experiment.references)?;
            write_atomically(&scenario, &experiment.scenario)?;
            written = format!(
                "{}: {:.0} s of motion, one joint after the other; `lostmotion run` rehearses it. {} has its references for the machine.\n",
                scenario.display(),
                experiment.duration,
                references.display()
            );
        }
        let joints: Vec<&str> = model.joints.iter().map(|joint| joint.name.as_str()).collect();
        console::print(&format!(
            "{}: joints {}{}\n{written}Replace what is marked as placeholder by your machine's numbers; friction and backlash are left to `lostmotion identify`. Where a motor moves several joints, as in many wrists, add `[coupling]`.\n",
            file.display(),
            joints.join(", "),
            noted(&model.notes())
        ))?;
        Ok(Outcome::Done)
    }
}

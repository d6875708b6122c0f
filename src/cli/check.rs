//! `lostmotion check FILE...`.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::dataset;
use crate::error::Result;
use crate::plant::{Options, Plant, first_model};
use crate::robot::Model;
use crate::scenario::{Recorded, Scenario, channels};
use crate::toml_input::{Document, nearest};

use super::{Outcome, console, input};

/// Validate models, datasets and scenarios; say what is wrong where
#[derive(Debug, Args)]
pub struct Check {
    /// Model files, manifests, scenarios, recordings, URDF files
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
}

/// Types of TOML file, by their key `schema`.
const SCHEMAS: [&str; 3] = ["lostmotion/model/1", "lostmotion/dataset/1", "lostmotion/scenario/1"];

impl Check {
    /// Reads each file as the other commands would. All files are checked; the first error ends the command after the
    /// last file.
    pub fn run(self) -> Result<Outcome> {
        let mut first_error = None;
        for file in &self.files {
            match check(file) {
                Ok(found) => console::print(&format!("{}: {found}\n", file.display()))?,
                Err(error) if first_error.is_none() => first_error = Some(error),
                Err(error) => eprintln!("error: {error}"),
            }
        }
        first_error.map_or(Ok(Outcome::Done), Err)
    }
}

/// The content of the file, in one line.
fn check(file: &Path) -> Result<String> {
    match file.extension().and_then(|extension| extension.to_str()) {
        Some("toml") => check_toml(file),
        Some("urdf" | "xml") => Ok(described(&first_model(file)?)),
        _ => {
            let session = dataset::load_alone(file)?;
            Ok(recorded(&session))
        }
    }
}

fn check_toml(file: &Path) -> Result<String> {
    dataset::check_manifest(file)?;
    let document = Document::read(file)?;
    let root = document.root();
    match root.text("schema")? {
        "lostmotion/model/1" => Ok(described(&model(file)?)),
        "lostmotion/dataset/1" => Ok(recorded(&dataset::load_alone(file)?)),
        "lostmotion/scenario/1" => scenario(file),
        other => {
            let expected = nearest(other, SCHEMAS).unwrap_or(SCHEMAS[0]);
            Err(root.error("schema", format!("one of {}; nearest is {expected}", SCHEMAS.join(", "))))
        }
    }
}

fn scenario(file: &Path) -> Result<String> {
    if let Some(recorded) = Recorded::load(file, &[])? {
        return on_recordings(&recorded);
    }
    let scenario = Scenario::load(file, &[])?;
    let cost = scenario.check()?;
    Ok(format!("scenario {} of {}, {cost}{}", scenario.name, scenario.model.name, noted(&scenario.model.notes())))
}

/// A scenario on recordings: its recordings and model are read as in a run.
fn on_recordings(scenario: &Recorded) -> Result<String> {
    let model = buildable(scenario.model()?)?;
    let read = input::Recordings::read(&scenario.data, &scenario.hold_out, &scenario.reference, &model, &channels())?;
    let sessions = read.data.len() + read.hold_out.len() + read.reference.len();
    Ok(format!("scenario {}, {sessions} recordings of {}", scenario.name, model.name))
}

/// Reads a model, and checks that a machine can be built from it.
fn model(file: &Path) -> Result<Model> {
    buildable(Model::load(file)?)
}

/// The model, if a machine can be built from it.
fn buildable(model: Model) -> Result<Model> {
    Plant::new(&model, &Options::default())?;
    Ok(model)
}

/// Notes, each on a line of its own.
pub(super) fn noted(notes: &[String]) -> String {
    notes.iter().map(|note| format!("\n  note: {note}")).collect()
}

fn described(model: &Model) -> String {
    let held = if model.held.is_empty() { String::new() } else { format!(", held at zero: {}", model.held.join(", ")) };
    let joints: Vec<&str> = model.joints.iter().map(|joint| joint.name.as_str()).collect();
    let coupled: Vec<&str> = model.coupled_axes().map(|axis| joints[axis]).collect();
    let coupled = if coupled.is_empty() { String::new() } else { format!(", coupled axes: {}", coupled.join(", ")) };
    format!("model {}, joints {}{coupled}{held}{}", model.name, joints.join(", "), noted(&model.notes()))
}

fn recorded(session: &dataset::Session) -> String {
    let joints: Vec<&str> = session.series.joints.iter().map(|joint| joint.name.as_str()).collect();
    let notes: String = session.notes.iter().map(|note| format!("\n  note: {note}")).collect();
    format!("session {}, {} samples, joints {}{notes}", session.series.name, session.series.len(), joints.join(", "))
}

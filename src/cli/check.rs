//! `lostmotion check FILE...`.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::dataset;
use crate::error::Result;
use crate::plant::{Options, Plant, first_model};
use crate::robot::{Model, marked_lines};
use crate::scenario::{Recorded, Scenario, Trial, channels, trial};
use crate::toml_input::{Document, nearest, read_text};

use super::{Outcome, console, input};

/// Validate models, datasets and scenarios; say what is wrong where
#[derive(Debug, Args)]
pub struct Check {
    /// Model files, manifests, scenarios, recordings, URDF files
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
}

/// [bytes] Longest model file that is searched for placeholders.
const LONGEST: u64 = 2 << 20;

/// Types of TOML file, by their key `schema`.
const SCHEMAS: [&str; 3] = ["lostmotion/model/1", "lostmotion/dataset/1", "lostmotion/scenario/1"];

impl Check {
    /// Reads each file as the other commands would. All files are checked; the first error ends the command after the
    /// last file.
    pub fn run(self) -> Result<Outcome> {
        let (mut first_error, mut warned) = (None, false);
        for file in &self.files {
            match check(file) {
                Ok(found) => {
                    console::print(&format!("{}: {}\n", file.display(), found.text))?;
                    warned |= found.warned;
                }
                Err(error) if first_error.is_none() => first_error = Some(error),
                Err(error) => eprintln!("error: {error}"),
            }
        }
        first_error.map_or(Ok(if warned { Outcome::Warned } else { Outcome::Done }), Err)
    }
}

/// What a file contains.
struct Checked {
    text: String,
    /// Whether something in it does not work.
    warned: bool,
}

impl From<String> for Checked {
    fn from(text: String) -> Self {
        Self { text, warned: false }
    }
}

/// The content of the file, in one line, with notes below it.
fn check(file: &Path) -> Result<Checked> {
    match file.extension().and_then(|extension| extension.to_str()) {
        Some("toml") => check_toml(file),
        Some("urdf" | "xml" | "mjcf") => tried(&first_model(file)?.model),
        _ => {
            let session = dataset::load_alone(file)?;
            Ok(recorded(&session).into())
        }
    }
}

/// A model, and the result of simulating all its joints for a second of motion.
fn tried(model: &Model) -> Result<Checked> {
    let Trial { duration, joints, faults } = trial(model)?;
    let moved = if faults.is_empty() {
        format!("simulated: all {joints} joints to and fro within {duration} s, each follows its reference")
    } else {
        format!("simulated: all {joints} joints to and fro within {duration} s; this fails:")
    };
    let faulty: String = faults.iter().map(|fault| format!("\n    {fault}")).collect();
    Ok(Checked { text: format!("{}\n  {moved}{faulty}", described(model)), warned: !faults.is_empty() })
}

/// How many values of a model file are still placeholders.
fn placeholders(file: &Path) -> Result<String> {
    let lines = marked_lines(&read_text(file, LONGEST)?);
    let shown: Vec<String> = lines.iter().take(10).map(usize::to_string).collect();
    Ok(match lines.len() {
        0 => String::new(),
        count => {
            let more = if count > shown.len() { ", …" } else { "" };
            format!(
                "\n  note: {count} values are placeholders, to be replaced by the machine's own: lines {}{more}",
                shown.join(", ")
            )
        }
    })
}

fn check_toml(file: &Path) -> Result<Checked> {
    dataset::check_manifest(file)?;
    let document = Document::read(file)?;
    let root = document.root();
    match root.text("schema")? {
        "lostmotion/model/1" => {
            let mut checked = tried(&model(file)?)?;
            checked.text += &placeholders(file)?;
            Ok(checked)
        }
        "lostmotion/dataset/1" => Ok(recorded(&dataset::load_alone(file)?).into()),
        "lostmotion/scenario/1" => Ok(scenario(file)?.into()),
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

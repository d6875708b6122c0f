//! A scenario about recordings of a real machine: recordings, nominal model, and the effects that must be named.
//!
//! ```toml
//! schema = "lostmotion/scenario/1"
//! name = "kr300_two_encoders"
//! question = "Is it a gap?"
//! procedure = "diagnose"
//! robot = "../../robots/kr300/model.toml"      # relative to this file, else to the folder named by LOSTMOTION_DATA; so are the recordings
//! source = "who recorded it"                   # for a message where a file is missing
//! model = ["accuracy.masses=0.2"]              # changes of the model, if any
//! data = ["../../robots/kr300/datasets/trajectory_a.toml"]
//! hold_out = ["../../robots/kr300/datasets/trajectory_b.toml"]
//! reference = []                               # recordings of the healthy machine, if what has changed since is asked
//! [expect]
//! effects = ["sensor_delay"]                   # all that is named; and bounds of figures, see `expect_diagnosis`
//! ```

use std::path::{Path, PathBuf};

use super::{DiagnosisExpectation, SCHEMA, UnmetDiagnosis};
use crate::diagnose::Diagnosis;
use crate::error::Result;
use crate::robot::Model;
use crate::toml_input::Document;

/// A scenario about recordings.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Its name.
    pub name: String,
    /// The question that it answers.
    pub question: String,
    /// Nominal model.
    pub robot: PathBuf,
    /// Changes of that model, each `KEY=VALUE`.
    pub assignments: Vec<String>,
    /// Recordings, or their manifests.
    pub data: Vec<PathBuf>,
    /// Recordings to evaluate on.
    pub hold_out: Vec<PathBuf>,
    /// Recordings of the healthy machine; empty if no change is asked for.
    pub reference: Vec<PathBuf>,
    /// Expected effects, and bounds of their figures.
    pub expectation: DiagnosisExpectation,
}

impl Recorded {
    /// Reads a scenario file; `None` if it has no `data`, that is, if it is to be simulated.
    ///
    /// # Errors
    /// The file cannot be read, a key is missing or unknown, or a file that it names does not exist.
    pub fn load(file: &Path, assignments: &[String]) -> Result<Option<Self>> {
        let mut document = Document::read(file)?;
        if !document.root().has("data") {
            return Ok(None);
        }
        for assignment in assignments {
            document.set(assignment)?;
        }
        let root = document.root();
        root.optional_choice("schema", &[(SCHEMA, ())])?
            .ok_or_else(|| root.error("schema", format!("\"{SCHEMA}\" (missing)")))?;
        root.optional_choice("procedure", &[("diagnose", ())])?
            .ok_or_else(|| root.error("procedure", "\"diagnose\" (missing)"))?;
        root.has("source");
        let all = |key: &str| -> Result<Vec<PathBuf>> {
            root.optional_texts(key)?.unwrap_or_default().iter().map(|name| root.recording(key, name)).collect()
        };
        let expectation = match root.optional_table("expect")? {
            Some(expect) => {
                let expectation = DiagnosisExpectation::read(&expect, None)?;
                expect.finish()?;
                expectation
            }
            None => DiagnosisExpectation::default(),
        };
        let scenario = Self {
            name: root.name("name")?.to_owned(),
            question: root.optional_text("question")?.unwrap_or_default().to_owned(),
            robot: root.recording("robot", root.text("robot")?)?,
            assignments: root.optional_texts("model")?.unwrap_or_default().into_iter().map(str::to_owned).collect(),
            data: all("data")?,
            hold_out: all("hold_out")?,
            reference: all("reference")?,
            expectation,
        };
        root.finish()?;
        Ok(Some(scenario))
    }

    /// The nominal model with the scenario's changes.
    ///
    /// # Errors
    /// As [`Model::load`]; a change names no value of it.
    pub fn model(&self) -> Result<Model> {
        let mut document = Document::read(&self.robot)?;
        self.assignments.iter().try_for_each(|assignment| document.set(assignment))?;
        Model::from_changed(&document)
    }

    /// The failed expectations.
    pub fn check(&self, found: &Diagnosis) -> Vec<UnmetDiagnosis> {
        self.expectation.check(found)
    }
}

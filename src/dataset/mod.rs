//! Measured data: converts files to sampled signals, and reports or refuses what is wrong with them.
//!
//! A file with canonical columns needs no manifest: `time`, then `<joint>.position` and so on ([`CHANNEL_COLUMNS`]).
//! Any other layout gets a manifest (`schema = "lostmotion/dataset/1"`) beside it. One file is one session.
//! Unusable data are refused with file, row and column. Faults that can be repaired without inventing data are repaired
//! and reported as a [`Note`].

mod assemble;
mod bounds;
mod checks;
mod columns;
mod csv;
mod encoder_step;
mod guess;
mod manifest;
mod mat;
#[cfg(feature = "mcap")]
mod mcap;
mod meet;
#[cfg(feature = "parquet")]
mod parquet;
mod plan;
mod source_file;
mod survey;
mod table;
mod time_base;

use std::collections::HashMap;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

pub use self::columns::{CHANNEL_COLUMNS, column_of};
pub use self::csv::{text as csv_text, write as write_csv, write_rows as write_csv_rows};
pub use self::encoder_step::encoder_step;
pub use self::manifest::Manifest;
pub use self::meet::meet;
pub use self::plan::Controller;
pub use self::survey::{first_manifest, is_canonical, survey, survey_session};
pub use self::table::{Column, Table};

use crate::error::{Error, Place, Result};
use crate::robot::Model;
use crate::timeseries::TimeSeries;
use crate::units::JointKind;

/// Names and kinds of the joints that data may contain.
pub type JointKinds = [(String, JointKind)];

/// [rad or m] Lower and upper limit of the positions of joints, by name.
type JointLimits = HashMap<String, Limits>;

/// [rad or m] Lower and upper limit of the two positions of a joint.
struct Limits {
    /// Of its motor's axis.
    axis: [f64; 2],
    /// Of its link.
    link: [f64; 2],
}

/// One recording, checked.
#[derive(Debug, Clone)]
pub struct Session {
    /// The signals, SI, joint side.
    pub series: TimeSeries,
    /// Notes on what was found or repaired while reading.
    pub notes: Vec<Note>,
    /// The file with the samples.
    pub source: PathBuf,
    /// The machine's own controllers, one per joint of `series`, if the manifest gives them.
    pub controllers: Vec<Option<Controller>>,
}

/// A note about a file for its user.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The file.
    pub file: PathBuf,
    /// Where in it.
    pub place: Place,
    /// The column; empty if the note is about all columns.
    pub column: String,
    /// What was found, and what was done about it.
    pub text: String,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        match self.place {
            Place::File => {}
            Place::Line(line) => write!(f, ":{line}")?,
            Place::Row(row) => write!(f, ": row {row}")?,
        }
        if !self.column.is_empty() {
            write!(f, ": {}", self.column)?;
        }
        write!(f, ": {}", self.text)
    }
}

/// The joints of a model, in the form that the readers need.
pub fn joints_of(model: &Model) -> Vec<(String, JointKind)> {
    model.joints.iter().map(|joint| (joint.name.clone(), joint.kind)).collect()
}

/// Reads a recording: a manifest (`.toml`), or a file with canonical columns (`.csv`, `.mat`, `.parquet`, `.mcap`).
///
/// # Errors
/// The file is not a regular file of bounded size, its format is unknown, or its content cannot be used: the error
/// names file, row and column.
pub fn load(path: &Path, joints: &JointKinds) -> Result<Session> {
    load_with(path, |_| joints.to_vec(), |_| joints.to_vec(), &JointLimits::new())
}

/// As [`load`], for the joints of a model; positions outside their limits are noted.
///
/// # Errors
/// As [`load`].
pub fn load_for(path: &Path, model: &Model) -> Result<Session> {
    let joints = joints_of(model);
    let limits = model.robot.bodies.iter().enumerate().map(|(index, body)| {
        let link = &body.joint.limits;
        let limits = Limits { axis: model.robot.axis_range(index), link: [link.lower, link.upper] };
        (body.joint.name.clone(), limits)
    });
    load_with(path, |_| joints.clone(), |_| joints.clone(), &limits.collect())
}

/// Reads a recording without a model: whether a joint turns or slides follows from its units and channels.
///
/// # Errors
/// As [`load`], except for joints that the model lacks.
pub fn load_alone(path: &Path) -> Result<Session> {
    load_with(path, guess::joints_of_manifest, guess::joints_of_table, &JointLimits::new())
}

fn load_with(
    path: &Path,
    of_manifest: impl Fn(&Manifest) -> Vec<(String, JointKind)>,
    of_table: impl Fn(&Table) -> Vec<(String, JointKind)>,
    limits: &JointLimits,
) -> Result<Session> {
    let (table, plan) = if extension(path) == "toml" {
        check_manifest(path)?;
        let manifest = Manifest::read(path)?;
        let plan = manifest.plan(&of_manifest(&manifest))?;
        (read_table(&manifest.file)?, plan)
    } else {
        let table = read_table(path)?;
        let plan = columns::canonical_plan(&table, &of_table(&table))?;
        (table, plan)
    };
    assemble::assemble(table, plan, limits)
}

/// Refuses a file that is not regular, or too large for a manifest, a model or a scenario, before it is read.
///
/// # Errors
/// As stated. A file that does not exist is left to its reader.
pub fn check_manifest(path: &Path) -> Result<()> {
    match source_file::check(path, source_file::MAX_MANIFEST_BYTES) {
        Err(Error::File { source, .. }) if source.kind() == io::ErrorKind::NotFound => Ok(()),
        checked => checked,
    }
}

/// Reads all columns of a data file, without units and without checks of their content.
///
/// # Errors
/// The file is not a regular file of bounded size, cannot be read, or its format is unknown.
pub fn read_table(path: &Path) -> Result<Table> {
    match extension(path).as_str() {
        "csv" => csv::read(path),
        "mat" => mat::read(path),
        #[cfg(feature = "parquet")]
        "parquet" => parquet::read(path),
        #[cfg(feature = "mcap")]
        "mcap" => mcap::read(path),
        other => Err(unknown_format(path, other)),
    }
}

/// As [`read_table`], from bytes in memory. `path` is the name that errors use; its extension determines the format.
///
/// # Errors
/// The format is unknown, or the bytes do not follow it.
pub fn parse_table(path: &Path, bytes: &[u8]) -> Result<Table> {
    match extension(path).as_str() {
        "csv" => csv::parse_bytes(path, bytes),
        "mat" => mat::parse(path, bytes),
        #[cfg(feature = "parquet")]
        "parquet" => parquet::parse(path, bytes),
        #[cfg(feature = "mcap")]
        "mcap" => mcap::parse(path, bytes),
        other => Err(unknown_format(path, other)),
    }
}

/// A recording with canonical columns from bytes in memory, as [`load_alone`].
///
/// # Errors
/// As [`load_alone`].
pub fn parse_alone(path: &Path, bytes: &[u8]) -> Result<Session> {
    let table = parse_table(path, bytes)?;
    let plan = columns::canonical_plan(&table, &guess::joints_of_table(&table))?;
    assemble::assemble(table, plan, &JointLimits::new())
}

fn unknown_format(path: &Path, format: &str) -> Error {
    let found = if format.is_empty() { "no extension" } else { format };
    let mut expected = String::from("a file of data: .csv, .mat (MATLAB 5), ");
    for (format, built) in [("parquet", cfg!(feature = "parquet")), ("mcap", cfg!(feature = "mcap"))] {
        let without = if built { "" } else { " (this build lacks the feature of that name)" };
        expected += &format!(".{format}{without}, ");
    }
    Error::input(path, Place::File, "format", found, expected + "or a manifest .toml")
}

fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

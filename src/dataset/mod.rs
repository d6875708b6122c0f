//! Measured data: converts files to sampled signals, and reports or refuses what is wrong with them.
//!
//! A file with canonical columns needs no manifest: `time`, then `<joint>.position` and so on ([`CHANNEL_COLUMNS`]).
//! Where the names of other columns are clear (`names`, `words`, `layout`), they are read, and a note lists them. Any
//! other layout gets a manifest (`schema = "lostmotion/dataset/1"`) beside it. One file is one session.
//! Unusable data are refused with file, row and column. Faults that can be repaired without inventing data are repaired
//! and reported as a [`Note`].

mod assemble;
mod bounds;
mod checks;
mod columns;
mod csv;
mod date_time;
#[cfg(feature = "db3")]
mod db3;
mod derivative;
mod encoder_step;
mod first_manifest;
mod format;
mod guess;
mod json;
mod layout;
mod manifest;
mod mat;
#[cfg(feature = "mcap")]
mod mcap;
mod meet;
mod names;
mod numpy;
#[cfg(feature = "parquet")]
mod parquet;
mod plan;
#[cfg(any(feature = "mcap", feature = "db3"))]
mod ros;
mod source_file;
mod survey;
mod table;
mod time_base;
mod time_column;
mod unit_words;
mod words;

use std::collections::HashMap;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

pub use self::columns::{CHANNEL_COLUMNS, column_of};
pub use self::csv::{write as write_csv, write_rows as write_csv_rows, written as csv_text};
pub use self::encoder_step::encoder_step;
pub use self::first_manifest::first_manifest;
pub use self::manifest::Manifest;
pub use self::meet::meet;
pub use self::plan::Controller;
pub use self::survey::{Readable, readable, survey, survey_session};
pub use self::table::{Column, Table};

use self::csv::Text;
use self::format::Format;
use self::layout::Layout;
use self::plan::Plan;

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
    /// For the axis of its motor.
    axis: [f64; 2],
    /// For its link.
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
    /// Place in the file.
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

/// Reads a recording: a manifest (`.toml`), or a file of data whose columns have canonical or clear names.
///
/// # Errors
/// The file is not a regular file of bounded size, its format is unknown, or its content cannot be used: the error
/// names file, row and column.
pub fn load(path: &Path, joints: &JointKinds) -> Result<Session> {
    load_with(path, Some(joints), &JointLimits::new())
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
    load_with(path, Some(&joints), &limits.collect())
}

/// Reads a recording without a model: whether a joint turns or slides follows from its units and channels.
///
/// # Errors
/// As [`load`], except for joints that the model lacks.
pub fn load_alone(path: &Path) -> Result<Session> {
    load_with(path, None, &JointLimits::new())
}

fn load_with(path: &Path, model: Option<&JointKinds>, limits: &JointLimits) -> Result<Session> {
    let (table, plan) = if is_manifest(path) {
        check_manifest(path)?;
        let manifest = Manifest::read(path)?;
        let own = model.is_none().then(|| guess::joints_of_manifest(&manifest));
        let plan = manifest.plan(own.as_deref().or(model).unwrap_or_default())?;
        (read_table(&manifest.file)?, plan)
    } else {
        let table = read_table(path)?;
        let plan = plan_of(&table, model)?;
        (table, plan)
    };
    assemble::assemble(table, plan, limits)
}

/// The columns of a file without a manifest: canonical ones, or ones whose names are clear. Without a model, the
/// joints are those of the file.
///
/// # Errors
/// A doubt remains; the message states it and asks for a manifest.
fn plan_of(table: &Table, model: Option<&JointKinds>) -> Result<Plan> {
    check_content(table)?;
    let own = model.is_none().then(|| guess::joints_of_table(table));
    if let Some(plan) = columns::canonical_plan(table, own.as_deref().or(model).unwrap_or_default())? {
        return Ok(plan);
    }
    Layout::of(table).plan(table, model)
}

/// Refuses a table that holds no data.
///
/// # Errors
/// It has no columns of numbers, or fewer than two rows.
fn check_content(table: &Table) -> Result<()> {
    let refuse =
        |key: &str, value: String, expected: &str| Err(Error::input(&table.file, Place::File, key, value, expected));
    if table.columns.is_empty() {
        return refuse(
            "columns",
            "none".into(),
            "columns of numbers: a time, and positions and currents or torques of joints",
        );
    }
    if table.rows() < 2 {
        return refuse("rows", table.rows().to_string(), "at least 2 rows of samples");
    }
    let names: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
    if table.columns.iter().all(|column| column.fault.as_ref().is_some_and(|fault| fault.0 == 1)) {
        return refuse("columns", table::list(&names), "columns of numbers; these hold none");
    }
    Ok(())
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

/// Reads all columns of a data file, without units and without checks of their content. The format is recognised by the
/// first bytes.
///
/// # Errors
/// The file is not a regular file of bounded size, cannot be read, or its format is not read.
pub fn read_table(path: &Path) -> Result<Table> {
    read_as(Text::File(path))
}

/// As [`read_table`], from bytes in memory. `path` is the name that errors use.
///
/// # Errors
/// The format is not read, or the bytes do not follow it.
pub fn parse_table(path: &Path, bytes: &[u8]) -> Result<Table> {
    read_as(Text::Memory(path, bytes))
}

fn read_as(text: Text<'_>) -> Result<Table> {
    let format = format::of(text)?;
    match (format, text) {
        (Format::Text, _) => csv::read(text),
        (Format::Json, _) => json::read(text),
        (Format::Npy, _) => numpy::read_array(text),
        (Format::Npz, _) => numpy::read_archive(text),
        (Format::Mat, Text::File(path)) => mat::read(path),
        (Format::Mat, Text::Memory(path, bytes)) => mat::parse(path, bytes),
        #[cfg(feature = "parquet")]
        (Format::Parquet, Text::File(path)) => parquet::read(path),
        #[cfg(feature = "parquet")]
        (Format::Parquet, Text::Memory(path, bytes)) => parquet::parse(path, bytes),
        #[cfg(feature = "mcap")]
        (Format::Mcap, Text::File(path)) => mcap::read(path),
        #[cfg(feature = "mcap")]
        (Format::Mcap, Text::Memory(path, bytes)) => mcap::parse(path, bytes),
        #[cfg(feature = "db3")]
        (Format::Db3, Text::File(path)) => db3::read(path),
        #[cfg(feature = "db3")]
        (Format::Db3, Text::Memory(path, bytes)) => db3::parse(path, bytes),
        #[cfg(not(all(feature = "parquet", feature = "mcap", feature = "db3")))]
        (other, _) => {
            let expected =
                "another format: this build lacks the feature of that name (build without --no-default-features)";
            Err(Error::input(text.path(), Place::File, "format", format!("{other:?}").to_lowercase(), expected))
        }
    }
}

/// A recording without a manifest from bytes in memory, as [`load_alone`].
///
/// # Errors
/// As [`load_alone`].
pub fn parse_alone(path: &Path, bytes: &[u8]) -> Result<Session> {
    session_of(parse_table(path, bytes)?)
}

/// The recording in a table, as [`load_alone`].
///
/// # Errors
/// As [`load_alone`].
pub fn session_of(table: Table) -> Result<Session> {
    let plan = plan_of(&table, None)?;
    assemble::assemble(table, plan, &JointLimits::new())
}

/// Whether a file is a manifest, by its name.
pub fn is_manifest(path: &Path) -> bool {
    extension(path) == "toml"
}

fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

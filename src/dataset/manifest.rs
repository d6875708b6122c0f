//! The manifest: maps columns of any file to channels and units.
//!
//! ```toml
//! schema = "lostmotion/dataset/1"
//! file = "emps/DATA_EMPS.mat"       # relative to this manifest, else to the folder named by LOSTMOTION_DATA
//! source = "who recorded it"
//! [time]
//! column = "t"                      # or its number in the file, from 1
//! unit = "ms"                       # s, ms, us, ns, d; absent: SI, and refused where its steps tell another unit
//! nanoseconds = "t_ns"              # where `column` holds whole seconds; then without a unit
//! [joints.carriage]
//! position = { column = "qm" }                       # unit: SI where not given
//! force = { column = "vir", unit = "V", scale = 35.15065 }    # times scale
//! [joints.carriage.controller]                       # the machine's own, for a replay in closed loop
//! position_gain = 160.18
//! velocity_gain = 8557.4
//! velocity_samples = 2
//! ```

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::JointKinds;
use super::columns::{CHANNEL_COLUMNS, channel_names, column_of, conversion, session_name};
use super::plan::{Controller, Plan, PlannedJoint, Source};
use super::source_file::MAX_COLUMNS;
use super::table::list;
use crate::error::{Error, Result};
use crate::timeseries::Channel;
use crate::toml_input::{Document, Range, Table, nearest};
use crate::units::{Dimension, JointKind, unit};

/// Schema of a manifest.
const SCHEMA: &str = "lostmotion/dataset/1";

/// Longest difference quotient of a controller [samples].
const MAX_VELOCITY_SAMPLES: i64 = 1000;

/// Allowed scales: the finest unit in use, nm or µA, is 1e-9 of the SI unit, and the counts of a 24-bit converter
/// divide it by another 1e7.
const SMALLEST_SCALE: f64 = 1e-16;
const LARGEST_SCALE: f64 = 1e16;

/// A manifest as it was read.
#[derive(Debug)]
pub struct Manifest {
    /// The data file.
    pub file: PathBuf,
    /// Who recorded it.
    pub source: Option<String>,
    document: Document,
}

impl Manifest {
    /// Reads a manifest and finds its file of data.
    ///
    /// # Errors
    /// The manifest cannot be read, has another schema, or its file does not exist.
    pub fn read(path: &Path) -> Result<Self> {
        let document = Document::read(path)?;
        let root = document.root();
        if root.text("schema")? != SCHEMA {
            return Err(root.error("schema", format!("\"{SCHEMA}\"")));
        }
        let file = root.recording("file", root.text("file")?)?;
        let source = root.optional_text("source")?.map(str::to_owned);
        Ok(Self { file, source, document })
    }

    /// The parsed file.
    pub(super) fn document(&self) -> &Document {
        &self.document
    }

    /// The columns of the channels.
    ///
    /// # Errors
    /// A joint that the model lacks, a channel that its joint cannot have, a unit that does not fit, an unknown key.
    pub(super) fn plan(&self, joints: &JointKinds) -> Result<Plan> {
        let root = self.document.root();
        for known in ["schema", "file", "source"] {
            root.has(known);
        }
        let (time, nanoseconds, time_unit) = time_source(&root.table("time")?)?;
        let kinds: HashMap<&str, JointKind> = joints.iter().map(|(name, kind)| (name.as_str(), *kind)).collect();
        let mut planned = Vec::new();
        for (name, table) in root.table("joints")?.named_tables()? {
            let Some(&kind) = kinds.get(name) else {
                return Err(unknown_joint(&root, name, &table, joints));
            };
            let channels = channels(&table, kind)?;
            let controller = table.optional_table("controller")?.map(|table| controller(&table)).transpose()?;
            table.finish()?;
            if channels.is_empty() {
                return Err(Error::input(root.file(), table.place(""), table.path(), "", channel_names(kind)));
            }
            planned.push(PlannedJoint { name: name.to_owned(), kind, channels, controller });
        }
        root.finish()?;
        if planned.is_empty() {
            return Err(root.error("joints", "at least one joint of the model"));
        }
        let name = session_name(root.file());
        Ok(Plan { name, time, nanoseconds, time_unit, joints: planned, notes: Vec::new() })
    }
}

/// The column of the time, that of its nanoseconds if there is one, and its unit if one is given.
fn time_source(table: &Table<'_>) -> Result<(Source, Option<Source>, Option<String>)> {
    let nanoseconds = if table.has("nanoseconds") { Some(source(table, "nanoseconds", 1e-9)?) } else { None };
    let source = source(table, "column", 1.0)?;
    if nanoseconds.is_some() && table.has("unit") {
        return Err(table.error("unit", "no unit: with `nanoseconds`, the column holds whole seconds"));
    }
    let given = table.optional_text("unit")?;
    let factor = match given.map(unit) {
        None => 1.0,
        Some(Some((Dimension::Time, factor))) => factor,
        Some(_) => return Err(table.error("unit", "a unit of time: s, ms, us, ns, d")),
    };
    table.finish()?;
    Ok((Source { factor, ..source }, nanoseconds, given.map(str::to_owned)))
}

/// The column that a key names, or gives by its number.
fn source(table: &Table<'_>, key: &str, factor: f64) -> Result<Source> {
    let named_at = Some((table.file().to_owned(), table.place(key), format!("{}.{key}", table.path())));
    // A text is the name, an integer the place in the file.
    let (column, number) = match table.optional_integer(key, 1, MAX_COLUMNS as i64) {
        Ok(Some(number)) => (number.to_string(), usize::try_from(number).ok()),
        _ => (table.text(key)?.to_owned(), None),
    };
    Ok(Source { column, number, factor, named_at })
}

fn channels(joint: &Table<'_>, kind: JointKind) -> Result<Vec<(Channel, Source)>> {
    let mut channels: Vec<(Channel, Source)> = Vec::new();
    for (name, _) in CHANNEL_COLUMNS {
        let Some(channel) = column_of(name, kind) else {
            if joint.has(name) {
                return Err(joint.error(name, channel_names(kind)));
            }
            continue;
        };
        let Some(table) = joint.optional_table(name)? else { continue };
        if channels.iter().any(|(known, _)| *known == channel) {
            return Err(joint.error(name, "each channel of a joint once"));
        }
        let scale = table.number_or("scale", &Range::any("SI per unit"), 1.0)?;
        if !(SMALLEST_SCALE..=LARGEST_SCALE).contains(&scale.abs()) {
            let expected = format!("a number other than zero, of a size from {SMALLEST_SCALE:e} to {LARGEST_SCALE:e}");
            return Err(table.error("scale", expected));
        }
        let factor = match table.optional_text("unit")? {
            None => 1.0,
            Some(name) => {
                conversion(name, channel, kind, table.has("scale")).map_err(|expected| table.error("unit", expected))?
            }
        };
        channels.push((channel, source(&table, "column", factor * scale)?));
        table.finish()?;
    }
    Ok(channels)
}

fn controller(table: &Table<'_>) -> Result<Controller> {
    let controller = Controller {
        position_gain: table.number("position_gain", &Range::positive("1/s"))?,
        velocity_gain: table.number("velocity_gain", &Range::positive("N·m·s/rad or N·s/m"))?,
        velocity_samples: table
            .optional_integer("velocity_samples", 1, MAX_VELOCITY_SAMPLES)?
            .and_then(|samples| usize::try_from(samples).ok())
            .unwrap_or(1),
    };
    table.finish()?;
    Ok(controller)
}

fn unknown_joint(root: &Table<'_>, name: &str, table: &Table<'_>, joints: &JointKinds) -> Error {
    let names: Vec<&str> = joints.iter().map(|joint| joint.0.as_str()).collect();
    let meant = nearest(name, names.iter().copied()).map_or(String::new(), |name| format!("; `{name}` is near"));
    let expected = format!("a joint of the model: {}{meant}", list(&names));
    Error::input(root.file(), table.place(""), "joints", name, expected)
}

//! Maps columns of a file to channels of joints: names, units, scale.

use std::collections::HashMap;
use std::path::Path;

use super::plan::{Plan, PlannedJoint, Source};
use super::table::{Column, Table, list};
use super::unit_words::{bare, unit_of};
use super::{JointKinds, Note, time_column};
use crate::error::{Error, Place, Result};
use crate::timeseries::Channel;
use crate::units::{Dimension, JointKind, UNITS, unit};

/// Name of a channel in canonical columns, `<joint>.<name>`, and in manifests.
pub const CHANNEL_COLUMNS: [(&str, Channel); 13] = [
    ("position", Channel::Position),
    ("velocity", Channel::Velocity),
    ("current", Channel::Current),
    ("torque", Channel::Torque),
    ("force", Channel::Torque),
    ("effort", Channel::Torque),
    ("reference_position", Channel::ReferencePosition),
    ("reference_velocity", Channel::ReferenceVelocity),
    ("command_current", Channel::CommandCurrent),
    ("link_position", Channel::LinkPosition),
    ("link_torque", Channel::LinkTorque),
    ("link_force", Channel::LinkTorque),
    ("temperature", Channel::Temperature),
];

/// What a user should know of an effort.
pub(super) const EFFORT: &str = "taken as a torque [N·m] or a force [N], as ROS defines an effort; if the driver puts a current there, say so \
                                 in a manifest with `current = { column = ... }`";

/// Channel of a canonical name, if it fits the kind of the joint: `force` for sliding joints, `torque` for turning
/// ones, `effort` for both.
pub fn column_of(name: &str, kind: JointKind) -> Option<Channel> {
    let misfits = match kind {
        JointKind::Revolute => ["force", "link_force"],
        JointKind::Prismatic => ["torque", "link_torque"],
    };
    CHANNEL_COLUMNS.iter().find(|(known, _)| *known == name && !misfits.contains(&name)).map(|&(_, channel)| channel)
}

/// Physical quantity of a channel at a joint of that kind.
fn dimension(channel: Channel, kind: JointKind) -> Option<Dimension> {
    let turning = kind == JointKind::Revolute;
    match channel {
        Channel::Position | Channel::ReferencePosition | Channel::LinkPosition => {
            Some(if turning { Dimension::Angle } else { Dimension::Length })
        }
        Channel::Velocity | Channel::ReferenceVelocity => {
            Some(if turning { Dimension::AngularVelocity } else { Dimension::Velocity })
        }
        Channel::Current | Channel::CommandCurrent => Some(Dimension::Current),
        Channel::Torque | Channel::LinkTorque => Some(if turning { Dimension::Torque } else { Dimension::Force }),
        Channel::Temperature => Some(Dimension::Temperature),
        _ => None,
    }
}

/// Factor from the file's unit to SI for a channel; the error lists the units that would fit.
///
/// Volts are accepted for a current or a torque if a scale converts them.
pub(super) fn conversion(
    name: &str,
    channel: Channel,
    kind: JointKind,
    scaled: bool,
) -> std::result::Result<f64, String> {
    let Some(wanted) = dimension(channel, kind) else { return Err("a measured channel".into()) };
    let drives = matches!(channel, Channel::Current | Channel::CommandCurrent | Channel::Torque | Channel::LinkTorque);
    match unit(name) {
        Some((found, factor)) if found == wanted => Ok(factor),
        Some((Dimension::Voltage, factor)) if drives && scaled => Ok(factor),
        _ => Err(fitting_units(wanted, drives)),
    }
}

fn fitting_units(wanted: Dimension, drives: bool) -> String {
    let names: Vec<&str> = UNITS.iter().filter(|entry| entry.1 == wanted).map(|entry| entry.0).collect();
    let volts = if drives { ", or V with a scale" } else { "" };
    format!("a unit of this quantity: {}{volts}", names.join(", "))
}

/// Name of a session: the file's stem.
pub(super) fn session_name(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    // `run.csv.gz` is `run`.
    let packed = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gz"));
    if packed { session_name(Path::new(&stem)) } else { stem }
}

/// Finds the canonical columns of a file; `None` if it has none of these joints.
///
/// # Errors
/// There is no time, or a channel that does not fit its joint.
pub(super) fn canonical_plan(table: &Table, joints: &JointKinds) -> Result<Option<Plan>> {
    let kinds: HashMap<&str, JointKind> = joints.iter().map(|(name, kind)| (name.as_str(), *kind)).collect();
    let found = time_column::find(table).filter(|time| time.guess.is_none());
    let is_time = |name: &str| {
        let own = |at: usize| table.columns[at].name == name;
        name == "time" || found.as_ref().is_some_and(|time| own(time.column) || time.nanoseconds.is_some_and(own))
    };
    let mut planned: Vec<PlannedJoint> = Vec::new();
    let mut places: HashMap<&str, usize> = HashMap::new();
    let mut unknown = Vec::new();
    for column in table.columns.iter().filter(|column| !is_time(&column.name)) {
        let parts = column.name.rsplit_once('.');
        let known = parts.and_then(|(joint, name)| Some((joint, *kinds.get(joint)?, name)));
        let Some((joint, kind, name)) = known else {
            unknown.push(column.name.as_str());
            continue;
        };
        let refuse = |expected: String| Error::input(&table.file, Place::Line(1), "column", &column.name, expected);
        let Some(channel) = column_of(name, kind) else { return Err(refuse(channel_names(kind))) };
        let index = *places.entry(joint).or_insert_with(|| {
            planned.push(PlannedJoint { name: joint.to_owned(), kind, channels: Vec::new(), controller: None });
            planned.len() - 1
        });
        if planned[index].has(channel) {
            return Err(refuse("each channel of a joint once".into()));
        }
        let factor = stated_factor(column, channel, kind).map_err(refuse)?;
        planned[index].channels.push((channel, Source { factor, ..Source::named(&column.name) }));
    }
    if planned.is_empty() {
        return Ok(None);
    }
    let mut notes = Vec::new();
    let efforts: Vec<&str> = table
        .columns
        .iter()
        .map(|column| column.name.as_str())
        .filter(|name| name.rsplit_once('.').is_some_and(|(joint, name)| name == "effort" && kinds.contains_key(joint)))
        .collect();
    if !efforts.is_empty() {
        let text = format!("{}: {EFFORT}", list(&efforts));
        notes.push(Note { file: table.file.clone(), place: Place::File, column: String::new(), text });
    }
    if !unknown.is_empty() {
        let text = format!("columns left out because they belong to no joint of the model: {}", list(&unknown));
        notes.push(Note { file: table.file.clone(), place: Place::Line(1), column: String::new(), text });
    }
    let name = |at: usize| table.columns[at].name.as_str();
    let (time, nanoseconds, time_unit) = match &found {
        None => (Source::named("time"), None, None),
        Some(time) => {
            let (factor, unit) = time.factor();
            if name(time.column) != "time" || unit.is_some() {
                let second = time.nanoseconds.map_or(String::new(), |at| format!(" and {}", name(at)));
                let text = format!("taken as the time: {}{second}{}", name(time.column), time.said());
                notes.push(Note { file: table.file.clone(), place: Place::File, column: String::new(), text });
            }
            let nanoseconds = time.nanoseconds.map(|at| Source { factor: 1e-9, ..Source::named(name(at)) });
            (Source { factor, ..Source::named(name(time.column)) }, nanoseconds, unit)
        }
    };
    let name = session_name(&table.file);
    Ok(Some(Plan { name, time, nanoseconds, time_unit, joints: planned, notes }))
}

/// Factor to SI from the unit that a row below the header states for a canonical column; 1 where there is none.
fn stated_factor(column: &Column, channel: Channel, kind: JointKind) -> std::result::Result<f64, String> {
    let Some(text) = column.unit.as_deref().map(bare).filter(|text| !text.is_empty()) else { return Ok(1.0) };
    match unit_of(text) {
        Some(unit) => conversion(unit.name, channel, kind, false).map(|factor| factor * unit.scale),
        None => Err(format!("a unit that is known in the row below the header, not {text}")),
    }
}

/// The channels that a joint of that kind can have.
pub(super) fn channel_names(kind: JointKind) -> String {
    let names: Vec<&str> =
        CHANNEL_COLUMNS.iter().map(|entry| entry.0).filter(|name| column_of(name, kind).is_some()).collect();
    format!("one of the channels {}", names.join(", "))
}

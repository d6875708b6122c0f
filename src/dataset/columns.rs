//! From columns of a file to channels of joints: names, units, scale.

use std::path::{Path, PathBuf};

use super::manifest::Controller;
use super::table::{Table, list};
use super::{JointKinds, Note, Session, checks};
use crate::error::{Error, Place, Result};
use crate::timeseries::{Channel, JointSeries, Samples, TimeSeries};
use crate::units::{Dimension, JointKind, UNITS, unit};

/// Name of a channel in canonical columns, `<joint>.<name>`, and in manifests.
pub const CHANNEL_COLUMNS: [(&str, Channel); 11] = [
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
    ("temperature", Channel::Temperature),
];

/// Channel of a canonical name, where it fits the kind of the joint: `force` slides, `torque` turns, `effort` does either.
pub fn column_of(name: &str, kind: JointKind) -> Option<Channel> {
    let misfit = match kind {
        JointKind::Revolute => "force",
        JointKind::Prismatic => "torque",
    };
    CHANNEL_COLUMNS.iter().find(|(known, _)| *known == name && name != misfit).map(|&(_, channel)| channel)
}

/// What a channel measures at a joint of that kind.
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
        Channel::Torque => Some(if turning { Dimension::Torque } else { Dimension::Force }),
        Channel::Temperature => Some(Dimension::Temperature),
        _ => None,
    }
}

/// SI units of a channel in one unit of the file, or what units would fit.
///
/// Volts stand for a current or a torque where a scale says how much of it a volt is.
pub(super) fn conversion(
    name: &str,
    channel: Channel,
    kind: JointKind,
    scaled: bool,
) -> std::result::Result<f64, String> {
    let Some(wanted) = dimension(channel, kind) else { return Err("a measured channel".into()) };
    let drives = matches!(channel, Channel::Current | Channel::CommandCurrent | Channel::Torque);
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

/// A column, and what one unit of it is in SI.
#[derive(Debug, Clone)]
pub(super) struct Source {
    /// Name in the file.
    pub(super) column: String,
    /// SI per unit of the file.
    pub(super) factor: f64,
    /// Where a manifest names it: file, place, key.
    pub(super) named_at: Option<(PathBuf, Place, String)>,
}

/// Which columns make up a session.
#[derive(Debug)]
pub(super) struct Plan {
    /// Name of the session.
    pub(super) name: String,
    /// The time.
    pub(super) time: Source,
    /// The joints that were recorded.
    pub(super) joints: Vec<PlannedJoint>,
    /// What was noticed while planning.
    pub(super) notes: Vec<Note>,
}

/// Where the channels of a joint come from.
#[derive(Debug)]
pub(super) struct PlannedJoint {
    /// Name of the joint in the model.
    pub(super) name: String,
    /// Its channels.
    pub(super) channels: Vec<(Channel, Source)>,
    /// The machine's own controller of it.
    pub(super) controller: Option<Controller>,
}

impl PlannedJoint {
    fn has(&self, channel: Channel) -> bool {
        self.channels.iter().any(|(known, _)| *known == channel)
    }
}

/// Name of a session: the file's stem.
pub(super) fn session_name(path: &Path) -> String {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Finds the canonical columns of a file.
///
/// # Errors
/// There is no `time`, no channel of any joint, or a channel that does not fit its joint.
pub(super) fn canonical_plan(table: &Table, joints: &JointKinds) -> Result<Plan> {
    let source = |column: &str| Source { column: column.to_owned(), factor: 1.0, named_at: None };
    let mut planned: Vec<PlannedJoint> = Vec::new();
    let mut unknown = Vec::new();
    for column in table.columns.iter().filter(|column| column.name != "time") {
        let parts = column.name.rsplit_once('.');
        let known = parts.and_then(|(joint, name)| Some((joints.iter().find(|known| known.0 == joint)?, name)));
        let Some(((joint, kind), name)) = known else {
            unknown.push(column.name.as_str());
            continue;
        };
        let Some(channel) = column_of(name, *kind) else {
            let expected = channel_names(*kind);
            return Err(Error::input(&table.file, Place::Line(1), "column", &column.name, expected));
        };
        let index = planned.iter().position(|entry| entry.name == *joint).unwrap_or_else(|| {
            planned.push(PlannedJoint { name: joint.clone(), channels: Vec::new(), controller: None });
            planned.len() - 1
        });
        if planned[index].has(channel) {
            return Err(Error::input(
                &table.file,
                Place::Line(1),
                "column",
                &column.name,
                "each channel of a joint once",
            ));
        }
        planned[index].channels.push((channel, source(&column.name)));
    }
    if planned.is_empty() {
        let names: Vec<&str> = joints.iter().map(|joint| joint.0.as_str()).collect();
        let found: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
        let expected = format!(
            "canonical columns `<joint>.position`, `<joint>.current` ... of the joints {}, or a manifest that names the columns",
            list(&names)
        );
        return Err(Error::input(&table.file, Place::File, "columns", list(&found), expected));
    }
    let mut notes = Vec::new();
    if !unknown.is_empty() {
        let text = format!("columns of no joint of the model left out: {}", list(&unknown));
        notes.push(Note { file: table.file.clone(), place: Place::Line(1), column: String::new(), text });
    }
    Ok(Plan { name: session_name(&table.file), time: source("time"), joints: planned, notes })
}

/// The channels that a joint of that kind can have.
pub(super) fn channel_names(kind: JointKind) -> String {
    let names: Vec<&str> =
        CHANNEL_COLUMNS.iter().map(|entry| entry.0).filter(|name| column_of(name, kind).is_some()).collect();
    format!("one of the channels {}", names.join(", "))
}

/// Takes the planned columns out of a table and checks them.
///
/// # Errors
/// A column is missing, or its content cannot be used.
pub(super) fn assemble(mut table: Table, plan: Plan) -> Result<Session> {
    let mut notes = std::mem::take(&mut table.notes);
    notes.extend(plan.notes);
    let channels = plan.joints.iter().flat_map(|joint| joint.channels.iter().map(|(_, source)| source));
    let sources: Vec<&Source> = std::iter::once(&plan.time).chain(channels).collect();
    let mut signals: Vec<(String, Vec<f64>)> = Vec::with_capacity(sources.len());
    for (index, source) in sources.iter().enumerate() {
        let mut values = table.take_values(&source.column, source.named_at.as_ref())?;
        if sources[index + 1..].iter().any(|other| other.column == source.column) {
            table.give_back(&source.column, values.clone());
        }
        if source.factor != 1.0 {
            values.iter_mut().for_each(|value| *value *= source.factor);
        }
        signals.push((source.column.clone(), values));
    }
    table.columns.clear();
    checks::check(&table.file, &mut signals, &mut notes)?;

    let mut signals = signals.into_iter().map(|(_, values)| values);
    let time = signals.next().unwrap_or_default();
    let mut signals = signals.map(Samples::from);
    let mut controllers = Vec::new();
    let mut joints = Vec::new();
    for PlannedJoint { name, channels, controller } in plan.joints {
        let channels = channels.into_iter().map(|(channel, _)| channel).zip(signals.by_ref()).collect();
        joints.push(JointSeries { name, channels });
        controllers.push(controller);
    }
    let series = TimeSeries { name: plan.name, time, joints };
    Ok(Session { series, notes, source: table.file, controllers })
}

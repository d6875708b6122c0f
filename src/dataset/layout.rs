//! What the columns of a file without canonical names hold: the time, and the channels of joints.
//!
//! Columns whose names are clear are read, with notes on what each column was taken for. Anything else is a guess: it is
//! marked in a first manifest, and is not read until a user confirms it.

mod joints;

use std::collections::BTreeMap;

pub(super) use self::joints::assign;
use super::columns::{EFFORT, channel_names, column_of, conversion, session_name};
use super::names::{self, Named};
use super::plan::{Plan, PlannedJoint, Source};
use super::table::{Column, Table, list};
use super::time_column::{self, FoundTime};
use super::words::{Quantity, Role};
use super::{JointKinds, Note};
use crate::error::{Error, Place, Result};
use crate::units::{Dimension, JointKind};

/// [rad] Positions of a joint beyond this, two turns to either side, are likely degrees: the axes of arms turn less,
/// except the last axis of some arms.
const MANY_TURNS: f64 = 4.0 * std::f64::consts::PI;
/// [A] Currents beyond this are likely milliamperes: the drives of arms take less.
const MUCH_CURRENT: f64 = 500.0;

/// What was recognised in a table.
#[derive(Debug)]
pub(super) struct Layout {
    /// The time, if there is one.
    pub(super) time: Option<FoundTime>,
    /// The joints, in the order of the file.
    pub(super) joints: Vec<FoundJoint>,
    /// Indices of the columns that are not used.
    pub(super) left: Vec<usize>,
}

/// A joint of a file.
#[derive(Debug)]
pub(super) struct FoundJoint {
    /// Its name, as far as the file tells.
    pub(super) name: String,
    /// Its number, if it has one and nothing else distinguishes it from the others.
    pub(super) number: Option<u64>,
    /// Its channels.
    pub(super) channels: Vec<FoundChannel>,
}

/// A channel of a joint.
#[derive(Debug)]
pub(super) struct FoundChannel {
    /// Canonical name.
    pub(super) channel: &'static str,
    /// Index of its column.
    pub(super) column: usize,
    /// Unit of manifests, if the file states one, and its scale.
    pub(super) unit: Option<(&'static str, f64)>,
    /// Why it has to be confirmed.
    pub(super) guess: Option<String>,
    /// A remark for the user, although it is not a guess.
    pub(super) remark: Option<&'static str>,
}

impl Layout {
    /// Recognises the columns of a table.
    pub(super) fn of(table: &Table) -> Self {
        let time = time_column::find(table);
        let is_time = |at: usize| time.as_ref().is_some_and(|time| time.column == at || time.nanoseconds == Some(at));
        let mut named: Vec<(usize, Named)> = Vec::new();
        for (at, column) in table.columns.iter().enumerate().filter(|(at, _)| !is_time(*at) && !table.nameless) {
            if !column.is_foreign() {
                named.extend(names::read(column).map(|found| (at, found)));
            }
        }
        let joints = joints::group(table, &named);
        let mut taken = vec![false; table.columns.len()];
        joints.iter().flat_map(|joint| &joint.channels).for_each(|channel| taken[channel.column] = true);
        let left = (0..table.columns.len()).filter(|at| !is_time(*at) && !taken[*at]).collect();
        Self { time, joints, left }
    }

    /// Why the file is not read without a manifest; empty if it is.
    fn doubts(&self, table: &Table) -> Vec<String> {
        let mut doubts = Vec::new();
        match &self.time {
            None => doubts.push("no column is the time".to_owned()),
            Some(time) => {
                doubts.extend(time.guess.as_ref().map(|guess| format!("{}: {guess}", table.columns[time.column].name)))
            }
        }
        if self.joints.is_empty() {
            doubts.push("no column names a quantity of a joint".to_owned());
        }
        for channel in self.joints.iter().flat_map(|joint| &joint.channels) {
            let name = &table.columns[channel.column].name;
            doubts.extend(channel.guess.as_ref().map(|guess| format!("{name}: {guess}")));
        }
        doubts
    }

    /// The columns of a session, for the joints of the model; without a model, for those of the file.
    ///
    /// # Errors
    /// A doubt remains, or the joints of the file are not those of the model.
    pub(super) fn plan(self, table: &Table, model: Option<&JointKinds>) -> Result<Plan> {
        let Some(time) = self.time.as_ref().filter(|_| self.doubts(table).is_empty()) else {
            return Err(self.unclear(table, model));
        };
        let (places, numbered) = match model {
            Some(model) => joints::assign(&self.joints, model).ok_or_else(|| self.unclear(table, Some(model)))?,
            None => ((0..self.joints.len()).map(Some).collect(), false),
        };
        let own: Vec<(String, JointKind)> =
            self.joints.iter().map(|joint| (joint.name.clone(), joint.kind())).collect();
        let known = model.unwrap_or(&own);
        let mut notes = vec![note(table, self.summary(table, &places, known))];
        notes.extend(self.remarks(table, &places));
        if numbered {
            let names: Vec<&str> = self.joints.iter().map(|joint| joint.name.as_str()).collect();
            let text =
                format!("{} are matched with the joints of the model by their numbers, in its order", list(&names));
            notes.push(note(table, text));
        }
        let mut planned = Vec::new();
        for (joint, place) in self.joints.iter().zip(&places) {
            let Some((name, kind)) = place.and_then(|place| known.get(place)) else { continue };
            planned.push(joint.planned(table, name, *kind)?);
        }
        let source = |at: usize| Source::named(&table.columns[at].name);
        let (factor, unit) = time.factor();
        Ok(Plan {
            name: session_name(&table.file),
            time: Source { factor, ..source(time.column) },
            nanoseconds: time.nanoseconds.map(|at| Source { factor: 1e-9, ..source(at) }),
            time_unit: unit,
            joints: planned,
            notes,
        })
    }

    /// Which column was taken for which channel, in one line.
    fn summary(&self, table: &Table, places: &[Option<usize>], known: &JointKinds) -> String {
        let name = |at: usize| table.columns[at].name.as_str();
        let time = self.time.as_ref().map_or(String::new(), |time| {
            let second = time.nanoseconds.map_or(String::new(), |at| format!(" and {}", name(at)));
            format!("time = {}{second}{}", name(time.column), time.said())
        });
        let mut parts = vec![time];
        for (joint, place) in self.joints.iter().zip(places) {
            let Some((model, _)) = place.and_then(|place| known.get(place)) else { continue };
            let channels = joint.channels.iter().map(|channel| {
                let unit = match channel.unit {
                    Some((unit, 1.0)) => format!(" in {unit}"),
                    Some((unit, scale)) => format!(" in {scale} {unit}"),
                    None => String::new(),
                };
                format!("{} = {}{unit}", channel.channel, name(channel.column))
            });
            parts.push(format!("{model}: {}", channels.collect::<Vec<_>>().join(", ")));
        }
        let mut text = format!("taken as {}; units that are not named are SI", parts.join("; "));
        if !self.left.is_empty() {
            let names: Vec<&str> = self.left.iter().map(|at| name(*at)).collect();
            text += &format!("; left out: {}", list(&names));
        }
        text
    }

    /// Remarks for the user on the columns that were taken.
    fn remarks(&self, table: &Table, places: &[Option<usize>]) -> Vec<Note> {
        let mut said: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        let taken = self.joints.iter().zip(places).filter(|(_, place)| place.is_some());
        for channel in taken.flat_map(|(joint, _)| &joint.channels) {
            if let Some(remark) = channel.remark {
                said.entry(remark).or_default().push(&table.columns[channel.column].name);
            }
        }
        said.into_iter().map(|(remark, columns)| note(table, format!("{}: {remark}", list(&columns)))).collect()
    }

    /// Why the file is not read without a manifest, in one line; empty if it is.
    pub(super) fn why(&self, table: &Table) -> String {
        if table.nameless {
            return "the file has no names for its columns".to_owned();
        }
        let why = self.doubts(table);
        let more = if why.len() > 3 { format!(" and {} more", why.len() - 3) } else { String::new() };
        why[..why.len().min(3)].join("; ") + &more
    }

    /// The refusal of a file whose columns are not clear.
    fn unclear(&self, table: &Table, model: Option<&JointKinds>) -> Error {
        let found: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
        let of = model.map_or(String::new(), |model| {
            let names: Vec<&str> = model.iter().map(|joint| joint.0.as_str()).collect();
            format!(" of the joints {}", list(&names))
        });
        let mut why = self.why(table);
        if why.is_empty() {
            let names: Vec<&str> = self.joints.iter().map(|joint| joint.name.as_str()).collect();
            why = format!("the joints {} of the file are not those of the model", list(&names));
        }
        let expected = format!(
            "canonical columns `time`, `<joint>.position`, `<joint>.current` ...{of}, or a manifest that names the columns \
             (`lostmotion data FILE` prints a first one), because {why}"
        );
        Error::input(&table.file, Place::File, "columns", list(&found), expected)
    }
}

impl FoundJoint {
    /// Whether it turns or slides, by its channels and units.
    pub(super) fn kind(&self) -> JointKind {
        let slides = |channel: &FoundChannel| {
            let unit = channel.unit.and_then(|(name, _)| crate::units::unit(name)).map(|found| found.0);
            matches!(channel.channel, "force" | "link_force")
                || matches!(unit, Some(Dimension::Length | Dimension::Velocity | Dimension::Force))
        };
        if self.channels.iter().any(slides) { JointKind::Prismatic } else { JointKind::Revolute }
    }

    /// Its channels as those of a joint of that kind.
    fn planned(&self, table: &Table, name: &str, kind: JointKind) -> Result<PlannedJoint> {
        let mut channels = Vec::new();
        for found in &self.channels {
            let column = &table.columns[found.column].name;
            let refuse = |value: &str, expected: String| {
                Error::input(&table.file, Place::File, column, value, expected + ": say in a manifest what it is")
            };
            let channel = column_of(found.channel, kind).ok_or_else(|| refuse(found.channel, channel_names(kind)))?;
            let factor = match found.unit {
                None => 1.0,
                Some((unit, scale)) => {
                    scale * conversion(unit, channel, kind, false).map_err(|expected| refuse(unit, expected))?
                }
            };
            channels.push((channel, Source { factor, ..Source::named(column) }));
        }
        Ok(PlannedJoint { name: name.to_owned(), kind, channels, controller: None })
    }
}

/// The channel of a quantity in a role, with the guess to be confirmed and the remark for the user; `None` if no channel
/// fits.
fn channel_of(column: &Column, named: &Named) -> Option<(&'static str, Option<String>, Option<&'static str>)> {
    const SHAFT: &str = "at the motor: on the joint side already, or to be scaled by the gear ratio?";
    let amperes = named.unit.and_then(super::unit_words::FileUnit::si).is_some_and(|unit| unit.0 == Dimension::Current);
    let quantity = if amperes { Quantity::Current } else { named.quantity };
    let channel = match (quantity, named.role) {
        (Quantity::Position, Role::Reference) => "reference_position",
        (Quantity::Position, Role::Link) => "link_position",
        (Quantity::Position, _) => "position",
        (Quantity::Velocity, Role::Reference) => "reference_velocity",
        (Quantity::Velocity, Role::Actual | Role::Motor) => "velocity",
        (Quantity::Current, Role::Reference) => "command_current",
        (Quantity::Current, Role::Actual | Role::Motor) => "current",
        (Quantity::Torque, Role::Link) => "link_torque",
        (Quantity::Force, Role::Link) => "link_force",
        (Quantity::Torque, Role::Actual | Role::Motor) => "torque",
        (Quantity::Force, Role::Actual | Role::Motor) => "force",
        (Quantity::Effort, Role::Actual | Role::Motor) => "effort",
        (Quantity::Temperature, Role::Actual | Role::Motor) => "temperature",
        _ => return None,
    };
    let shaft = named.role == Role::Motor && !matches!(channel, "current" | "temperature");
    let most = column.values.iter().fold(0.0_f64, |most, value| most.max((value + column.origin as f64).abs()));
    let guess = if let Some(unit) = &named.strange_unit {
        Some(format!("[{unit}] is not a known unit: give `scale`, SI per count"))
    } else if let Some(guess) = named.guess {
        Some(guess.to_owned())
    } else if shaft {
        Some(SHAFT.to_owned())
    } else if named.unit.is_none() && named.quantity == Quantity::Position && most > MANY_TURNS {
        Some(format!("up to {most:.4}, too much for rad: degrees?"))
    } else if named.unit.is_none() && channel.ends_with("current") && most > MUCH_CURRENT {
        Some(format!("up to {most:.4}, too much for A: mA?"))
    } else if named.unit.is_some_and(|unit| unit.name == "V") {
        Some("in V: give `scale`, A or N·m per volt".to_owned())
    } else {
        None
    };
    Some((channel, guess, (channel == "effort").then_some(EFFORT)))
}

fn note(table: &Table, text: String) -> Note {
    Note { file: table.file.clone(), place: Place::File, column: String::new(), text }
}

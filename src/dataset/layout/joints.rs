//! Assigns columns to joints, and the joints of a file to the joints of a model.

use std::collections::HashMap;

use super::super::JointKinds;
use super::super::names::Named;
use super::super::table::Table;
use super::super::words::{Word, meaning};
use super::{FoundChannel, FoundJoint, channel_of};

/// The letters and digits of a name, in lower case.
fn folded(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Groups the columns of a table by joints.
pub(super) fn group(table: &Table, named: &[(usize, Named)]) -> Vec<FoundJoint> {
    let shared = shared_parts(named);
    let mut joints: Vec<FoundJoint> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    for (column, found) in named {
        let Some((channel, mut guess, remark)) = channel_of(&table.columns[*column], found) else { continue };
        let parts = &found.joint[shared.min(found.joint.len())..];
        let name = parts.join("/");
        let stem: String = folded(&name).chars().filter(|c| !c.is_numeric()).collect();
        // If the rest of the name is only a word for a list of joints, the number alone identifies the joint.
        let number = found.number.filter(|_| stem.is_empty() || stem == "j" || meaning(&stem) == Some(Word::Filler));
        let key = number.map_or_else(|| folded(&name), |number| number.to_string());
        let place = *places.entry(key).or_insert_with(|| {
            joints.push(FoundJoint { name: shown(&name), number: found.number, channels: Vec::new() });
            joints.len() - 1
        });
        let channels = &mut joints[place].channels;
        if let Some(other) = channels.iter().find(|other| other.channel == channel) {
            let other = &table.columns[other.column].name;
            // A column with the same values as another raises no doubt and is dropped.
            if table.columns[*column].values == table.column(other).map_or(&[][..], |other| &other.values) {
                continue;
            }
            guess = Some(format!("{other} is also taken for the {channel}: which of the two is it?"));
        }
        let unit = found.unit.map(|unit| (unit.name, unit.scale));
        channels.push(FoundChannel { channel, column: *column, unit, guess, remark });
    }
    // If some joints have a position, the others are not joints: a scaling of the speed, a current of a supply.
    let has_position = |joint: &FoundJoint| joint.channels.iter().any(|channel| channel.channel == "position");
    if joints.iter().any(has_position) {
        joints.retain(has_position);
    }
    joints
}

/// Name of a joint that may have a number alone, or no name.
fn shown(name: &str) -> String {
    match name {
        "" => "joint".to_owned(),
        number if number.bytes().all(|byte| byte.is_ascii_digit()) => format!("joint_{number}"),
        name => name.to_owned(),
    }
}

/// Number of parts at the beginning of the joints' names that all of them share: a topic, a structure. The last part is
/// never shared.
fn shared_parts(named: &[(usize, Named)]) -> usize {
    let names: Vec<&[String]> = named.iter().map(|(_, found)| found.joint.as_slice()).collect();
    let Some(first) = names.first() else { return 0 };
    let shared = |count: &usize| names.iter().all(|name| name.len() > *count && name[..*count] == first[..*count]);
    (0..first.len()).take_while(shared).last().unwrap_or(0)
}

/// The place of each joint in a model, by name or else by number, and whether it is by number; `None` if neither fits.
pub(in super::super) fn assign(joints: &[FoundJoint], model: &JointKinds) -> Option<(Vec<Option<usize>>, bool)> {
    let names: HashMap<String, usize> =
        model.iter().enumerate().map(|(place, (name, _))| (folded(name), place)).collect();
    // The whole name, or the end of it behind a slash.
    let by_name = |joint: &FoundJoint| {
        let last = joint.name.rsplit('/').next().unwrap_or_default();
        names.get(&folded(&joint.name)).or_else(|| names.get(&folded(last))).copied()
    };
    let places: Vec<Option<usize>> = joints.iter().map(by_name).collect();
    let mut taken: Vec<usize> = places.iter().flatten().copied().collect();
    taken.sort_unstable();
    taken.dedup();
    let distinct = taken.len() == places.iter().flatten().count();
    if distinct && places.iter().all(Option::is_some) {
        return Some((places, false));
    }
    if let Some(places) = by_number(joints, model.len()) {
        return Some((places, true));
    }
    if joints.len() == 1 && model.len() == 1 && joints[0].name == shown("") {
        return Some((vec![Some(0)], false));
    }
    // If joint 0 is not in the model, joint 1 may be the model's second joint.
    let shifted = joints.iter().zip(&places).any(|(joint, place)| joint.number == Some(0) && place.is_none());
    (distinct && !taken.is_empty() && !shifted).then_some((places, false))
}

/// The places of numbered joints, if the file has as many as the model and counts them from 0 or 1.
fn by_number(joints: &[FoundJoint], count: usize) -> Option<Vec<Option<usize>>> {
    let stem = |joint: &FoundJoint| -> String { folded(&joint.name).chars().filter(|c| !c.is_numeric()).collect() };
    let numbers: Vec<u64> = joints.iter().map(|joint| joint.number).collect::<Option<_>>()?;
    let first = *numbers.iter().min()?;
    let mut sorted = numbers.clone();
    sorted.sort_unstable();
    let counted = first <= 1 && sorted.len() == count && sorted.iter().zip(first..).all(|(a, b)| *a == b);
    let alike = joints.iter().all(|joint| stem(joint) == stem(&joints[0]));
    (counted && alike).then(|| numbers.iter().map(|number| Some((number - first) as usize)).collect())
}

//! Checks that the recordings of a command differ: a gain on the data of the fit means nothing.

use std::collections::{BTreeMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::dataset::Session;
use crate::error::{Error, Place, Result};
use crate::timeseries::{Channel, JointSeries};

/// Number of consecutive equal rows that prove that two recordings overlap, and the least share of different positions
/// among them: at rest, the counts of an encoder repeat anyway.
const WINDOW: usize = 256;
const MOVING: f64 = 0.25;

/// The option of some recordings, and the recordings.
type Given<'a, T> = (&'a str, &'a [T]);

/// Refuses a file that is given twice.
///
/// # Errors
/// As stated.
pub fn of_files(given: [Given<'_, PathBuf>; 3]) -> Result<()> {
    let mut seen: BTreeMap<PathBuf, &str> = BTreeMap::new();
    for (flag, file) in given.iter().flat_map(|(flag, files)| files.iter().map(move |file| (*flag, file))) {
        // A missing file is refused when it is read.
        let Ok(place) = fs::canonicalize(file) else { continue };
        if let Some(before) = seen.insert(place, flag) {
            return Err(refusal(file, flag, "the same file", before));
        }
    }
    Ok(())
}

/// Refuses two recordings with the same name, because results are distinguished by it.
///
/// # Errors
/// As stated.
pub fn of_names(given: &[Given<'_, Session>]) -> Result<()> {
    let mut seen: BTreeMap<&str, &Path> = BTreeMap::new();
    for (flag, session) in each(given) {
        let name = session.series.name.as_str();
        if let Some(other) = seen.insert(name, &session.source) {
            let expected = format!(
                "a name of its own for each session, and {} has this one: rename a file, or give it a manifest of another name",
                other.display()
            );
            return Err(Error::input(&session.source, Place::File, *flag, name, expected));
        }
    }
    Ok(())
}

/// Refuses recordings that hold the same samples of a joint, whole or in part.
///
/// # Errors
/// As stated.
pub fn of_samples(given: &[Given<'_, Session>]) -> Result<()> {
    let all: Vec<(&str, &Session)> = each(given).map(|(flag, session)| (*flag, session)).collect();
    for (at, (flag, session)) in all.iter().enumerate() {
        for (before, other) in &all[..at] {
            if let Some(joint) = session.series.joints.iter().find(|joint| {
                other
                    .series
                    .joint(&joint.name)
                    .is_some_and(|there| same_samples(joint, there) || same_samples(there, joint))
            }) {
                let what = format!("samples of {} that are in {} too", joint.name, other.source.display());
                return Err(refusal(&session.source, flag, &what, before));
            }
        }
    }
    Ok(())
}

fn each<'a>(given: &'a [Given<'_, Session>]) -> impl Iterator<Item = (&'a &'a str, &'a Session)> {
    given.iter().flat_map(|(flag, sessions)| sessions.iter().map(move |session| (flag, session)))
}

fn refusal(file: &Path, flag: &str, what: &str, before: &str) -> Error {
    let expected = match (flag, before) {
        ("--hold-out", "--data") => {
            "recordings that are not in --data: a gain on data that took part in the fit says nothing"
        }
        ("--reference", _) => {
            "recordings of the healthy machine that are not among the others: they would show no change"
        }
        _ => "each recording once: given twice, it counts twice and makes errors look smaller than they are",
    };
    Error::input(file, Place::File, flag, what, expected)
}

/// Whether rows of `part` in which the joint moves are rows of `whole`.
fn same_samples(part: &JointSeries, whole: &JointSeries) -> bool {
    let (Some(part), Some(whole)) = (measured(part), measured(whole)) else { return false };
    let length = WINDOW.min(part[0].len());
    let row = |columns: &[&[f64]; 2], row: usize| columns.map(|column| column[row].to_bits());
    let moves = |first: &usize| {
        let positions: HashSet<u64> = (*first..first + length).map(|at| part[0][at].to_bits()).collect();
        positions.len() as f64 >= (MOVING * length as f64).max(2.0)
    };
    // The search starts in the middle: sessions of one procedure may begin alike.
    let (last, step) = (part[0].len() - length, (length / 2).max(1));
    let Some(first) = (last / 2..=last).step_by(step).chain((0..last / 2).step_by(step)).find(moves) else {
        return false;
    };
    let rows = whole[0].len();
    (0..(rows + 1).saturating_sub(length)).any(|at| (0..length).all(|k| row(&whole, at + k) == row(&part, first + k)))
}

/// Position and effort of a joint, where both were measured and the effort varies.
fn measured(joint: &JointSeries) -> Option<[&[f64]; 2]> {
    let position = joint.get(Channel::Position)?;
    let effort = joint.get(Channel::Current).or_else(|| joint.get(Channel::Torque))?;
    effort.iter().any(|value| *value != effort[0]).then_some([position, effort])
}

//! Checks of every recording: lengths, numbers, time, gaps, constant channels.
//!
//! Refused: a channel shorter than the rest, NaN and ±Inf, time that runs backwards or repeats with other samples. Repaired and
//! reported: rows that repeat the row before them are dropped. Reported: pauses, single missing rows, constant channels.

use std::path::Path;

use super::Note;
use super::time_base::{self, TimeUnit};
use crate::error::{Error, Place, Result};
use crate::timeseries::pauses;

/// Least number of samples of a session.
const MIN_SAMPLES: usize = 2;
/// A step longer than this many median steps lacks samples.
const MISSING: f64 = 1.5;
/// [1] Share of such steps above which samples are not missing here and there, but lie unevenly: a bus loses less than one message in fifty.
const UNEVEN: f64 = 0.02;

/// Checks the time, which is the first column; the columns have equal lengths and finite numbers. Drops rows that
/// repeat.
///
/// # Errors
/// The first fault that cannot be repaired, with its row and column.
pub(super) fn check(
    file: &Path,
    signals: &mut [(String, Vec<f64>)],
    unit: &TimeUnit,
    notes: &mut Vec<Note>,
) -> Result<()> {
    increasing(file, signals, notes)?;
    let (name, time) = &signals[0];
    let median = median_step(time);
    time_base::check(file, (name, time), median, unit, notes)?;
    steps(file, (name, time), median, notes);
    constant(file, &signals[1..], notes);
    Ok(())
}

fn median_step(time: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Refuses a column that is shorter than the others, and fewer than two rows.
///
/// # Errors
/// As stated.
pub(super) fn lengths(file: &Path, signals: &[(String, Vec<f64>)]) -> Result<()> {
    let longest = signals.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
    if longest < MIN_SAMPLES {
        let expected = format!("at least {MIN_SAMPLES} rows of samples");
        return Err(Error::input(file, Place::File, "rows", longest, expected));
    }
    match signals.iter().find(|(_, values)| values.len() < longest) {
        Some((name, values)) => {
            let expected = format!("{longest} samples as in the other columns: the channel is shorter than the rest");
            Err(Error::input(file, Place::Row(values.len()), name, format!("{} samples", values.len()), expected))
        }
        None => Ok(()),
    }
}

/// Refuses NaN and infinity.
///
/// # Errors
/// The first row that contains one.
pub(super) fn finite(file: &Path, signals: &[(String, Vec<f64>)]) -> Result<()> {
    let first = |(name, values): &(String, Vec<f64>)| {
        values.iter().position(|value| !value.is_finite()).map(|row| (row, name.clone(), values[row]))
    };
    match signals.iter().filter_map(first).min_by_key(|found| found.0) {
        Some((row, name, value)) => Err(Error::input(file, Place::Row(row + 1), name, value, "a finite number")),
        None => Ok(()),
    }
}

fn increasing(file: &Path, signals: &mut [(String, Vec<f64>)], notes: &mut Vec<Note>) -> Result<()> {
    let repeats = |row: usize| signals.iter().all(|(_, values)| values[row] == values[row - 1]);
    let (name, time) = &signals[0];
    let mut dropped = Vec::new();
    for row in 1..time.len() {
        if time[row] > time[row - 1] {
            continue;
        }
        if !repeats(row) {
            let what = if time[row] == time[row - 1] { "repeated time" } else { "time runs backwards" };
            let expected = format!("more than {} of the row before ({what})", time[row - 1]);
            return Err(Error::input(file, Place::Row(row + 1), name, time[row], expected));
        }
        dropped.push(row);
    }
    if let Some(&first) = dropped.first() {
        let text = format!("{} rows that repeat the row before them, the first here: dropped", dropped.len());
        notes.push(Note { file: file.to_owned(), place: Place::Row(first + 1), column: String::new(), text });
        for (_, values) in signals.iter_mut() {
            let mut row = 0;
            values.retain(|_| {
                row += 1;
                dropped.binary_search(&(row - 1)).is_err()
            });
        }
        lengths(file, signals)?;
    }
    Ok(())
}

/// Notes on steps that are longer than the others. Where many are, sampling is uneven as a whole: everything is computed in true time, and no note
/// is needed.
fn steps(file: &Path, (name, time): (&str, &[f64]), median: f64, notes: &mut Vec<Note>) {
    let mut note = |place: Place, text: String| {
        notes.push(Note { file: file.to_owned(), place, column: name.to_owned(), text });
    };
    let pauses = pauses(time);
    for row in &pauses {
        let step = time[*row] - time[row - 1];
        note(
            Place::Row(row + 1),
            format!(
                "a pause of {step:.4e} s, at steps of {median:.4e} s: nothing is computed across it, and samples near it are left out"
            ),
        );
    }
    let missing = |row: &usize| time[*row] - time[row - 1] > MISSING * median && pauses.binary_search(row).is_err();
    let rows: Vec<usize> = (1..time.len()).filter(missing).collect();
    let count = rows.len();
    if let Some(first) = rows.first().filter(|_| count as f64 <= (UNEVEN * time.len() as f64).max(1.0)) {
        note(
            Place::Row(first + 1),
            format!("{count} steps longer than {MISSING} times the median {median:.4e} s, the first here"),
        );
    }
}

fn constant(file: &Path, signals: &[(String, Vec<f64>)], notes: &mut Vec<Note>) {
    for (name, values) in signals {
        if values.iter().all(|value| *value == values[0]) {
            let text = format!("constant at {} over the whole session", values[0]);
            notes.push(Note { file: file.to_owned(), place: Place::File, column: name.clone(), text });
        }
    }
}

//! Checks whether the time of a recording has the assumed unit.
//!
//! A robot's log has steps of 50 µs (a drive at 20 kHz) to 0.1 s (a supervisor at 10 Hz). If a time in ms, µs or ns is
//! read as seconds, its steps are longer by 10³, 10⁶ or 10⁹; if a time in days, the unit of MATLAB and spreadsheets, is
//! read as seconds, they are shorter by 86,400. If no unit is given and the steps indicate another unit than seconds,
//! the file is refused: the numbers are valid, and one line in a manifest states the unit.

use std::path::Path;

use super::Note;
use crate::error::{Error, Place, Result};

/// [s] Steps of a robot's log.
const SHORTEST: f64 = 50e-6;
const LONGEST: f64 = 0.1;

/// [s] Steps outside of this range are always refused: no drive samples above 1 MHz, and in 10 s a joint can stop and
/// move again between two samples.
const TOO_SHORT: f64 = 1e-6;
const TOO_LONG: f64 = 10.0;

/// Tolerance of these bounds for a median step that is the difference of two rounded numbers, such as 0.1 s.
const ROUNDING: f64 = 1e-6;

/// [s] Longest session: a day. Slow states of a machine, above all its temperature, count as constant within a session;
/// over more than a day they are not. The limit also bounds what a replay simulates, whatever the column contains:
/// 9·10⁷ steps at 1 kHz.
const LONGEST_SESSION: f64 = 86_400.0;

/// Possible units of a time that is read as seconds, and their size [s].
const UNITS: [(&str, f64); 4] = [("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("d", 86_400.0)];

/// Source of the unit of a time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum TimeUnit {
    /// The type of the column has a unit.
    Typed,
    /// A manifest gives it.
    Given(String),
    /// A manifest does not give it: seconds.
    Manifest,
    /// It is a canonical column: seconds.
    Canonical,
}

/// The units in which a step [s], read as seconds, would be that of a robot's log.
pub(super) fn likely_units(step: f64) -> Vec<&'static str> {
    if fits(step) {
        return vec!["s"];
    }
    UNITS.iter().filter(|(_, size)| fits(step * size)).map(|&(unit, _)| unit).collect()
}

/// The unit in which a number is a time since 1970, from 2001 to 2096. The ranges of the units do not overlap.
pub(super) fn epoch_unit(first: f64) -> Option<&'static str> {
    [("s", 1.0), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)]
        .into_iter()
        .find(|(_, count)| (1e9 * count..4e9 * count).contains(&first))
        .map(|(unit, _)| unit)
}

fn fits(step: f64) -> bool {
    (SHORTEST * (1.0 - ROUNDING)..=LONGEST * (1.0 + ROUNDING)).contains(&step)
}

/// Checks an increasing time [s] by its median step and its length.
///
/// # Errors
/// Its steps indicate another unit or do not fit a robot's log, or the session is longer than a day.
pub(super) fn check(
    file: &Path,
    (name, time): (&str, &[f64]),
    step: f64,
    unit: &TimeUnit,
    notes: &mut Vec<Note>,
) -> Result<()> {
    let refuse = |value: String, expected: String| Err(Error::input(file, Place::File, name, value, expected));
    let shown = format!("steps of {step:.4e} s");
    let range = format!("steps of {SHORTEST:e} s to {LONGEST} s");
    let known = matches!(unit, TimeUnit::Typed | TimeUnit::Given(_));
    if !fits(step) {
        if known && !(TOO_SHORT..=TOO_LONG).contains(&step) {
            let cause = match unit {
                TimeUnit::Given(unit) => format!(": is `[time] unit = \"{unit}\"` right?"),
                _ => String::new(),
            };
            return refuse(shown, range + &cause);
        }
        let likely = if known { Vec::new() } else { likely_units(step) };
        if !known && (!likely.is_empty() || !(TOO_SHORT..=LONGEST).contains(&step)) {
            return refuse(shown, range + &advice(&likely, unit));
        }
        let text = format!("{shown}; a robot's log has {range}");
        notes.push(Note { file: file.to_owned(), place: Place::File, column: name.to_owned(), text });
    }
    let span = time.last().zip(time.first()).map_or(0.0, |(last, first)| last - first);
    if span > LONGEST_SESSION {
        let expected = format!("a session of at most {LONGEST_SESSION} s: cut it into shorter ones");
        return refuse(format!("a span of {span:.4e} s"), expected);
    }
    Ok(())
}

fn advice(likely: &[&str], unit: &TimeUnit) -> String {
    let line = |unit: &str| format!("`[time] unit = \"{unit}\"`");
    let lines: Vec<String> = likely.iter().map(|unit| line(unit)).collect();
    let place = match unit {
        TimeUnit::Canonical => "a manifest (`lostmotion data FILE` writes one)",
        _ => "the manifest",
    };
    match lines.as_slice() {
        [] => format!(": if these are seconds, say so in {place} with {}", line("s")),
        [one] => format!(
            ": the time is likely in {}; state that in {place} with {one} or, if these are seconds, with {}",
            likely[0],
            line("s")
        ),
        _ => format!(": state the unit of the time in {place} with {}, or {}", lines.join(" or "), line("s")),
    }
}

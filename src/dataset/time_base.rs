//! Whether the time of a recording is in the unit that it is taken for.
//!
//! A robot's log has steps of 50 µs (a drive at 20 kHz) to 0.1 s (a supervisor at 10 Hz). Seconds taken for what is in ms, µs or ns gives
//! steps that are longer by 10³, 10⁶ or 10⁹; seconds taken for days, MATLAB's and a spreadsheet's unit, gives shorter ones by 86,400.
//! A unit that nobody gave is refused where its steps tell another one: the numbers are sound, and one line says what they mean.

use std::path::Path;

use super::Note;
use crate::error::{Error, Place, Result};

/// [s] Steps that a robot's log has.
const SHORTEST: f64 = 50e-6;
const LONGEST: f64 = 0.1;

/// [s] Steps that nothing is read with: no drive samples above 1 MHz, and in 10 s a joint comes to rest and moves again unseen.
const TOO_SHORT: f64 = 1e-6;
const TOO_LONG: f64 = 10.0;

/// A median step may miss these bounds by this share, as a step of 0.1 s does that is the difference of two rounded numbers.
const ROUNDING: f64 = 1e-6;

/// [s] Longest session: a day. What is slow in a machine, its temperature above all, is one state of a session; over more than a day it is
/// that of several. This bounds what a replay simulates whatever stands in the column: at 1 kHz, 9·10⁷ steps.
const LONGEST_SESSION: f64 = 86_400.0;

/// Units that a time may be in where it is taken for seconds, and their size [s].
const UNITS: [(&str, f64); 4] = [("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("d", 86_400.0)];

/// How the unit of a time is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum TimeUnit {
    /// The column is of a type that has a unit.
    Typed,
    /// A manifest gives it.
    Given(String),
    /// A manifest does not give it: seconds.
    Manifest,
    /// It is a canonical column: seconds.
    Canonical,
}

/// The units in which steps are those of a robot's log, for a step [s] that was taken for seconds.
pub(super) fn likely_units(step: f64) -> Vec<&'static str> {
    if fits(step) {
        return vec!["s"];
    }
    UNITS.iter().filter(|(_, size)| fits(step * size)).map(|&(unit, _)| unit).collect()
}

fn fits(step: f64) -> bool {
    (SHORTEST * (1.0 - ROUNDING)..=LONGEST * (1.0 + ROUNDING)).contains(&step)
}

/// Checks increasing time [s] by its median step and its length.
///
/// # Errors
/// Its steps tell another unit, are those of no log of a robot, or the session is longer than a day.
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
            ": the time is likely in {}, to be said in {place} with {one}; if these are seconds, with {}",
            likely[0],
            line("s")
        ),
        _ => format!(": the unit of the time has to be said in {place} with {}, or {}", lines.join(" or "), line("s")),
    }
}

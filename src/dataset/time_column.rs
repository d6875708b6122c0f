//! Which column is the time, and in which unit.

use std::collections::HashMap;

use super::names::{split_unit, words};
use super::table::{Column, Table};
use super::time_base::{epoch_unit, likely_units};
use super::unit_words::{bare, unit_of};
use super::words::{NANOSECONDS, SECONDS, TIME};
use crate::units::{Dimension, unit};

/// The time of a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FoundTime {
    /// Index of its column.
    pub(super) column: usize,
    /// Index of the column of its nanoseconds, if the other holds whole seconds.
    pub(super) nanoseconds: Option<usize>,
    /// Its unit, if it is known and the type of the column does not define it.
    pub(super) unit: Option<&'static str>,
    /// Why it has to be confirmed.
    pub(super) guess: Option<String>,
}

impl FoundTime {
    /// [s] Size of its unit, and the unit as a manifest gives it; none where a column without a unit is in seconds.
    pub(super) fn factor(&self) -> (f64, Option<String>) {
        let known = self.unit.and_then(|name| Some((unit(name)?.1, name.to_owned())));
        known.map_or((1.0, None), |(factor, name)| (factor, Some(name)))
    }

    /// The unit in words.
    pub(super) fn said(&self) -> String {
        self.unit.map_or(String::new(), |unit| format!(" in {unit}"))
    }
}

/// Finds the time: the column `time`, a pair of seconds and nanoseconds, a column whose name says so, a column of
/// dates; else the first column that rises, as a guess.
pub(super) fn find(table: &Table) -> Option<FoundTime> {
    if let Some(column) = table.columns.iter().position(|column| column.name == "time") {
        return Some(of_column(table, column));
    }
    if let Some((column, nanoseconds)) = pair(table) {
        return Some(FoundTime { column, nanoseconds: Some(nanoseconds), unit: None, guess: None });
    }
    let named: Vec<usize> = (0..table.columns.len()).filter(|at| is_named(&table.columns[*at])).collect();
    let rising: Vec<usize> = named.iter().copied().filter(|at| rises(&table.columns[*at])).collect();
    // The stamp of a message is when it was measured; another time may be when it was received.
    let stamped = |at: &usize| words(&table.columns[*at].name).iter().any(|word| word == "header");
    let rising = rising.iter().copied().find(stamped).or(rising.first().copied());
    let typed = || (0..table.columns.len()).find(|at| table.columns[*at].seconds.is_some());
    if let Some(column) = rising.or_else(typed).or(named.first().copied()) {
        return Some(of_column(table, column));
    }
    let column = table.columns.iter().position(rises)?;
    let guess = "no column is named as a time; this is the first one that rises".to_owned();
    Some(FoundTime { guess: Some(guess), ..of_column(table, column) })
}

/// Whether the name is one of a time.
fn is_named(column: &Column) -> bool {
    let (name, _) = split_unit(&column.name);
    let mut words = words(name);
    if words.len() > 1 && words.last().is_some_and(|last| time_unit(last).is_some() && !TIME.contains(&last.as_str())) {
        words.pop();
    }
    // A single letter among other words is not enough, except as a segment of its own: `log.t`.
    let own = |last: &str| last.len() > 1 || words.len() == 1 || name.ends_with(".t") || name.ends_with("/t");
    !column.is_foreign() && words.last().is_some_and(|last| TIME.contains(&last.as_str()) && own(last))
}

/// Whether the values never fall, and rise on the whole.
fn rises(column: &Column) -> bool {
    let values = &column.values;
    let ends = values.first().zip(values.last());
    column.fault.is_none()
        && ends.is_some_and(|(first, last)| last > first)
        && values.windows(2).all(|pair| pair[1] >= pair[0])
}

/// Columns of whole seconds and of nanoseconds whose names begin alike.
fn pair(table: &Table) -> Option<(usize, usize)> {
    let parts = |column: &Column| {
        let mut words = words(&column.name);
        words.pop().map(|last| (words, last)).filter(|_| !column.is_foreign())
    };
    let named = table.columns.iter().enumerate().filter_map(|(at, column)| Some((at, parts(column)?)));
    let named: Vec<(usize, (Vec<String>, String))> = named.collect();
    // Values of a second or more mean that the column is a time of its own.
    let is_part =
        |column: &Column| column.origin == 0 && column.values.iter().all(|value| !(*value < 0.0 || *value >= 1e9));
    let rests =
        named.iter().filter(|(at, (_, last))| NANOSECONDS.contains(&last.as_str()) && is_part(&table.columns[*at]));
    let rests: HashMap<&[String], usize> = rests.map(|(at, (prefix, _))| (prefix.as_slice(), *at)).collect();
    let mut seconds = named.iter().filter(|(_, (_, last))| SECONDS.contains(&last.as_str()));
    seconds.find_map(|(at, (prefix, _))| Some((*at, *rests.get(prefix.as_slice())?)))
}

/// The unit of time with this spelling.
fn time_unit(text: &str) -> Option<&'static str> {
    let found = unit_of(text)?;
    found.si().filter(|(dimension, _)| *dimension == Dimension::Time).map(|_| found.name)
}

/// The unit that the name or the row of units states.
fn stated_unit(column: &Column) -> Option<&'static str> {
    let (name, bracket) = split_unit(&column.name);
    let last = || words(name).last().and_then(|last| time_unit(last).filter(|_| last != "d"));
    let of_row = || column.unit.as_deref().and_then(|unit| time_unit(bare(unit)));
    bracket.and_then(time_unit).or_else(of_row).or_else(last)
}

/// The time of one column.
fn of_column(table: &Table, at: usize) -> FoundTime {
    let column = &table.columns[at];
    let found = |unit, guess| FoundTime { column: at, nanoseconds: None, unit, guess };
    if column.seconds.is_some() {
        return found(None, None);
    }
    if let Some(unit) = stated_unit(column) {
        return found(Some(unit), None);
    }
    let Some(step) = typical_step(&column.values) else { return found(None, None) };
    let likely = likely_units(step);
    if let Some(unit) = epoch_unit(column.values[0] + column.origin as f64).filter(|unit| likely.contains(unit)) {
        return found(Some(unit).filter(|unit| *unit != "s"), None);
    }
    match likely.as_slice() {
        [] | ["s"] => found(None, None),
        units => found(Some(units[0]), Some(format!("by its steps in {}, and not in s?", units.join(" or ")))),
    }
}

/// Median of the steps that rise.
fn typical_step(values: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    if steps.is_empty() {
        return None;
    }
    let middle = steps.len() / 2;
    Some(*steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}

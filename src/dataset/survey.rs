//! Describes a data file for a first look: what each column was taken for, its unit, and its quality.

mod signal;

use std::fmt::Write as _;

use super::columns::{CHANNEL_COLUMNS, canonical_plan};
use super::layout::Layout;
use super::table::{Column, Table, list};
use super::{Session, guess, plan_of};
use crate::error::{Error, Place, Result};
use crate::timeseries::{Channel, JointSeries, pauses};

/// How a file can be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Readable {
    /// It has canonical columns.
    Canonical,
    /// Its column names are clear.
    ByNames,
    /// It needs a manifest, for this reason.
    Manifest(String),
}

/// How a file can be used as data.
///
/// # Errors
/// It holds nothing that could be data: no rows, no numbers, no time.
pub fn readable(table: &Table) -> Result<Readable> {
    super::check_content(table)?;
    let layout = Layout::of(table);
    let Some(time) = &layout.time else {
        let names: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
        let expected = "a column of time: one that rises from row to row, or a pair of seconds and nanoseconds";
        return Err(Error::input(&table.file, Place::File, "columns", list(&names), expected));
    };
    Ok(match (plan_of(table, None), &time.guess) {
        (Err(error), _) if layout.why(table).is_empty() => Readable::Manifest(error.to_string()),
        (Err(_), _) | (_, Some(_)) => Readable::Manifest(layout.why(table)),
        _ if matches!(canonical_plan(table, &guess::joints_of_table(table)), Ok(Some(_))) => Readable::Canonical,
        _ => Readable::ByNames,
    })
}

/// Text on a file: rows, then each column with what it was taken for, its unit, its range and anything unusual.
pub fn survey(table: &Table) -> String {
    let rows = table.rows();
    let mut text = format!("{}: {rows} rows, {} columns\n", table.file.display(), table.columns.len());
    let width = table.columns.iter().map(|column| column.name.chars().count()).max().unwrap_or(0);
    let taken = taken_for(table);
    let wide = taken.iter().map(|taken| taken.chars().count()).max().unwrap_or(0);
    for (column, taken) in table.columns.iter().zip(&taken) {
        let _ = writeln!(text, "  {:<width$}  {taken:<wide$}  {}", column.name, about(&column.values, column, rows));
    }
    for note in &table.notes {
        let _ = writeln!(text, "  note: {note}");
    }
    text
}

/// What each column was taken for, with its unit.
fn taken_for(table: &Table) -> Vec<String> {
    let mut taken = vec!["-".to_owned(); table.columns.len()];
    let layout = Layout::of(table);
    if let Some(time) = &layout.time {
        let unit = if table.columns[time.column].seconds.is_some() { "time stamps" } else { time.unit.unwrap_or("s") };
        taken[time.column] = format!("time [{unit}]{}", if time.guess.is_some() { " ?" } else { "" });
        if let Some(at) = time.nanoseconds {
            taken[at] = "time [ns]".to_owned();
        }
    }
    for joint in &layout.joints {
        let kind = joint.kind();
        for channel in &joint.channels {
            let unit = match channel.unit {
                Some((unit, 1.0)) => unit.to_owned(),
                Some((unit, scale)) => format!("{scale} {unit}"),
                None => unit_of(channel.channel, kind).to_owned(),
            };
            let doubt = if channel.guess.is_some() { " ?" } else { "" };
            taken[channel.column] = format!("{}.{} [{unit}]{doubt}", joint.name, channel.channel);
        }
    }
    taken
}

/// SI unit of a canonical channel.
fn unit_of(name: &str, kind: crate::units::JointKind) -> &'static str {
    let turning = kind == crate::units::JointKind::Revolute;
    match name {
        name if name.ends_with("position") => kind.position_unit(),
        name if name.ends_with("velocity") && turning => "rad/s",
        name if name.ends_with("velocity") => "m/s",
        name if name.ends_with("current") => "A",
        "temperature" => "°C",
        _ => kind.effort_unit(),
    }
}

/// Text on a session: samples and time, then each channel with its quality in SI, and delays between channels.
pub fn survey_session(session: &Session) -> String {
    let series = &session.series;
    let mut text = format!("{}: {} samples, {}\n", series.name, series.len(), clock_of(&series.time));
    for joint in &series.joints {
        for (channel, values) in &joint.channels {
            let name = format!("{}.{}", joint.name, channel_name(*channel));
            let _ = writeln!(text, "  {name:<32}  {}", about(values, &Column::default(), series.len()));
        }
        text += &delays(&series.time, joint);
    }
    for note in &session.notes {
        let _ = writeln!(text, "  note: {note}");
    }
    text
}

/// Rate, jitter and pauses of a time [s] that rises.
fn clock_of(time: &[f64]) -> String {
    let (first, last) = (time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(0.0));
    let Some(step) = clock(time) else { return format!("{first} s to {last} s") };
    let pauses = pauses(time);
    let paused = |k: &usize| pauses.binary_search(k).is_ok();
    let steps: Vec<f64> = (1..time.len()).filter(|k| !paused(k)).map(|k| time[k] - time[k - 1]).collect();
    let spread = steps.iter().map(|one| (one - step).powi(2)).sum::<f64>() / steps.len().max(1) as f64;
    let pauses = match pauses.len() {
        0 => "no pause".to_owned(),
        count => {
            let longest = pauses.iter().map(|k| time[*k] - time[k - 1]).fold(0.0, f64::max);
            format!("{count} pauses, the longest {longest:.4} s")
        }
    };
    format!(
        "{first} s to {last} s, median step {step:.4e} s ({:.1} Hz), jitter {:.2} % of it, {pauses}",
        1.0 / step,
        100.0 * spread.sqrt() / step
    )
}

/// Delays between channels of a joint that show the same motion.
fn delays(time: &[f64], joint: &JointSeries) -> String {
    let get = |channel| joint.get(channel);
    let step = clock(time).unwrap_or(0.0);
    let mut text = String::new();
    if let (Some(position), Some(velocity)) = (get(Channel::Position), get(Channel::Velocity))
        && let Some(delay) = signal::delay(&signal::slopes(time, position), velocity, step)
    {
        let _ = writeln!(text, "    velocity is {delay:+.4} s behind the derivative of the position");
    }
    if let (Some(reference), Some(position)) = (get(Channel::ReferencePosition), get(Channel::Position))
        && let Some(delay) = signal::delay(&signal::slopes(time, reference), &signal::slopes(time, position), step)
    {
        let _ = writeln!(text, "    position is {delay:+.4} s behind its reference");
    }
    text
}

fn channel_name(channel: Channel) -> &'static str {
    CHANNEL_COLUMNS.iter().find(|entry| entry.1 == channel).map_or("", |entry| entry.0)
}

/// Describes values; `column` is their source, if there is one.
fn about(values: &[f64], column: &Column, rows: usize) -> String {
    if let Some((row, cell)) = &column.fault {
        return format!("not a number in row {row}: {cell:?}");
    }
    if values.is_empty() {
        return "no rows".to_owned();
    }
    let (minimum, maximum) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)));
    let (low, high) = (shown(minimum, column.origin), shown(maximum, column.origin));
    let mut text =
        if minimum == maximum { format!("constant {low}: dead") } else { format!("{low:>12} to {high:>12}") };
    if let Some(row) = values.iter().position(|value| !value.is_finite()) {
        let _ = write!(text, "  {} in row {}", values[row], row + 1);
    } else if let Some(step) = clock(values) {
        let _ = write!(text, "  increasing, median step {step:.4e}");
    } else if minimum < maximum {
        text += &signal::quality(values, minimum, maximum);
    }
    if let Some(seconds) = column.seconds {
        let _ = write!(text, "  time stamps in units of {seconds} s");
    }
    if values.len() < rows {
        let _ = write!(text, "  only {} rows", values.len());
    }
    text
}

/// A value with its origin; the sum is exact where both are whole.
fn shown(value: f64, origin: i64) -> String {
    if origin == 0 {
        return if value == value.trunc() && value.abs() < 1e15 { format!("{value}") } else { format!("{value:.6}") };
    }
    let whole = value.floor();
    let rest = value - whole;
    let decimals = if rest == 0.0 { String::new() } else { format!("{rest:.6}").trim_start_matches('0').to_owned() };
    format!("{}{decimals}", i128::from(origin) + whole as i128)
}

/// Median step of a column that increases from row to row.
fn clock(values: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() || !steps.iter().all(|step| *step > 0.0) {
        return None;
    }
    let middle = steps.len() / 2;
    Some(*steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}

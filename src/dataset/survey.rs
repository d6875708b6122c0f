//! Describes a data file for a first look, and proposes a first manifest.

use std::collections::HashMap;
use std::fmt::Write as _;

use super::columns::CHANNEL_COLUMNS;
use super::table::{Column, Table};
use super::time_base::likely_units;
use super::{Session, guess};
use crate::timeseries::Channel;
use crate::toml_input::{written_key, written_text};

/// Words in column names that indicate a channel, the most specific first.
const CHANNEL_WORDS: [(&[&str], &str); 12] = [
    (&["reference", "velocity"], "reference_velocity"),
    (&["reference"], "reference_position"),
    (&["ref"], "reference_position"),
    (&["link"], "link_position"),
    (&["command"], "command_current"),
    (&["velocity"], "velocity"),
    (&["vel"], "velocity"),
    (&["torque"], "torque"),
    (&["force"], "force"),
    (&["current"], "current"),
    (&["temperature"], "temperature"),
    (&["pos"], "position"),
];

/// Endings of column names that indicate a unit.
const UNIT_ENDINGS: [(&str, &str); 14] = [
    ("_rad_s", "rad/s"),
    ("_deg_s", "deg/s"),
    ("_rad", "rad"),
    ("_deg", "deg"),
    ("_rpm", "rpm"),
    ("_mm", "mm"),
    ("_ma", "mA"),
    ("_nm", "N·m"),
    ("_ms", "ms"),
    ("_us", "us"),
    ("_ns", "ns"),
    ("_a", "A"),
    ("_n", "N"),
    ("_v", "V"),
];

/// Text on a file: rows, then each column with its range and anything unusual.
pub fn survey(table: &Table) -> String {
    let rows = table.rows();
    let mut text = format!("{}: {rows} rows, {} columns\n", table.file.display(), table.columns.len());
    let width = table.columns.iter().map(|column| column.name.chars().count()).max().unwrap_or(0);
    for column in &table.columns {
        let _ = writeln!(text, "  {:<width$}  {}", column.name, about(&column.values, column, rows));
    }
    for note in &table.notes {
        let _ = writeln!(text, "  note: {note}");
    }
    if let Some(unit) = foreign_time(table) {
        let _ = writeln!(text, "  note: by its steps, the time is likely in {unit} and not in seconds");
    }
    if is_canonical(table) {
        let joints = guess::joints_of_table(table);
        let names: Vec<&str> = joints.iter().map(|joint| joint.0.as_str()).collect();
        let _ = writeln!(text, "  canonical columns of {}: no manifest needed", names.join(", "));
    }
    text
}

/// Whether a file can be read without a manifest.
pub fn is_canonical(table: &Table) -> bool {
    table.column("time").is_some() && foreign_time(table).is_none() && !guess::joints_of_table(table).is_empty()
}

/// The units that fit the steps of the column `time`, if it is not in seconds.
fn foreign_time(table: &Table) -> Option<String> {
    let units = likely_time_units(table.column("time")?);
    (!units.is_empty() && !units.contains(&"s")).then(|| units.join(" or "))
}

/// The units that fit the steps of a column; empty if its type has a unit, or if it does not increase.
fn likely_time_units(column: &Column) -> Vec<&'static str> {
    if column.seconds.is_some() {
        return Vec::new();
    }
    clock(&column.values).map(likely_units).unwrap_or_default()
}

/// Text on a session: samples, time, then each channel with its range in SI.
pub fn survey_session(session: &Session) -> String {
    let series = &session.series;
    let (first, last) = (series.time.first().copied().unwrap_or(0.0), series.time.last().copied().unwrap_or(0.0));
    let mut text = format!(
        "{}: {} samples, {first} s to {last} s, median step {:.4e} s\n",
        series.name,
        series.len(),
        series.sample_interval()
    );
    for joint in &series.joints {
        for (channel, values) in &joint.channels {
            let name = format!("{}.{}", joint.name, channel_name(*channel));
            let _ = writeln!(text, "  {name:<32}  {}", about(values, &Column::default(), series.len()));
        }
    }
    for note in &session.notes {
        let _ = writeln!(text, "  note: {note}");
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
    let origin = column.origin as f64;
    let minimum = values.iter().copied().fold(f64::INFINITY, f64::min) + origin;
    let maximum = values.iter().copied().fold(f64::NEG_INFINITY, f64::max) + origin;
    let mut text =
        if minimum == maximum { format!("constant {minimum}") } else { format!("{minimum:>12.6} to {maximum:>12.6}") };
    if let Some(row) = values.iter().position(|value| !value.is_finite()) {
        let _ = write!(text, "  {} in row {}", values[row], row + 1);
    } else if let Some(step) = clock(values) {
        let _ = write!(text, "  increasing, median step {step:.4e}");
    }
    if let Some(seconds) = column.seconds {
        let _ = write!(text, "  time stamps in units of {seconds} s");
    }
    if values.len() < rows {
        let _ = write!(text, "  only {} rows", values.len());
    }
    text
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

/// A first manifest: filled in as far as column names indicate, with the other columns listed for the user.
pub fn first_manifest(table: &Table) -> String {
    let file = table.file.file_name().unwrap_or_default().to_string_lossy();
    let mut text = format!(
        "schema = \"lostmotion/dataset/1\"\nfile = {}\nsource = \"who recorded it, when, on what\"\n",
        written_text(&file)
    );
    let time = time_column(table);
    match time {
        Some(column) => {
            let _ = write!(text, "\n[time]\ncolumn = {}\n{}", written_text(&column.name), time_unit(column));
        }
        None => text += "\n[time]\ncolumn = \"?\"  # no column increases from row to row\n",
    }
    let mut joints: Vec<(&str, Vec<(&'static str, String)>)> = Vec::new();
    let mut places: HashMap<&str, usize> = HashMap::new();
    let mut rest = Vec::new();
    for column in table.columns.iter().filter(|column| time.is_none_or(|time| time.name != column.name)) {
        let Some((joint, channel)) = channel_of(&column.name) else {
            rest.push(column.name.as_str());
            continue;
        };
        let unit = unit_of(&column.name).map_or(String::new(), |unit| format!(", unit = \"{unit}\""));
        let line = format!("{channel} = {{ column = {}{unit} }}\n", written_text(&column.name));
        let place = *places.entry(joint).or_insert_with(|| {
            joints.push((joint, Vec::new()));
            joints.len() - 1
        });
        let lines = &mut joints[place].1;
        if lines.iter().any(|(other, _)| *other == channel) {
            rest.push(column.name.as_str());
        } else {
            lines.push((channel, line));
        }
    }
    if joints.is_empty() {
        text += "\n[joints.NAME]  # a joint of the model\n";
    }
    for (joint, lines) in joints {
        let lines: String = lines.into_iter().map(|(_, line)| line).collect();
        let _ = write!(text, "\n[joints.{}]\n{lines}", written_key(joint));
    }
    if !rest.is_empty() {
        let channels: Vec<&str> = CHANNEL_COLUMNS.iter().map(|entry| entry.0).collect();
        let _ = writeln!(text, "# columns left: {}", rest.join(", "));
        let _ = writeln!(text, "# channels: {}", channels.join(", "));
        text += "# as `position = { column = \"NAME\", unit = \"deg\", scale = 1.0 }`\n";
    }
    text
}

/// The line with the unit of the time, if its name or its steps indicate one.
fn time_unit(column: &Column) -> String {
    if column.seconds.is_some() {
        return String::new();
    }
    let likely = likely_time_units(column);
    match (unit_of(&column.name), likely.as_slice()) {
        (Some(unit @ ("ms" | "us" | "ns")), _) => format!("unit = \"{unit}\"\n"),
        (_, ["s"]) => String::new(),
        (_, [unit]) => format!("unit = \"{unit}\"\n"),
        (_, units @ [_, _, ..]) => format!("unit = \"?\"  # by its steps {}\n", units.join(" or ")),
        _ => String::new(),
    }
}

fn time_column(table: &Table) -> Option<&Column> {
    let clocks = || table.columns.iter().filter(|column| clock(&column.values).is_some());
    let named = |column: &&Column| {
        let name = column.name.to_ascii_lowercase();
        name == "t" || name.starts_with("time")
    };
    clocks().find(named).or_else(|| clocks().next())
}

/// Joint and channel indicated by a name like `A1_motor_position_deg` or `joint1.position`.
fn channel_of(name: &str) -> Option<(&str, &'static str)> {
    let canonical = name
        .rsplit_once('.')
        .and_then(|(joint, channel)| Some((joint, CHANNEL_COLUMNS.iter().find(|entry| entry.0 == channel)?.0)));
    if canonical.is_some() {
        return canonical;
    }
    let lower = name.to_ascii_lowercase();
    let (_, channel) = CHANNEL_WORDS.iter().find(|(words, _)| words.iter().all(|word| lower.contains(word)))?;
    let joint = name.split(['.', '_']).next().filter(|joint| joint.len() < name.len() && !joint.is_empty())?;
    Some((joint, channel))
}

fn unit_of(name: &str) -> Option<&'static str> {
    let lower = name.to_ascii_lowercase();
    UNIT_ENDINGS.iter().find(|(ending, _)| lower.ends_with(ending)).map(|&(_, unit)| unit)
}

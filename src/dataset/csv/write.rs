//! Writes a session as comma-separated values with canonical columns.

use std::fmt::Write as _;
use std::io;
use std::path::Path;

use super::super::columns::{CHANNEL_COLUMNS, column_of};
use crate::error::Result;
use crate::timeseries::{Channel, JointSeries, TimeSeries};
use crate::toml_input::write_atomically_with;
use crate::units::JointKind;

/// Writes a session with canonical columns, completely or not at all: [`text`] as a file.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, series: &TimeSeries, kinds: &[JointKind]) -> Result<()> {
    write_atomically_with(path, |out| write_rows(out, series, kinds))
}

/// A session with canonical columns as text: what [`write_rows`] writes.
pub fn text(series: &TimeSeries, kinds: &[JointKind]) -> String {
    let mut bytes = Vec::new();
    // Writing to memory cannot fail, and the bytes are valid text.
    let _ = write_rows(&mut bytes, series, kinds);
    String::from_utf8(bytes).unwrap_or_default()
}

/// Writes a session with canonical columns, row by row. Channels that exist only in a simulation are left out.
///
/// Numbers are written so that reading them gives the same bits.
///
/// # Errors
/// Errors of `out`.
pub fn write_rows(out: &mut dyn io::Write, series: &TimeSeries, kinds: &[JointKind]) -> io::Result<()> {
    let mut header = vec!["time".to_owned()];
    let mut columns: Vec<&[f64]> = vec![&series.time];
    for (joint, kind) in series.joints.iter().zip(kinds) {
        for (channel, values) in written_channels(joint, *kind) {
            header.push(format!("{}.{channel}", joint.name));
            columns.push(values);
        }
    }
    let mut line = header.join(",");
    for row in 0..series.len() {
        line.push('\n');
        out.write_all(line.as_bytes())?;
        line.clear();
        for (index, column) in columns.iter().enumerate() {
            let separator = if index == 0 { "" } else { "," };
            // Writing to a string cannot fail.
            let _ = write!(line, "{separator}{}", column[row]);
        }
    }
    line.push('\n');
    out.write_all(line.as_bytes())
}

fn written_channels(joint: &JointSeries, kind: JointKind) -> impl Iterator<Item = (&'static str, &[f64])> {
    // `effort` is another name of a torque or a force.
    let known = CHANNEL_COLUMNS.iter().filter(move |(name, _)| *name != "effort" && column_of(name, kind).is_some());
    known.filter_map(|&(name, channel): &(&'static str, Channel)| Some((name, joint.get(channel)?)))
}

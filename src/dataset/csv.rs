//! Comma-separated values with a header: reading any, writing canonical ones.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use csv::{ByteRecord, ReaderBuilder};

use super::Note;
use super::columns::CHANNEL_COLUMNS;
use super::table::{Column, Table};
use crate::error::{Error, Place, Result};
use crate::timeseries::{Channel, JointSeries, TimeSeries};
use crate::toml_input::write_atomically;
use crate::units::JointKind;

/// Bytes of a cell that an error message shows.
const SHOWN_BYTES: usize = 40;

/// Reads all columns. A last row that was cut off is dropped and reported.
///
/// # Errors
/// The file cannot be read, has no header, no rows, or a row with another number of fields than the header.
pub(super) fn read(path: &Path) -> Result<Table> {
    let bytes = fs::read(path).map_err(|source| Error::file(path, "read", source))?;
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    let mut reader = ReaderBuilder::new().flexible(true).from_reader(text);
    let header = reader.byte_headers().map_err(|error| unreadable(path, &error))?.clone();
    let mut columns = named_columns(path, &header)?;
    let complete = text.ends_with(b"\n");

    let mut notes = Vec::new();
    let mut record = ByteRecord::new();
    let mut rows = 0;
    while reader.read_byte_record(&mut record).map_err(|error| unreadable(path, &error))? {
        rows += 1;
        let last = reader.position().byte() >= text.len() as u64;
        if last && !complete {
            let text = "the last row has no line end and may be cut off: dropped".into();
            notes.push(Note { file: path.to_owned(), place: Place::Row(rows), column: String::new(), text });
            break;
        }
        if record.len() != columns.len() {
            let expected = format!("{} fields as in the header", columns.len());
            return Err(Error::input(path, Place::Row(rows), "fields", record.len(), expected));
        }
        for (column, cell) in columns.iter_mut().zip(&record) {
            put(column, cell, rows);
        }
    }
    Ok(Table { file: path.to_owned(), columns, notes })
}

fn put(column: &mut Column, cell: &[u8], row: usize) {
    let text = cell.trim_ascii();
    let value = std::str::from_utf8(text).ok().and_then(|text| text.parse().ok());
    column.put(value, row, || String::from_utf8_lossy(&text[..text.len().min(SHOWN_BYTES)]).into_owned());
}

fn named_columns(path: &Path, header: &ByteRecord) -> Result<Vec<Column>> {
    let names: Vec<String> =
        header.iter().map(|cell| String::from_utf8_lossy(cell.trim_ascii()).into_owned()).collect();
    let expected = "a header of comma-separated column names";
    if names.len() < 2 {
        return Err(Error::input(path, Place::Line(1), "header", names.join(""), expected));
    }
    if names.iter().all(|name| name.parse::<f64>().is_ok()) {
        return Err(Error::input(path, Place::Line(1), "header", names.join(","), expected));
    }
    for (index, name) in names.iter().enumerate() {
        if names[..index].contains(name) {
            return Err(Error::input(path, Place::Line(1), "column", name, "each column name once"));
        }
    }
    Ok(names.into_iter().map(|name| Column { name, values: Vec::new(), fault: None }).collect())
}

fn unreadable(path: &Path, error: &csv::Error) -> Error {
    let place = error.position().map_or(Place::File, |position| Place::Line(position.line() as usize));
    Error::input(path, place, "csv", error, "comma-separated values")
}

/// Writes a session with canonical columns, whole or not at all: [`text`] as a file.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, series: &TimeSeries, kinds: &[JointKind]) -> Result<()> {
    write_atomically(path, &text(series, kinds))
}

/// A session with canonical columns. Channels that only a simulation knows are left out.
///
/// Numbers are written so that reading them gives the same bits.
pub fn text(series: &TimeSeries, kinds: &[JointKind]) -> String {
    let mut header = vec!["time".to_owned()];
    let mut columns: Vec<&[f64]> = vec![&series.time];
    for (joint, kind) in series.joints.iter().zip(kinds) {
        for (channel, values) in written_channels(joint, *kind) {
            header.push(format!("{}.{channel}", joint.name));
            columns.push(values);
        }
    }
    let mut text = header.join(",");
    text.reserve(series.len() * columns.len() * 20);
    text.push('\n');
    for row in 0..series.len() {
        for (index, column) in columns.iter().enumerate() {
            let separator = if index == 0 { "" } else { "," };
            // Writing to a string cannot fail.
            let _ = write!(text, "{separator}{}", column[row]);
        }
        text.push('\n');
    }
    text
}

fn written_channels(joint: &JointSeries, kind: JointKind) -> impl Iterator<Item = (&'static str, &[f64])> {
    let effort = match kind {
        JointKind::Revolute => "torque",
        JointKind::Prismatic => "force",
    };
    let known = CHANNEL_COLUMNS.iter().filter(move |(name, channel)| *channel != Channel::Torque || *name == effort);
    known.filter_map(|&(name, channel): &(&'static str, Channel)| Some((name, joint.get(channel)?)))
}

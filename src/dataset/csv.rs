//! Comma-separated values with a header: reading any, writing canonical ones.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufRead as _, BufReader, Read};
use std::path::Path;

use csv::{ByteRecord, ReaderBuilder};

use super::Note;
use super::columns::CHANNEL_COLUMNS;
use super::table::{Column, Table};
use crate::error::{Error, Place, Result};
use crate::timeseries::{Channel, JointSeries, TimeSeries};
use crate::toml_input::write_atomically_with;
use crate::units::JointKind;

/// Bytes of a cell that an error message shows.
const SHOWN_BYTES: usize = 40;

/// Reads all columns. A last row that was cut off is dropped and reported.
///
/// # Errors
/// The file cannot be read, has no header, no rows, or a row with another number of fields than the header.
pub(super) fn read(path: &Path) -> Result<Table> {
    let text = Text::open(path).map_err(|source| Error::file(path, "read", source))?;
    let mut reader = ReaderBuilder::new().flexible(true).from_reader(text);
    let header = reader.byte_headers().map_err(|error| unreadable(path, error))?.clone();
    let mut columns = named_columns(path, &header)?;

    let mut notes = Vec::new();
    // A row is taken once it is known whether another follows.
    let (mut row, mut next) = (ByteRecord::new(), ByteRecord::new());
    let mut rows = 0;
    let mut end = 0;
    while reader.read_byte_record(&mut next).map_err(|error| unreadable(path, error))? {
        if rows > 0 {
            take(path, &mut columns, &row, rows)?;
        }
        std::mem::swap(&mut row, &mut next);
        rows += 1;
        end = reader.position().byte();
    }
    let text = reader.get_ref();
    if rows > 0 && end >= text.bytes && !text.ends_line {
        let text = "the last row has no line end and may be cut off: dropped".into();
        notes.push(Note { file: path.to_owned(), place: Place::Row(rows), column: String::new(), text });
    } else if rows > 0 {
        take(path, &mut columns, &row, rows)?;
    }
    Ok(Table { file: path.to_owned(), columns, notes })
}

/// A text file without its byte order mark, read piece by piece; knows how long it is and how it ends once it is read.
struct Text {
    file: BufReader<File>,
    bytes: u64,
    ends_line: bool,
}

impl Text {
    fn open(path: &Path) -> io::Result<Self> {
        let mut file = BufReader::new(File::open(path)?);
        if file.fill_buf()?.starts_with(b"\xef\xbb\xbf") {
            file.consume(3);
        }
        Ok(Self { file, bytes: 0, ends_line: false })
    }
}

impl Read for Text {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(into)?;
        self.bytes += count as u64;
        if let Some(last) = into[..count].last() {
            self.ends_line = *last == b'\n';
        }
        Ok(count)
    }
}

/// Takes the cells of a row.
fn take(path: &Path, columns: &mut [Column], row: &ByteRecord, number: usize) -> Result<()> {
    if row.len() != columns.len() {
        let expected = format!("{} fields as in the header", columns.len());
        return Err(Error::input(path, Place::Row(number), "fields", row.len(), expected));
    }
    columns.iter_mut().zip(row).for_each(|(column, cell)| put(column, cell, number));
    Ok(())
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

fn unreadable(path: &Path, error: csv::Error) -> Error {
    let place = error.position().map_or(Place::File, |position| Place::Line(position.line() as usize));
    if !error.is_io_error() {
        return Error::input(path, place, "csv", error, "comma-separated values");
    }
    Error::file(path, "read", error.into())
}

/// Writes a session with canonical columns, whole or not at all: [`text`] as a file.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, series: &TimeSeries, kinds: &[JointKind]) -> Result<()> {
    write_atomically_with(path, |out| write_rows(out, series, kinds))
}

/// A session with canonical columns as text: what [`write_rows`] writes.
pub fn text(series: &TimeSeries, kinds: &[JointKind]) -> String {
    let mut bytes = Vec::new();
    // Writing to memory cannot fail, and what is written is text.
    let _ = write_rows(&mut bytes, series, kinds);
    String::from_utf8(bytes).unwrap_or_default()
}

/// Writes a session with canonical columns, row by row. Channels that only a simulation knows are left out.
///
/// Numbers are written so that reading them gives the same bits.
///
/// # Errors
/// Those of `out`.
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
    let effort = match kind {
        JointKind::Revolute => "torque",
        JointKind::Prismatic => "force",
    };
    let known = CHANNEL_COLUMNS.iter().filter(move |(name, channel)| *channel != Channel::Torque || *name == effort);
    known.filter_map(|&(name, channel): &(&'static str, Channel)| Some((name, joint.get(channel)?)))
}

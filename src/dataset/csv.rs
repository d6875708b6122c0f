//! Comma-separated values with a header: reads any layout, writes canonical columns.

mod guard;

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Read, Seek as _, SeekFrom};
use std::path::Path;

use csv::{ByteRecord, Reader, ReaderBuilder};

use self::guard::{Fault, Guard, MAX_RECORD};
use super::Note;
use super::columns::{CHANNEL_COLUMNS, column_of};
use super::source_file;
use super::table::{Column, Table, check_cells, check_count};
use crate::error::{Error, Place, Result};
use crate::timeseries::{Channel, JointSeries, TimeSeries};
use crate::toml_input::write_atomically_with;
use crate::units::JointKind;

/// Bytes of a cell that an error message shows.
const SHOWN_BYTES: usize = 40;

/// Number of rows after which the length of all columns is estimated for the first time.
const FIRST_ROOM: usize = 4096;
/// Number of bytes that the parser reads at once.
const BUFFER: usize = 1 << 16;

/// Reads all columns of a file. A last row that was cut off is dropped and reported.
///
/// # Errors
/// The file cannot be read, is not text, has no header, or has a row whose number of fields differs from the header's.
pub(super) fn read(path: &Path) -> Result<Table> {
    let (mut file, size) = source_file::open(path)?;
    let complete = ends_a_line(&mut file).map_err(|source| Error::file(path, "read", source))?;
    parse(path, file.take(size), size, complete)
}

fn ends_a_line(file: &mut File) -> std::io::Result<bool> {
    let mut last = [0];
    file.seek(SeekFrom::End(-1))?;
    file.read_exact(&mut last)?;
    file.seek(SeekFrom::Start(0))?;
    Ok(is_line_end(last[0]))
}

/// As [`read`], from memory.
///
/// # Errors
/// As [`read`].
pub(super) fn parse_bytes(path: &Path, bytes: &[u8]) -> Result<Table> {
    parse(path, bytes, bytes.len() as u64, bytes.last().is_some_and(|&byte| is_line_end(byte)))
}

fn is_line_end(byte: u8) -> bool {
    byte == b'\n' || byte == b'\r'
}

/// `complete`: whether the last byte ends a line.
fn parse(path: &Path, input: impl Read, size: u64, complete: bool) -> Result<Table> {
    let guard = Guard::new(input).map_err(|fault| refuse_text(path, &fault))?;
    let mark = guard.skipped;
    let mut reader = ReaderBuilder::new().flexible(true).buffer_capacity(BUFFER).from_reader(guard);
    reader.get_mut().allow(MAX_RECORD + BUFFER);
    let header = match reader.byte_headers() {
        Ok(header) => header.clone(),
        Err(error) => return Err(unreadable(path, &reader, &error)),
    };
    let mut table = Table::new(path, Place::Line(1), named_columns(path, &header)?, Vec::new())?;
    let width = table.columns.len();

    let mut record = ByteRecord::new();
    let mut rows = 0;
    let mut room = FIRST_ROOM;
    loop {
        reader.get_mut().allow(MAX_RECORD + BUFFER);
        match reader.read_byte_record(&mut record) {
            Ok(true) => rows += 1,
            Ok(false) => break,
            Err(error) => return Err(unreadable(path, &reader, &error)),
        }
        let last = reader.position().byte() + mark >= size;
        if last {
            check_quotes(path, &record, complete)?;
            if !complete {
                let text = "the last row has no line end and may be cut off: dropped".into();
                let place = Place::Row(rows);
                table.notes.push(Note { file: path.to_owned(), place, column: String::new(), text });
                break;
            }
        }
        if record.len() != width {
            let expected = format!("{width} fields as in the header");
            return Err(Error::input(path, Place::Row(rows), "fields", record.len(), expected));
        }
        check_cells(path, rows as u64, width)?;
        if rows == room {
            let more = rows_to_come(rows, reader.position().byte(), size).min(source_file::MAX_CELLS / width);
            table.columns.iter_mut().for_each(|column| column.values.reserve_exact(more));
            room += more;
        }
        for (column, cell) in table.columns.iter_mut().zip(&record) {
            put(column, cell);
        }
    }
    Ok(table)
}

/// Refuses a last record in which the file ends within a quoted cell.
fn check_quotes(path: &Path, record: &ByteRecord, complete: bool) -> Result<()> {
    let ends = |cell: &[u8]| cell.last().is_some_and(|&byte| is_line_end(byte)) || !complete;
    let open = |cell: &[u8]| cell.iter().any(|&byte| is_line_end(byte)) && ends(cell);
    if record.iter().any(open) {
        let line = record.position().map_or(1, csv::Position::line);
        let expected = "a closing quote: the quote that opens here is never closed";
        return Err(Error::input(path, Place::Line(line as usize), "quote", "", expected));
    }
    Ok(())
}

/// Expected number of further rows in a file of `size` bytes, of which `read` bytes gave `rows` rows, with some margin.
/// Columns that grow by doubling are copied repeatedly, and leave holes in memory as large as themselves.
fn rows_to_come(rows: usize, read: u64, size: u64) -> usize {
    let left = size.saturating_sub(read) as f64 / read.max(1) as f64;
    (1.02 * left * rows as f64) as usize + rows / 8
}

fn put(column: &mut Column, cell: &[u8]) {
    let bytes = cell.trim_ascii();
    let text = std::str::from_utf8(bytes).ok();
    // Only a column that begins with a large number is stored relative to it.
    let relative = column.values.is_empty() || column.origin != 0;
    match text.filter(|_| relative).and_then(parts) {
        Some((whole, fraction)) => column.put_parts(whole, fraction),
        None => {
            let value = text.and_then(|text| text.parse().ok());
            column.put(value, || String::from_utf8_lossy(&bytes[..bytes.len().min(SHOWN_BYTES)]).into_owned());
        }
    }
}

/// Whole part and fraction of a long decimal number such as a time stamp since 1970; `None` for anything else.
fn parts(text: &str) -> Option<(i64, f64)> {
    /// Least number of digits before the decimal point of a number that is split.
    const LONG: usize = 9;
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    if digits < LONG {
        return None;
    }
    let (whole, rest) = text.split_at(digits);
    let plain = rest.is_empty() || (rest.starts_with('.') && rest[1..].bytes().all(|byte| byte.is_ascii_digit()));
    let fraction = if rest.len() > 1 { rest.parse().ok()? } else { 0.0 };
    if plain { Some((whole.parse().ok()?, fraction)) } else { None }
}

fn named_columns(path: &Path, header: &ByteRecord) -> Result<Vec<Column>> {
    check_count(path, Place::Line(1), header.len())?;
    let names: Vec<String> =
        header.iter().map(|cell| String::from_utf8_lossy(cell.trim_ascii()).into_owned()).collect();
    let expected = "a header of comma-separated column names";
    if let [name] = names.as_slice() {
        let expected = match name.chars().find(|c| matches!(c, ';' | '\t' | '|')) {
            Some(';') => "column names separated by commas: save the file with commas and decimal points",
            Some('\t') => "column names separated by commas: this line has tabs",
            _ => expected,
        };
        return Err(Error::input(path, Place::Line(1), "header", name, expected));
    }
    if names.iter().all(|name| name.parse::<f64>().is_ok()) {
        return Err(Error::input(path, Place::Line(1), "header", names.join(","), expected));
    }
    Ok(names.into_iter().map(Column::new).collect())
}

fn unreadable<R: Read>(path: &Path, reader: &Reader<Guard<R>>, error: &csv::Error) -> Error {
    if let Some(fault) = &reader.get_ref().fault {
        let line = reader.position().line() as usize;
        return match fault {
            Fault::Long => too_long(path, line),
            other => refuse_text(path, other),
        };
    }
    match error.kind() {
        csv::ErrorKind::Io(source) => Error::file(path, "read", std::io::Error::new(source.kind(), source.to_string())),
        _ => Error::input(path, Place::Line(reader.position().line() as usize), "csv", "", "comma-separated values"),
    }
}

fn too_long(path: &Path, line: usize) -> Error {
    let value = format!("above {}", source_file::shown(MAX_RECORD as u64));
    let expected = "a row of numbers; a quote that is never closed may stand in this line";
    Error::input(path, Place::Line(line), "length of the row", value, expected)
}

fn refuse_text(path: &Path, fault: &Fault) -> Error {
    const SAVE: &str = "save it as UTF-8 (in a spreadsheet: \"CSV UTF-8\")";
    match fault {
        Fault::Utf16 => Error::input(path, Place::Line(1), "encoding", "UTF-16", format!("UTF-8 text: {SAVE}")),
        Fault::Nul(line) => {
            let expected = format!("text: the file is binary, damaged, or UTF-16 without a byte order mark; {SAVE}");
            Error::input(path, Place::Line(*line), "character", "a NUL byte", expected)
        }
        Fault::Read(kind) => Error::file(path, "read", std::io::Error::from(*kind)),
        Fault::Long => too_long(path, 1),
    }
}

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

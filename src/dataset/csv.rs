//! Text with columns of numbers: any delimiter, decimal sign, encoding and header. Writes canonical columns.

mod cells;
mod dialect;
mod guard;
mod text;
mod write;

use std::io::Read;
use std::path::Path;

use csv::{ByteRecord, Reader, ReaderBuilder};

use self::cells::Blanks;
use self::dialect::Dialect;
use self::guard::{Fault, Guard, MAX_RECORD};
use self::text::Extent;
pub(super) use self::text::{GZIP, Text};
pub use self::write::{text as written, write, write_rows};
use super::Note;
use super::source_file;
use super::table::{Column, Table, check_cells, check_count};
use crate::error::{Error, Place, Result};

/// Number of rows, and of cells, after which the length of all columns is estimated for the first time.
const FIRST_ROWS: usize = 4096;
const FIRST_CELLS: usize = 1 << 18;
/// Number of bytes that the parser reads at once.
const BUFFER: usize = 1 << 16;

/// The parser of a text.
type Records<'a> = Reader<Guard<Box<dyn Read + 'a>>>;

/// Reads all columns of a text. A last row that was cut off is dropped and reported.
///
/// # Errors
/// The file cannot be read, is not text, has no columns, or has a row whose number of fields differs from the header's.
pub(super) fn read(text: Text<'_>) -> Result<Table> {
    let path = text.path();
    let (head, whole) = text.head()?;
    let dialect = dialect::recognise(&head, whole);
    let (input, extent) = text.reader()?;
    let input = if dialect.delimiter == b' ' { Box::new(Blanks::new(input)) } else { input };
    let guard = Guard::new(input).map_err(|fault| refuse_text(path, &fault))?;
    let mut builder = ReaderBuilder::new();
    builder.has_headers(false).flexible(true).delimiter(dialect.delimiter).comment(dialect.comment);
    let mut reader = builder.buffer_capacity(BUFFER).from_reader(guard);
    let mut table = header(path, &mut reader, &dialect)?;
    rows(path, &mut reader, &dialect, &mut table, &extent)?;
    Ok(table)
}

/// Reads the next record; returns whether there was one.
fn next(path: &Path, reader: &mut Records<'_>, record: &mut ByteRecord) -> Result<bool> {
    reader.get_mut().allow(MAX_RECORD + BUFFER);
    reader.read_byte_record(record).map_err(|error| unreadable(path, reader, &error))
}

/// Reads the lines before the rows; returns an empty table with the names of the columns.
fn header(path: &Path, reader: &mut Records<'_>, dialect: &Dialect) -> Result<Table> {
    let mut record = ByteRecord::new();
    for _ in 0..dialect.skipped {
        next(path, reader, &mut record)?;
    }
    let (names, line) = match &dialect.names {
        Some(names) => (names.clone(), 1),
        None => {
            next(path, reader, &mut record)?;
            let line = record.position().map_or(1, |position| position.line().max(1) as usize);
            (record.iter().map(|cell| dialect::decoded(cell).trim().to_owned()).collect(), line)
        }
    };
    let place = Place::Line(line);
    check_count(path, place, names.len())?;
    if names.len() < 2 {
        let expected = "a header of column names, separated by commas, semicolons, tabs or blanks";
        return Err(Error::input(path, place, "header", names.join(","), expected));
    }
    let columns = names.into_iter().map(Column::new).collect();
    let mut table = Table::new(path, place, columns, Vec::new())?;
    table.nameless = dialect.nameless;
    Ok(table)
}

/// Reads the rows into the columns of a table.
fn rows(path: &Path, reader: &mut Records<'_>, dialect: &Dialect, table: &mut Table, extent: &Extent) -> Result<()> {
    let width = table.columns.len();
    let (mut record, mut following) = (ByteRecord::new(), ByteRecord::new());
    let mut more = next(path, reader, &mut following)?;
    if more && cells::are_units(&following) {
        for (column, cell) in table.columns.iter_mut().zip(&following) {
            column.unit = Some(dialect::decoded(cell).trim().to_owned());
        }
        more = next(path, reader, &mut following)?;
    }
    let (mut rows, mut room) = (0, FIRST_ROWS.min(FIRST_CELLS / width).max(1));
    while more {
        std::mem::swap(&mut record, &mut following);
        more = next(path, reader, &mut following)?;
        rows += 1;
        if !more {
            let complete = reader.get_ref().ends_a_line();
            check_quotes(path, &record, complete)?;
            if !complete {
                let text = "the last row has no line end and may be cut off: dropped".into();
                let place = Place::Row(rows);
                table.notes.push(Note { file: path.to_owned(), place, column: String::new(), text });
                break;
            }
        }
        // Some programs end every row with a delimiter.
        let trailing = record.len() == width + 1 && record.get(width).is_some_and(<[u8]>::is_empty);
        if record.len() != width && !trailing {
            let expected = format!("{width} fields as in the header");
            return Err(Error::input(path, Place::Row(rows), "fields", record.len(), expected));
        }
        check_cells(path, rows as u64, width)?;
        if rows == room {
            let more = rows_to_come(rows, extent.read(reader.position().byte()), extent.size);
            let more = more.min(source_file::MAX_CELLS / width - rows);
            table.columns.iter_mut().for_each(|column| column.make_room(more));
            room += more.max(room);
        }
        for (column, cell) in table.columns.iter_mut().zip(&record) {
            cells::put(column, cell, dialect.decimal);
        }
    }
    Ok(())
}

/// Refuses a last record in which the file ends within a quoted cell.
fn check_quotes(path: &Path, record: &ByteRecord, complete: bool) -> Result<()> {
    let is_line_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
    let ends = |cell: &[u8]| cell.last().is_some_and(is_line_end) || !complete;
    let open = |cell: &[u8]| cell.iter().any(is_line_end) && ends(cell);
    if record.iter().any(open) {
        let line = record.position().map_or(1, csv::Position::line);
        let expected = "a closing quote: the quote that opens here is never closed";
        return Err(Error::input(path, Place::Line(line as usize), "quote", "", expected));
    }
    Ok(())
}

/// Expected number of further rows in a file of `size` bytes, of which `read` bytes gave `rows` rows, with some margin.
fn rows_to_come(rows: usize, read: u64, size: u64) -> usize {
    let left = size.saturating_sub(read) as f64 / read.max(1) as f64;
    (1.02 * left * rows as f64) as usize + rows / 8
}

fn unreadable(path: &Path, reader: &Records<'_>, error: &csv::Error) -> Error {
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
    match fault {
        Fault::Nul(line) => {
            let expected =
                "text, or one of the formats that are recognised by their first bytes: the file is binary or damaged";
            Error::input(path, Place::Line(*line), "character", "a NUL byte", expected)
        }
        Fault::Read(kind) => Error::file(path, "read", std::io::Error::from(*kind)),
        Fault::Long => too_long(path, 1),
    }
}

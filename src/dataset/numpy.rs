//! Arrays of numpy: `.npy` (one array) and `.npz` (a ZIP archive of arrays).
//!
//! A vector is a column; a matrix gives columns `name.0`, `name.1` ..., one for each entry of its shorter side; a structured
//! array gives a column for each field. In a `.npy` without fields the columns have no names.
//! Left out: text, objects, complex numbers, arrays of more than two dimensions, single numbers.
//! Reference: numpy, "NEP 1: a simple file format for NumPy arrays".

mod array;
mod zip;

use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek};
use std::path::Path;

use self::array::{Array, Fault};
use super::csv::Text;
use super::source_file;
use super::table::{Column, Table, check_cells, check_count};
use crate::error::{Error, Place, Result};

/// Reads a `.npy`.
///
/// # Errors
/// The file cannot be read, is damaged, or holds no table of numbers.
pub(super) fn read_array(text: Text<'_>) -> Result<Table> {
    let path = text.path();
    let columns = match text {
        Text::File(path) => array_columns(path, "", &mut BufReader::new(source_file::open(path)?.0), 0)?,
        Text::Memory(_, mut bytes) => array_columns(path, "", &mut bytes, 0)?,
    };
    let nameless = columns.iter().any(|column| column.name.is_empty() || column.name.starts_with('.'));
    let numbered = |(at, column): (usize, Column)| Column { name: (at + 1).to_string(), ..column };
    let columns = if nameless { columns.into_iter().enumerate().map(numbered).collect() } else { columns };
    let mut table = Table::new(path, Place::File, columns, Vec::new())?;
    table.nameless = nameless;
    Ok(table)
}

/// Reads a `.npz`.
///
/// # Errors
/// The file cannot be read, is damaged, or one of its arrays is.
pub(super) fn read_archive(text: Text<'_>) -> Result<Table> {
    match text {
        Text::File(path) => {
            let (file, size) = source_file::open(path)?;
            archive::<BufReader<File>>(path, BufReader::new(file), size)
        }
        Text::Memory(path, bytes) => archive(path, Cursor::new(bytes), bytes.len() as u64),
    }
}

fn archive<R: Read + Seek>(path: &Path, mut input: R, size: u64) -> Result<Table> {
    let damaged = |value: &str| Error::input(path, Place::File, "npz", value, "a whole archive of numpy arrays");
    let entries = zip::entries(&mut input, size).ok_or_else(|| damaged("cut off or damaged"))?;
    let (mut columns, mut cells) = (Vec::new(), 0);
    for entry in entries {
        let Some(name) = entry.name.strip_suffix(".npy") else { continue };
        let mut content = zip::content(&mut input, &entry).ok_or_else(|| damaged(&entry.name))?;
        let found = array_columns(path, name, &mut content, cells)?;
        cells += found.iter().map(|column| column.values.len() as u64).sum::<u64>();
        columns.extend(found);
        check_count(path, Place::File, columns.len())?;
    }
    Table::new(path, Place::File, columns, Vec::new())
}

/// The columns of an array; `cells`: count of numbers that were read before.
fn array_columns(path: &Path, name: &str, input: &mut dyn Read, cells: u64) -> Result<Vec<Column>> {
    let refuse = |value: &str, expected: &str| {
        let key = if name.is_empty() { "array" } else { name };
        Error::input(path, Place::File, key, value, expected)
    };
    let damaged = || refuse("cut off or damaged", "a whole array of numpy");
    let array = match Array::read(input) {
        Ok(array) => array,
        Err(Fault::Damaged) => return Err(damaged()),
        Err(Fault::Unfit(what)) => {
            // Among other arrays it counts as a column without numbers, and is left out.
            let fault = Some((1, format!("({what})")));
            return Ok(vec![Column { fault, ..Column::new(name) }]);
        }
    };
    check_count(path, Place::File, array.width())?;
    let total = cells.saturating_add(array.rows().saturating_mul(array.width() as u64));
    check_cells(path, total, 1)?;
    array.columns(name, input).ok_or_else(damaged)
}

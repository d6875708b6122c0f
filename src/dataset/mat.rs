//! MATLAB 5 files: every numeric vector is a column; arrays of one element are parameters of the experiment and left out.
//! Left out: structures, cells, text.

use std::fs;
use std::path::Path;

use matfile::{Array, MatFile, NumericData};

use super::table::{Column, Table};
use crate::error::{Error, Place, Result};

/// Length of the header and of an element's tag in the file format [bytes].
const HEADER: usize = 128;
const TAG: usize = 8;
/// Types of the elements that a file is made of: an array, or a compressed one.
const ELEMENT_TYPES: [u32; 2] = [14, 15];

/// Reads all numeric arrays with more than one element.
///
/// # Errors
/// The file cannot be read, is not a MATLAB 5 file, is cut off, or holds complex numbers.
pub(super) fn read(path: &Path) -> Result<Table> {
    let bytes = fs::read(path).map_err(|source| Error::file(path, "read", source))?;
    check_elements(path, &bytes)?;
    let file = MatFile::parse(bytes.as_slice()).map_err(|error| {
        Error::input(path, Place::File, "arrays", error, "numeric arrays of MATLAB 5, saved as double")
    })?;
    let columns = file.arrays().iter().filter_map(|array| column(path, array).transpose()).collect::<Result<_>>()?;
    Ok(Table { file: path.to_owned(), columns, notes: Vec::new() })
}

/// Walks the elements: each must be an array and lie within the file.
fn check_elements(path: &Path, bytes: &[u8]) -> Result<()> {
    let little_endian = match bytes.get(HEADER - 2..HEADER) {
        Some(b"IM") => true,
        Some(b"MI") => false,
        _ => {
            let found =
                if bytes.starts_with(b"\x89HDF") || bytes.starts_with(b"MATLAB 7.3") { "MATLAB 7.3" } else { "" };
            return Err(Error::input(path, Place::File, "format", found, "a MATLAB 5 file (save with -v6 or -v7)"));
        }
    };
    let number = |at: usize| -> Option<u32> {
        let word: [u8; 4] = bytes.get(at..at + 4)?.try_into().ok()?;
        Some(if little_endian { u32::from_le_bytes(word) } else { u32::from_be_bytes(word) })
    };
    let mut at = HEADER;
    let mut count = 0;
    while at < bytes.len() {
        count += 1;
        let key = format!("array {count}");
        let (Some(kind), Some(length)) = (number(at), number(at + 4)) else {
            return Err(Error::input(path, Place::File, key, "cut off", "a whole file"));
        };
        if !ELEMENT_TYPES.contains(&kind) {
            return Err(Error::input(path, Place::File, key, format!("element type {kind}"), "an array (14 or 15)"));
        }
        let end = at + TAG + length as usize;
        if end > bytes.len() {
            let expected = format!("a whole file: {end} bytes, it has {}", bytes.len());
            return Err(Error::input(path, Place::File, key, "cut off", expected));
        }
        at = end;
    }
    Ok(())
}

/// The column that an array is; none where it has one element or none.
fn column(path: &Path, array: &Array) -> Result<Option<Column>> {
    let refuse = |value: &str, expected: &str| Error::input(path, Place::File, array.name(), value, expected);
    let Some(values) = reals(array.data()) else { return Err(refuse("complex numbers", "real numbers")) };
    if values.len() < 2 {
        return Ok(None);
    }
    if !array.size().contains(&values.len()) {
        let size: Vec<String> = array.size().iter().map(usize::to_string).collect();
        return Err(refuse(&size.join("×"), "a vector: one row or one column"));
    }
    Ok(Some(Column { name: array.name().to_owned(), values, fault: None }))
}

fn reals(data: &NumericData) -> Option<Vec<f64>> {
    fn all<T: Copy + Into<f64>>(values: &[T]) -> Option<Vec<f64>> {
        Some(values.iter().map(|&value| value.into()).collect())
    }
    match data {
        NumericData::Double { real, imag: None } => Some(real.clone()),
        NumericData::Single { real, imag: None } => all(real),
        NumericData::Int8 { real, imag: None } => all(real),
        NumericData::UInt8 { real, imag: None } => all(real),
        NumericData::Int16 { real, imag: None } => all(real),
        NumericData::UInt16 { real, imag: None } => all(real),
        NumericData::Int32 { real, imag: None } => all(real),
        NumericData::UInt32 { real, imag: None } => all(real),
        NumericData::Int64 { real, imag: None } => Some(real.iter().map(|&value| value as f64).collect()),
        NumericData::UInt64 { real, imag: None } => Some(real.iter().map(|&value| value as f64).collect()),
        _ => None,
    }
}

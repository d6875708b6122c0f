//! Apache Parquet: every top-level column of numbers; time stamps become seconds.

use std::fs::File;
use std::path::Path;

use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::Field;

use super::table::{Column, Table};
use crate::error::{Error, Place, Result};

/// Reads all columns. What is no number is remembered as a fault of its column.
///
/// # Errors
/// The file cannot be read, or is no Parquet file.
pub(super) fn read(path: &Path) -> Result<Table> {
    // The decoder asserts what a broken file may not hold.
    std::panic::catch_unwind(|| decode(path))
        .unwrap_or_else(|_| Err(Error::input(path, Place::File, "parquet", "broken pages", "an Apache Parquet file")))
}

fn decode(path: &Path) -> Result<Table> {
    let file = File::open(path).map_err(|source| Error::file(path, "read", source))?;
    let reader = SerializedFileReader::new(file).map_err(|error| unreadable(path, &error))?;
    let fields = reader.metadata().file_metadata().schema().get_fields();
    let mut columns: Vec<Column> =
        fields.iter().map(|field| Column { name: field.name().to_owned(), values: Vec::new(), fault: None }).collect();
    for (row, fields) in reader.get_row_iter(None).map_err(|error| unreadable(path, &error))?.enumerate() {
        let fields = fields.map_err(|error| unreadable(path, &error))?;
        for (column, (_, field)) in columns.iter_mut().zip(fields.get_column_iter()) {
            column.put(number(field), row + 1, || shown(field));
        }
    }
    Ok(Table { file: path.to_owned(), columns, notes: Vec::new() })
}

fn number(field: &Field) -> Option<f64> {
    match field {
        Field::Double(value) => Some(*value),
        Field::Float(value) => Some(f64::from(*value)),
        Field::Byte(value) => Some(f64::from(*value)),
        Field::Short(value) => Some(f64::from(*value)),
        Field::Int(value) => Some(f64::from(*value)),
        Field::Long(value) => Some(*value as f64),
        Field::UByte(value) => Some(f64::from(*value)),
        Field::UShort(value) => Some(f64::from(*value)),
        Field::UInt(value) => Some(f64::from(*value)),
        Field::ULong(value) => Some(*value as f64),
        Field::TimeMillis(value) => Some(f64::from(*value) * 1e-3),
        Field::TimestampMillis(value) => Some(*value as f64 * 1e-3),
        Field::TimeMicros(value) | Field::TimestampMicros(value) => Some(*value as f64 * 1e-6),
        _ => None,
    }
}

/// The text of a field that is no number; empty where it is missing.
fn shown(field: &Field) -> String {
    match field {
        Field::Null => String::new(),
        other => other.to_string(),
    }
}

fn unreadable(path: &Path, error: &ParquetError) -> Error {
    Error::input(path, Place::File, "parquet", error, "an Apache Parquet file")
}

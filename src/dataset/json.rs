//! JSON: an object of columns `{"time": [...], "joint1.position": [...]}`, an object of objects by row as pandas writes it
//! `{"time": {"0": 0.0, "1": 0.1}}`, or a list of rows `[{"time": 0.0, ...}, ...]`.
//!
//! A list of numbers in a cell becomes the columns `name.0`, `name.1` ...; any value but a number or a time counts as not a number.

use std::collections::HashMap;
use std::io::Read as _;

use serde_json::{Map, Value};

use super::csv::Text;
use super::date_time;
use super::source_file::shown;
use super::table::{Column, Table, check_cells, check_count};
use crate::error::{Error, Place, Result};

/// Largest file [bytes]: parsed JSON takes some ten times its size in memory.
const MAX_JSON: u64 = 64 << 20;
/// [s] Unit of dates and times.
const NANOSECOND: f64 = 1e-9;

/// Reads all columns.
///
/// # Errors
/// The file cannot be read, is too large, is not JSON, or is not laid out as one of the above.
pub(super) fn read(text: Text<'_>) -> Result<Table> {
    let path = text.path();
    let refuse = |place, value: &str, expected: &str| Err(Error::input(path, place, "json", value, expected));
    let mut bytes = Vec::new();
    let (reader, _) = text.reader()?;
    reader.take(MAX_JSON + 1).read_to_end(&mut bytes).map_err(|source| Error::file(path, "read", source))?;
    if bytes.len() as u64 > MAX_JSON {
        let expected =
            format!("at most {}: CSV takes less, in python `pandas.read_json(...).to_csv(...)`", shown(MAX_JSON));
        return refuse(Place::File, "too large", &expected);
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    let value: Value = match serde_json::from_slice(bytes) {
        Ok(value) => value,
        Err(error) => {
            let value = if error.is_eof() { "cut off" } else { "" };
            return refuse(Place::Line(error.line().max(1)), value, "valid JSON");
        }
    };
    let mut columns = Columns { path, columns: Vec::new(), places: HashMap::new(), cells: 0 };
    match &value {
        Value::Object(object) => columns.take_columns(object)?,
        Value::Array(rows) if rows.iter().all(Value::is_object) => {
            for (row, fields) in rows.iter().filter_map(Value::as_object).enumerate() {
                columns.take_row(row, fields)?;
            }
        }
        _ => {
            let expected =
                "an object of columns, {\"time\": [0.0, ...], ...}, or a list of rows, [{\"time\": 0.0, ...}, ...]";
            return refuse(Place::File, "", expected);
        }
    }
    Table::new(path, Place::File, columns.columns, Vec::new())
}

/// Columns while they are read.
struct Columns<'a> {
    path: &'a std::path::Path,
    columns: Vec<Column>,
    places: HashMap<String, usize>,
    cells: u64,
}

impl Columns<'_> {
    fn take_columns(&mut self, object: &Map<String, Value>) -> Result<()> {
        for (name, column) in object {
            match column {
                Value::Array(values) => {
                    for (row, value) in values.iter().enumerate() {
                        self.put(name, row, value)?;
                    }
                }
                // pandas: an object with the number of the row as its key. Any other object is a part with columns.
                Value::Object(rows) if rows.keys().enumerate().all(|(row, key)| key.parse() == Ok(row)) => {
                    for (row, value) in rows.values().enumerate() {
                        self.put(name, row, value)?;
                    }
                }
                Value::Object(part) => {
                    let named = part.iter().map(|(key, value)| (format!("{name}.{key}"), value.clone()));
                    self.take_columns(&named.filter(|(_, value)| value.is_array()).collect())?;
                }
                // A setting of the recording.
                _ => {}
            }
        }
        Ok(())
    }

    fn take_row(&mut self, row: usize, fields: &Map<String, Value>) -> Result<()> {
        fields.iter().try_for_each(|(name, value)| self.put(name, row, value))
    }

    /// Puts a value into a row of a column; rows that a column lacks are missing numbers.
    fn put(&mut self, name: &str, row: usize, value: &Value) -> Result<()> {
        if let Value::Array(list) = value {
            return list.iter().enumerate().try_for_each(|(at, value)| match value {
                // Only one level of lists is read: a deeper list is not a vector.
                Value::Array(_) => self.put_single(&format!("{name}.{at}"), row, &Value::Null),
                value => self.put_single(&format!("{name}.{at}"), row, value),
            });
        }
        self.put_single(name, row, value)
    }

    fn put_single(&mut self, name: &str, row: usize, value: &Value) -> Result<()> {
        let place = match self.places.get(name) {
            Some(place) => *place,
            None => {
                check_count(self.path, Place::File, self.columns.len() + 1)?;
                self.columns.push(Column::new(name));
                self.places.insert(name.to_owned(), self.columns.len() - 1);
                self.columns.len() - 1
            }
        };
        let column = &mut self.columns[place];
        self.cells += (row + 1).saturating_sub(column.values.len()) as u64;
        check_cells(self.path, self.cells, 1)?;
        while column.values.len() < row {
            column.put(None, String::new);
        }
        match value {
            Value::Number(number) => match number.as_i64() {
                Some(whole) if column.values.is_empty() || column.origin != 0 => column.put_parts(whole, 0.0),
                _ => column.put(number.as_f64(), String::new),
            },
            Value::String(text) => match date_time::nanoseconds(text) {
                Some(time) if column.values.is_empty() || column.seconds.is_some() => {
                    column.seconds = Some(NANOSECOND);
                    column.put_parts(time, 0.0);
                }
                _ => column.put(None, || text.clone()),
            },
            other => column.put(None, || if other.is_null() { String::new() } else { other.to_string() }),
        }
        Ok(())
    }
}

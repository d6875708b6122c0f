//! Columns of numbers as a file holds them, before names and units are given to them.

use std::path::PathBuf;

use super::Note;
use crate::error::{Error, Place, Result};

/// The columns of a file of data.
#[derive(Debug, Clone)]
pub struct Table {
    /// The file.
    pub file: PathBuf,
    /// Its columns, in the order of the file.
    pub columns: Vec<Column>,
    /// What was noticed while reading.
    pub notes: Vec<Note>,
}

/// One column.
#[derive(Debug, Clone)]
pub struct Column {
    /// Its name in the file.
    pub name: String,
    /// Its values; NaN where a cell is not a number.
    pub values: Vec<f64>,
    /// The first cell that is not a number: its row, counted from 1, and its text.
    pub fault: Option<(usize, String)>,
}

impl Column {
    /// Adds the value of a row, or what stands there instead of a number.
    pub(super) fn put(&mut self, value: Option<f64>, row: usize, shown: impl FnOnce() -> String) {
        if value.is_none() && self.fault.is_none() {
            self.fault = Some((row, shown()));
        }
        self.values.push(value.unwrap_or(f64::NAN));
    }
}

impl Table {
    /// The column of that name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// The values of a column, which is left without them. `named_at`: file, place and key of the manifest that names it.
    ///
    /// # Errors
    /// There is no such column, or it holds text.
    pub(super) fn take_values(&mut self, name: &str, named_at: Option<&(PathBuf, Place, String)>) -> Result<Vec<f64>> {
        let Some(index) = self.columns.iter().position(|column| column.name == name) else {
            let names: Vec<&str> = self.columns.iter().map(|column| column.name.as_str()).collect();
            let expected = format!("one of the columns of {}: {}", self.file.display(), list(&names));
            return Err(match named_at {
                Some((file, place, key)) => Error::input(file, *place, key, name, expected),
                None => Error::input(&self.file, Place::File, name, "(missing)", expected),
            });
        };
        let column = &mut self.columns[index];
        if let Some((row, text)) = &column.fault {
            let (value, expected) = describe_fault(text, *row, &column.values);
            return Err(Error::input(&self.file, Place::Row(*row), name, value, expected));
        }
        Ok(std::mem::take(&mut column.values))
    }

    /// Gives a column its values back: another channel is made of it too.
    pub(super) fn give_back(&mut self, name: &str, values: Vec<f64>) {
        if let Some(column) = self.columns.iter_mut().find(|column| column.name == name) {
            column.values = values;
        }
    }
}

/// The value and expectation to report for the first cell that is not a number.
fn describe_fault(text: &str, row: usize, values: &[f64]) -> (String, String) {
    let rest_is_missing = values[row - 1..].iter().all(|value| value.is_nan());
    if text.is_empty() && rest_is_missing && row > 1 {
        let expected =
            format!("{} samples as in the other columns: the channel is shorter than the rest", values.len());
        (format!("{} samples", row - 1), expected)
    } else if text.is_empty() {
        ("(empty)".into(), "a number".into())
    } else {
        (text.into(), "a number with a decimal point".into())
    }
}

/// At most twelve names, and how many more there are.
pub(super) fn list(names: &[&str]) -> String {
    const SHOWN: usize = 12;
    if names.len() <= SHOWN {
        names.join(", ")
    } else {
        format!("{} and {} more", names[..SHOWN].join(", "), names.len() - SHOWN)
    }
}

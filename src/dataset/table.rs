//! Columns of numbers as in the file, before they get names and units.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::Note;
use super::source_file::{MAX_CELLS, MAX_COLUMNS};
use crate::error::{Error, Place, Result};
use crate::files::{PLAIN_NAME, is_plain_name};

/// A column whose first value is at least this large is stored relative to a whole number: above it, an `f64` resolves
/// a time stamp in seconds to no better than 1e-8 s, and one in nanoseconds to no better than 256 ns.
const LARGE: u64 = 100_000_000;

/// The columns of a data file.
#[derive(Debug, Clone)]
pub struct Table {
    /// The file.
    pub file: PathBuf,
    /// Its columns, in the order of the file.
    pub columns: Vec<Column>,
    /// Notes from reading.
    pub notes: Vec<Note>,
    /// Whether the file has no names for its columns; then they are named by their number, from 1.
    pub nameless: bool,
    index: HashMap<String, usize>,
}

/// One column.
#[derive(Debug, Clone, Default)]
pub struct Column {
    /// Its name in the file.
    pub name: String,
    /// Its values minus `origin`; NaN for a cell that is not a number.
    pub values: Vec<f64>,
    /// The number to add to each of `values`. It is zero, except for columns that begin at 1e8 or above, such as time
    /// stamps since 1970; their differences keep their precision in this way.
    pub origin: i64,
    /// [s] Size of one unit, if the type of the column defines it.
    pub seconds: Option<f64>,
    /// Its unit as the file states it apart from the name.
    pub unit: Option<String>,
    /// The first cell that is not a number: its row, counted from 1, and its text.
    pub fault: Option<(usize, String)>,
}

impl Column {
    /// An empty column.
    pub(super) fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// Makes room for so many further rows. A column that grows by doubling is copied repeatedly, and leaves holes in memory as large as
    /// itself.
    pub(super) fn make_room(&mut self, rows: usize) {
        self.values.reserve_exact(rows);
    }

    /// Adds the value of a row, or the text of a cell that is not a number.
    pub(super) fn put(&mut self, value: Option<f64>, shown: impl FnOnce() -> String) {
        if value.is_none() && self.fault.is_none() {
            self.fault = Some((self.values.len() + 1, shown()));
        }
        self.values.push(value.map_or(f64::NAN, |value| value - self.origin as f64));
    }

    /// Adds a whole number and its fraction, without rounding of their sum.
    pub(super) fn put_parts(&mut self, whole: i64, fraction: f64) {
        if self.values.is_empty() && whole.unsigned_abs() >= LARGE {
            self.origin = whole;
        }
        let value = match whole.checked_sub(self.origin) {
            Some(difference) => difference as f64 + fraction,
            None => whole as f64 - self.origin as f64 + fraction,
        };
        self.values.push(value);
    }

    /// Whether the column holds something else than numbers: text from its first row on, or nothing at all. A column of
    /// numbers may lack some, which are refused by their row.
    pub(super) fn is_foreign(&self) -> bool {
        let text = self.fault.as_ref().is_some_and(|(row, text)| *row == 1 && !text.is_empty());
        text || (self.fault.is_some() && self.values.iter().all(|value| value.is_nan())) || self.values.is_empty()
    }

    /// The value of a row in the file's own terms.
    pub fn value(&self, row: usize) -> f64 {
        self.values[row] + self.origin as f64
    }
}

impl Table {
    /// Puts columns together.
    ///
    /// # Errors
    /// A name occurs twice or contains control characters, or there are too many columns.
    pub(super) fn new(file: &Path, place: Place, columns: Vec<Column>, notes: Vec<Note>) -> Result<Self> {
        check_count(file, place, columns.len())?;
        let mut index = HashMap::with_capacity(columns.len());
        for (at, column) in columns.iter().enumerate() {
            let refuse = |expected: &str| Err(Error::input(file, place, "column", &column.name, expected));
            if !is_plain_name(&column.name) {
                return refuse(PLAIN_NAME);
            }
            if index.insert(column.name.clone(), at).is_some() {
                return refuse("each column name once");
            }
        }
        Ok(Self { file: file.to_owned(), columns, notes, nameless: false, index })
    }

    /// The column of that name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.index.get(name).and_then(|&at| self.columns.get(at)).filter(|column| column.name == name)
    }

    /// Rows of its longest column.
    pub fn rows(&self) -> usize {
        self.columns.iter().map(|column| column.values.len()).max().unwrap_or(0)
    }

    /// A column that a session needs. `named_at`: file, place and key of the manifest that names it.
    ///
    /// # Errors
    /// There is no such column, or it contains text.
    pub(super) fn wanted(&self, name: &str, named_at: Option<&(PathBuf, Place, String)>) -> Result<&Column> {
        let Some(column) = self.column(name) else {
            let names: Vec<&str> = self.columns.iter().map(|column| column.name.as_str()).collect();
            let expected = format!("one of the columns of {}: {}", self.file.display(), list(&names));
            return Err(match named_at {
                Some((file, place, key)) => Error::input(file, *place, key, name, expected),
                None => Error::input(&self.file, Place::File, name, "(missing)", expected),
            });
        };
        if let Some((row, text)) = &column.fault {
            let (value, expected) = describe_fault(text, *row, &column.values);
            return Err(Error::input(&self.file, Place::Row(*row), name, value, expected));
        }
        Ok(column)
    }

    /// Takes the values of a column out of the table.
    pub(super) fn take_values(&mut self, name: &str) -> Vec<f64> {
        let column = self.index.get(name).and_then(|&at| self.columns.get_mut(at));
        column.map(|column| std::mem::take(&mut column.values)).unwrap_or_default()
    }
}

/// Refuses too many columns.
///
/// # Errors
/// As stated.
pub(super) fn check_count(file: &Path, place: Place, columns: usize) -> Result<()> {
    if columns > MAX_COLUMNS {
        return Err(Error::input(file, place, "columns", columns, format!("at most {MAX_COLUMNS}")));
    }
    Ok(())
}

/// Refuses too many cells.
///
/// # Errors
/// As stated.
pub(super) fn check_cells(file: &Path, rows: u64, columns: usize) -> Result<()> {
    if rows.saturating_mul(columns as u64) > MAX_CELLS as u64 {
        let value = format!("{rows} rows of {columns} columns");
        let expected = format!("at most {MAX_CELLS} cells: cut the recording into shorter sessions");
        return Err(Error::input(file, Place::File, "size", value, expected));
    }
    Ok(())
}

/// The value and expectation to report for the first cell that is not a number.
fn describe_fault(text: &str, row: usize, values: &[f64]) -> (String, String) {
    let rest_is_missing = values.get(row - 1..).is_some_and(|rest| rest.iter().all(|value| value.is_nan()));
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

/// At most twelve names, each of at most forty characters, and how many more there are.
pub(super) fn list(names: &[&str]) -> String {
    const SHOWN: usize = 12;
    const CHARACTERS: usize = 40;
    let shown =
        |name: &&str| if name.is_empty() { "(no name)".to_owned() } else { crate::error::shown(name, CHARACTERS) };
    let shown: Vec<String> = names.iter().take(SHOWN).map(shown).collect();
    if names.len() <= SHOWN {
        shown.join(", ")
    } else {
        format!("{} and {} more", shown.join(", "), names.len() - SHOWN)
    }
}

//! A table of a TOML file, read key by key.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::{Item, Node, Range};
use crate::error::{Error, Place, Result};
use crate::files::{FIT_NAME, is_fit_name};

/// A table that is being read. It remembers which keys were read; [`Table::finish`] refuses the rest.
#[derive(Debug)]
pub struct Table<'a> {
    file: &'a Path,
    path: String,
    item: &'a Item,
    entries: &'a [(String, Item)],
    /// Index of each key in `entries`, so that reading a file takes a time proportional to its number of keys.
    index: BTreeMap<&'a str, usize>,
    asked: RefCell<BTreeSet<String>>,
}

impl<'a> Table<'a> {
    pub(super) fn new(file: &'a Path, path: String, item: &'a Item) -> Self {
        let entries = if let Node::Table(entries) = &item.node { entries.as_slice() } else { &[] };
        let index = entries.iter().enumerate().map(|(at, (name, _))| (name.as_str(), at)).collect();
        Self { file, path, item, entries, index, asked: RefCell::default() }
    }

    /// The file that contains it, as errors name it.
    pub fn file(&self) -> &'a Path {
        self.file
    }

    /// Its path of keys, `joints.joint1.motor`; empty at the top.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Place of a key; for a missing key, the beginning of the table.
    pub fn place(&self, key: &str) -> Place {
        self.find(key).unwrap_or(self.item).place()
    }

    /// Whether the table has a key.
    pub fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    /// Names of its keys, in the order of the file.
    pub fn keys(&self) -> impl Iterator<Item = &'a str> {
        self.entries.iter().map(|(name, _)| name.as_str())
    }

    /// An error about a key: its value, and what was expected instead.
    pub fn error(&self, key: &str, expected: impl Into<String>) -> Error {
        let value = self.find(key).map(|item| item.raw.as_str()).unwrap_or_default();
        Error::input(self.file, self.place(key), self.key_path(key), value, expected)
    }

    /// Refuses the keys that were never read.
    ///
    /// # Errors
    /// Names the first such key, and the known key that is nearest.
    pub fn finish(&self) -> Result<()> {
        let asked = self.asked.borrow();
        let Some((key, item)) = self.entries.iter().find(|(name, _)| !asked.contains(name)) else {
            return Ok(());
        };
        let advice = nearest(key, asked.iter().map(String::as_str))
            .map_or_else(|| format!("one of the keys {}", listed(&asked)), |name| format!("the key `{name}`"));
        Err(Error::input(self.file, item.place(), self.key_path(key), &item.raw, format!("{advice} (unknown key)")))
    }

    /// A number within its range.
    ///
    /// # Errors
    /// Missing, not a number, or outside its range.
    pub fn number(&self, key: &str, range: &Range) -> Result<f64> {
        self.optional_number(key, range)?.ok_or_else(|| self.missing(key, &range.to_string()))
    }

    /// A number within its range, or a default if the key is missing.
    ///
    /// # Errors
    /// Not a number, or outside its range.
    pub fn number_or(&self, key: &str, range: &Range, default: f64) -> Result<f64> {
        Ok(self.optional_number(key, range)?.unwrap_or(default))
    }

    /// A number within its range, if the key exists.
    ///
    /// # Errors
    /// Not a number, or outside its range.
    pub fn optional_number(&self, key: &str, range: &Range) -> Result<Option<f64>> {
        let number = |item: &Item| number_of(item).filter(|&value| range.holds(value));
        self.optional(key, number, || range.to_string())
    }

    /// A whole number from `min` to `max`.
    ///
    /// # Errors
    /// Not whole, or outside.
    pub fn optional_integer(&self, key: &str, min: i64, max: i64) -> Result<Option<i64>> {
        let integer = |item: &Item| match item.node {
            Node::Integer(value) if (min..=max).contains(&value) => Some(value),
            _ => None,
        };
        let expected = || match max {
            i64::MAX => format!("a whole number ≥ {min}"),
            _ => format!("a whole number from {min} to {max}"),
        };
        self.optional(key, integer, expected)
    }

    /// One number for both directions, or `[positive, negative]`.
    ///
    /// # Errors
    /// Anything else, or outside the range.
    pub fn optional_pair(&self, key: &str, range: &Range) -> Result<Option<[f64; 2]>> {
        let pair = |item: &Item| match &item.node {
            Node::Array(_) => numbers_of(item, range).and_then(|values| <[f64; 2]>::try_from(values).ok()),
            _ => number_of(item).filter(|&value| range.holds(value)).map(|value| [value, value]),
        };
        self.optional(key, pair, || format!("{range}, or two of them, [positive, negative]"))
    }

    /// As [`Table::optional_pair`], but the key must exist.
    ///
    /// # Errors
    /// Missing, anything else, or outside the range.
    pub fn pair(&self, key: &str, range: &Range) -> Result<[f64; 2]> {
        self.optional_pair(key, range)?
            .ok_or_else(|| self.missing(key, &format!("{range}, or two of them, [positive, negative]")))
    }

    /// A list of numbers.
    ///
    /// # Errors
    /// Not a list, an element that is not a number, or outside the range.
    pub fn optional_numbers(&self, key: &str, range: &Range) -> Result<Option<Vec<f64>>> {
        self.optional(key, |item| numbers_of(item, range), || format!("a list, each {range}"))
    }

    /// A list of exactly `N` numbers.
    ///
    /// # Errors
    /// Another length, an element that is not a number, or outside the range.
    pub fn optional_vector<const N: usize>(&self, key: &str, range: &Range) -> Result<Option<[f64; N]>> {
        let vector = |item: &Item| numbers_of(item, range).and_then(|values| <[f64; N]>::try_from(values).ok());
        self.optional(key, vector, || format!("a list of {N}, each {range}"))
    }

    /// Text.
    ///
    /// # Errors
    /// Missing or not a text.
    pub fn text(&self, key: &str) -> Result<&'a str> {
        self.optional_text(key)?.ok_or_else(|| self.missing(key, "text in quotes"))
    }

    /// Text, if the key exists.
    ///
    /// # Errors
    /// Not a text.
    pub fn optional_text(&self, key: &str) -> Result<Option<&'a str>> {
        let text = |item: &'a Item| if let Node::Text(text) = &item.node { Some(text.as_str()) } else { None };
        self.optional(key, text, || "text in quotes".to_owned())
    }

    /// A name that is valid for files and folders.
    ///
    /// # Errors
    /// Missing, not a text, or not a [fit name](is_fit_name).
    pub fn name(&self, key: &str) -> Result<&'a str> {
        self.optional_name(key)?.ok_or_else(|| self.missing(key, FIT_NAME))
    }

    /// A name that is valid for files and folders, if the key exists.
    ///
    /// # Errors
    /// Not a text, or not a [fit name](is_fit_name).
    pub fn optional_name(&self, key: &str) -> Result<Option<&'a str>> {
        let name = self.optional_text(key)?;
        if name.is_some_and(|name| !is_fit_name(name)) { Err(self.error(key, FIT_NAME)) } else { Ok(name) }
    }

    /// A list of texts.
    ///
    /// # Errors
    /// Not a list, or an element that is not a text.
    pub fn optional_texts(&self, key: &str) -> Result<Option<Vec<&'a str>>> {
        let texts = |item: &'a Item| match &item.node {
            Node::Array(items) => items
                .iter()
                .map(|item| if let Node::Text(text) = &item.node { Some(text.as_str()) } else { None })
                .collect(),
            _ => None,
        };
        self.optional(key, texts, || "a list of texts in quotes".to_owned())
    }

    /// One of several words, each with its meaning.
    ///
    /// # Errors
    /// Another word, or not a text.
    pub fn optional_choice<T: Copy>(&self, key: &str, choices: &[(&str, T)]) -> Result<Option<T>> {
        let choice = |item: &Item| match &item.node {
            Node::Text(text) => choices.iter().find(|(word, _)| word == text).map(|&(_, meaning)| meaning),
            _ => None,
        };
        let words = || choices.iter().map(|(word, _)| format!("\"{word}\"")).collect::<Vec<_>>().join(" or ");
        self.optional(key, choice, words)
    }

    /// `true` or `false`.
    ///
    /// # Errors
    /// Anything else.
    pub fn optional_boolean(&self, key: &str) -> Result<Option<bool>> {
        let boolean = |item: &Item| if let Node::Boolean(value) = item.node { Some(value) } else { None };
        self.optional(key, boolean, || "true or false".to_owned())
    }

    /// A table under a key.
    ///
    /// # Errors
    /// Missing or not a table.
    pub fn table(&self, key: &str) -> Result<Table<'a>> {
        self.optional_table(key)?.ok_or_else(|| self.missing(key, "a table"))
    }

    /// A table under a key, if the key exists.
    ///
    /// # Errors
    /// Not a table.
    pub fn optional_table(&self, key: &str) -> Result<Option<Table<'a>>> {
        let table = |item: &'a Item| {
            matches!(item.node, Node::Table(_)).then(|| Table::new(self.file, self.key_path(key), item))
        };
        self.optional(key, table, || "a table".to_owned())
    }

    /// A list of tables `[[key]]`; empty where the key is missing. Errors count them from 1.
    ///
    /// # Errors
    /// Anything except a list of tables.
    pub fn tables(&self, key: &str) -> Result<Vec<Table<'a>>> {
        let path = self.key_path(key);
        let tables = |item: &'a Item| match &item.node {
            Node::Array(items) => items
                .iter()
                .enumerate()
                .map(|(i, item)| {
                    matches!(item.node, Node::Table(_))
                        .then(|| Table::new(self.file, format!("{path}[{}]", i + 1), item))
                })
                .collect(),
            _ => None,
        };
        Ok(self.optional(key, tables, || "a list of tables".to_owned())?.unwrap_or_default())
    }

    /// All entries as tables with their names, `[joints.NAME]`, in the order of the file.
    ///
    /// # Errors
    /// An entry that is not a table.
    pub fn named_tables(&self) -> Result<Vec<(&'a str, Table<'a>)>> {
        self.keys().map(|name| Ok((name, self.table(name)?))).collect()
    }

    /// Every key that was not read before, as a number: the open list of an effect's parameters.
    ///
    /// # Errors
    /// A value that is not a finite number.
    pub fn remaining_numbers(&self) -> Result<BTreeMap<String, f64>> {
        let range = Range::any("SI");
        let rest: Vec<&str> = self.keys().filter(|&key| !self.asked.borrow().contains(key)).collect();
        rest.into_iter().map(|key| Ok((key.to_owned(), self.number(key, &range)?))).collect()
    }

    fn optional<T>(
        &self,
        key: &str,
        convert: impl FnOnce(&'a Item) -> Option<T>,
        expected: impl FnOnce() -> String,
    ) -> Result<Option<T>> {
        let Some(item) = self.get(key) else { return Ok(None) };
        convert(item).map(Some).ok_or_else(|| self.error(key, expected()))
    }

    fn missing(&self, key: &str, expected: &str) -> Error {
        Error::input(self.file, self.item.place(), self.key_path(key), "", format!("{expected} (missing)"))
    }

    fn get(&self, key: &str) -> Option<&'a Item> {
        self.asked.borrow_mut().insert(key.to_owned());
        self.find(key)
    }

    fn find(&self, key: &str) -> Option<&'a Item> {
        self.index.get(key).map(|&at| &self.entries[at].1)
    }

    fn key_path(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }
}

fn number_of(item: &Item) -> Option<f64> {
    match item.node {
        Node::Number(value) => Some(value),
        Node::Integer(value) => Some(value as f64),
        _ => None,
    }
}

fn numbers_of(item: &Item, range: &Range) -> Option<Vec<f64>> {
    let Node::Array(items) = &item.node else { return None };
    items.iter().map(|item| number_of(item).filter(|&value| range.holds(value))).collect()
}

fn listed(names: &BTreeSet<String>) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// The candidate that a misspelt name most likely means: at most a third of its letters differ. A name of more than 64
/// letters has none.
pub fn nearest<'n>(name: &str, candidates: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    const LONGEST: usize = 64;
    let length = name.chars().count();
    if length > LONGEST {
        return None;
    }
    let reach = (length / 3).max(1);
    let near = candidates.into_iter().filter(|candidate| candidate.len() <= 4 * LONGEST);
    let distances = near.map(|candidate| (edits(name, candidate), candidate));
    distances.filter(|&(distance, _)| distance <= reach).min().map(|(_, candidate)| candidate)
}

/// Levenshtein distance.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

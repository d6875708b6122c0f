//! Places of the values of a file, kept beside the data that were read from it.

use std::collections::BTreeMap;

use super::{Item, Node};
use crate::error::{Error, Place};

/// Line and text of every value of a file, by its path of keys: `joints.elbow.gear_ratio`, `effects[2].tilt`.
///
/// Errors that are found only after reading, because they depend on several values, get their line from here. All
/// places compare as equal: the place of a value is not part of the data.
#[derive(Debug, Clone, Default)]
pub struct Places(BTreeMap<String, (Place, String)>);

impl PartialEq for Places {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Places {
    pub(super) fn of(root: &Item) -> Self {
        let mut places = Self::default();
        // (path, item) still to be visited; not recursive, because a file may be nested deeply.
        let mut waiting = vec![(String::new(), root)];
        while let Some((path, item)) = waiting.pop() {
            match &item.node {
                Node::Table(entries) => waiting.extend(
                    entries
                        .iter()
                        .map(|(key, item)| (if path.is_empty() { key.clone() } else { format!("{path}.{key}") }, item)),
                ),
                Node::Array(items) => {
                    let tables = items.iter().enumerate().filter(|(_, item)| matches!(item.node, Node::Table(_)));
                    waiting.extend(tables.map(|(i, item)| (format!("{path}[{}]", i + 1), item)));
                }
                _ => {}
            }
            places.0.insert(path, (item.place(), item.raw.clone()));
        }
        places
    }

    /// Place and text of a value.
    pub fn get(&self, key: &str) -> Option<(Place, &str)> {
        self.0.get(key).map(|(place, written)| (*place, written.as_str()))
    }

    /// Adds the line of the key that the error names, if the error has no line and the file contains the key with that
    /// value, or contains the table that lacks the key, or one above it.
    #[must_use]
    pub fn locate(&self, error: Error) -> Error {
        let Error::Input(mut fault) = error else { return error };
        if fault.place == Place::File {
            match self.get(&fault.key) {
                Some((place, written)) if same(written, &fault.value) => {
                    fault.place = place;
                    fault.value = written.to_owned();
                }
                Some((place, "")) => fault.place = place,
                None if fault.value.is_empty() => {
                    let mut tables = std::iter::successors(above(&fault.key), |table| above(table));
                    let table = tables.find_map(|table| self.get(table));
                    fault.place = table.map_or(Place::File, |(place, _)| place);
                }
                _ => {}
            }
        }
        Error::Input(fault)
    }
}

/// Key of the table that contains a key.
fn above(key: &str) -> Option<&str> {
    key.rsplit_once('.').map(|(table, _)| table)
}

/// Whether a text in a file is this value: the same number, or the same text in quotes.
fn same(written: &str, value: &str) -> bool {
    let number = |text: &str| text.replace('_', "").parse::<f64>().ok();
    match (number(written), number(value)) {
        (Some(written), Some(value)) => written == value,
        _ => written.trim_matches(['"', '\'']) == value.trim_matches(['"', '\'']),
    }
}

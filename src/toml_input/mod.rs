//! Reads TOML files: model files, scenarios, manifests.
//!
//! Every value remembers its line, every getter checks type and range, and [`Table::finish`] refuses the keys that were
//! never read. So the code that reads a file is also the list of its allowed keys:
//!
//! ```
//! use lostmotion::toml_input::{Document, Range};
//! let document = Document::parse("m.toml".as_ref(), "name = 'arm'\nratio = 5.4\n")?;
//! let root = document.root();
//! assert_eq!(root.text("name")?, "arm");
//! assert_eq!(root.number("ratio", &Range::positive("1"))?, 5.4);
//! root.finish()?;
//! # Ok::<(), lostmotion::error::Error>(())
//! ```

mod places;
mod range;
mod recording;
mod table;
mod text;
mod write;

use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use crate::error::{Error, Place, Result};

pub use places::Places;
pub use range::Range;
pub use table::{Table, nearest};
pub use text::{read_bytes, read_text};
pub use write::{write_atomically, write_atomically_with, written_key, written_number, written_text};

/// [bytes] Longest TOML file. A model or a scenario has some kilobytes, a list of 100,000 waypoints a megabyte; parsed,
/// it takes a hundred times as much memory.
const LONGEST: u64 = 2 << 20;

/// A parsed file with the line of every value.
#[derive(Debug, Clone)]
pub struct Document {
    file: PathBuf,
    root: Item,
}

/// A value with its place in the file.
#[derive(Debug, Clone)]
struct Item {
    /// Line, counted from 1; `None` for a value that was set from the command line.
    line: Option<usize>,
    /// The value as it was written.
    raw: String,
    node: Node,
}

#[derive(Debug, Clone)]
enum Node {
    Text(String),
    Integer(i64),
    Number(f64),
    Boolean(bool),
    /// A date or an integer beyond 64 bits; none of the files uses these.
    Other,
    Array(Vec<Item>),
    /// In the order of the file.
    Table(Vec<(String, Item)>),
}

impl Item {
    fn place(&self) -> Place {
        self.line.map_or(Place::File, Place::Line)
    }
}

impl Document {
    /// Reads and parses a file.
    ///
    /// # Errors
    /// The file cannot be read, is too long, or is not TOML.
    pub fn read(file: &Path) -> Result<Self> {
        Self::parse(file, &read_text(file, LONGEST)?)
    }

    /// Parses the text of a file; `file` is the name that errors use.
    ///
    /// # Errors
    /// The text is not TOML.
    pub fn parse(file: &Path, text: &str) -> Result<Self> {
        let table = DeTable::parse(text).map_err(|error| syntax_error(file, text, &error))?;
        let lines = Lines::of(text);
        let root = Item { line: Some(1), raw: String::new(), node: table_node(table.get_ref(), text, Some(&lines)) };
        Ok(Self { file: file.to_owned(), root })
    }

    /// Sets one value from an assignment `a.b.c = value`; a value that is not TOML is taken as text. `a[2].b` is in the
    /// second element of a list of tables `[[a]]`.
    ///
    /// # Errors
    /// There is no `=`, a key is empty, the path leads through a value that is not a table, or a list is too short.
    pub fn set(&mut self, assignment: &str) -> Result<()> {
        let refuse = |file: &Path, expected: &str| Error::input(file, Place::File, assignment, "", expected);
        let Some((path, value)) = assignment.split_once('=') else {
            return Err(refuse(&self.file, "an assignment KEY=VALUE"));
        };
        let value = value.trim();
        let node = match DeValue::parse(value) {
            Ok(parsed) => value_node(parsed.get_ref(), value, None),
            Err(_) => Node::Text(value.to_owned()),
        };
        let mut item = &mut self.root;
        for key in path.trim().split('.') {
            let Node::Table(entries) = &mut item.node else {
                return Err(refuse(&self.file, "a path of tables"));
            };
            if key.trim().is_empty() {
                return Err(refuse(&self.file, "an assignment KEY=VALUE"));
            }
            if let Some((name, number)) = numbered(key.trim()) {
                let list = entries.iter_mut().find(|(known, _)| known == name).map(|(_, item)| &mut item.node);
                let Some(Node::Array(items)) = list else {
                    return Err(refuse(&self.file, "the name of a list before [ ]"));
                };
                let count = items.len();
                let Some(one) = number.checked_sub(1).and_then(|index| items.get_mut(index)) else {
                    return Err(refuse(&self.file, &format!("a number from 1 to {count} in [ ]")));
                };
                item = one;
                continue;
            }
            let index = entries.iter().position(|(name, _)| name == key.trim()).unwrap_or_else(|| {
                let empty = Item { line: None, raw: String::new(), node: Node::Table(Vec::new()) };
                entries.push((key.trim().to_owned(), empty));
                entries.len() - 1
            });
            item = &mut entries[index].1;
        }
        *item = Item { line: None, raw: value.to_owned(), node };
        Ok(())
    }

    /// The name of this file in errors.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The places of its values.
    pub fn places(&self) -> Places {
        Places::of(&self.root)
    }

    /// Its top-level table.
    pub fn root(&self) -> Table<'_> {
        Table::new(&self.file, String::new(), &self.root)
    }
}

/// Name and number of a key `name[2]`.
fn numbered(key: &str) -> Option<(&str, usize)> {
    let (name, number) = key.strip_suffix(']')?.split_once('[')?;
    Some((name, number.trim().parse().ok()?))
}

/// Offsets of the beginnings of lines.
struct Lines(Vec<usize>);

impl Lines {
    fn of(text: &str) -> Self {
        Self(std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect())
    }

    fn line(&self, offset: usize) -> usize {
        self.0.partition_point(|&start| start <= offset)
    }
}

fn syntax_error(file: &Path, text: &str, error: &toml::de::Error) -> Error {
    let place = error.span().map_or(Place::File, |span| Place::Line(Lines::of(text).line(span.start)));
    let found = error.span().and_then(|span| text.get(span)).unwrap_or_default().lines().next().unwrap_or_default();
    Error::input(file, place, "", "", format!("TOML: {}{}", error.message().trim_end(), quoted(found)))
}

fn quoted(found: &str) -> String {
    if found.is_empty() { String::new() } else { format!(" at `{}`", shortened(found)) }
}

/// The first 60 characters of a text.
fn shortened(text: &str) -> String {
    if text.chars().count() <= 60 { text.to_owned() } else { text.chars().take(57).chain("...".chars()).collect() }
}

fn table_node(table: &DeTable<'_>, text: &str, lines: Option<&Lines>) -> Node {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    let item = |key_start: usize, value: &toml::Spanned<DeValue<'_>>| Item {
        line: lines.map(|lines| lines.line(key_start)),
        raw: match value.get_ref() {
            DeValue::Table(_) => String::new(),
            _ => shortened(text.get(value.span()).unwrap_or_default()),
        },
        node: value_node(value.get_ref(), text, lines),
    };
    Node::Table(
        entries.into_iter().map(|(key, value)| (key.get_ref().to_string(), item(key.span().start, value))).collect(),
    )
}

fn value_node(value: &DeValue<'_>, text: &str, lines: Option<&Lines>) -> Node {
    match value {
        DeValue::String(value) => Node::Text(value.to_string()),
        DeValue::Integer(value) => {
            i64::from_str_radix(value.as_str(), value.radix()).map_or(Node::Other, Node::Integer)
        }
        DeValue::Float(value) => value.as_str().parse().map_or(Node::Other, Node::Number),
        DeValue::Boolean(value) => Node::Boolean(*value),
        DeValue::Datetime(_) => Node::Other,
        DeValue::Table(table) => table_node(table, text, lines),
        DeValue::Array(values) => Node::Array(
            values
                .iter()
                .map(|value| Item {
                    line: lines.map(|lines| lines.line(value.span().start)),
                    raw: match value.get_ref() {
                        DeValue::Table(_) => String::new(),
                        _ => shortened(text.get(value.span()).unwrap_or_default()),
                    },
                    node: value_node(value.get_ref(), text, lines),
                })
                .collect(),
        ),
    }
}

//! The one door for TOML: model files, scenarios, manifests.
//!
//! Every value remembers its line, every getter checks type and range, and [`Table::finish`] refuses the keys that nobody
//! asked for. So a reader of a file is its own list of what the file may hold:
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

mod range;
mod table;
mod write;

use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use crate::error::{Error, Place, Result};

pub use range::Range;
pub use table::{Table, nearest};
pub use write::{write_atomically, write_atomically_with, written_key, written_number, written_text};

/// A parsed file that knows the line of everything in it.
#[derive(Debug, Clone)]
pub struct Document {
    file: PathBuf,
    root: Item,
}

/// A value with the place it came from.
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
    /// A date or an integer beyond 64 bits: nothing that any file of ours holds.
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
    /// The file cannot be read, or is not TOML.
    pub fn read(file: &Path) -> Result<Self> {
        let bytes = std::fs::read(file).map_err(|source| Error::file(file, "read", source))?;
        match String::from_utf8(bytes) {
            Ok(text) => Self::parse(file, &text),
            Err(error) => {
                let line =
                    1 + error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count();
                Err(Error::input(file, Place::Line(line), "", "", "UTF-8 text"))
            }
        }
    }

    /// Parses the text of a file; `file` is what errors call it.
    ///
    /// # Errors
    /// The text is not TOML.
    pub fn parse(file: &Path, text: &str) -> Result<Self> {
        let table = DeTable::parse(text).map_err(|error| syntax_error(file, text, &error))?;
        let lines = Lines::of(text);
        let root = Item { line: Some(1), raw: String::new(), node: table_node(table.get_ref(), text, Some(&lines)) };
        Ok(Self { file: file.to_owned(), root })
    }

    /// Sets one value from an assignment `a.b.c = value`, where a value that is not TOML is taken as text.
    ///
    /// # Errors
    /// There is no `=`, a key is empty, or the path leads through a value that is no table.
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

    /// What errors call this file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Its top-level table.
    pub fn root(&self) -> Table<'_> {
        Table::new(&self.file, String::new(), &self.root)
    }
}

/// Offsets at which lines begin.
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

/// At most 60 characters of a text.
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

//! The elements of an MJCF file and of the files that it includes, with their places.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::error::{Error, Place, Result};
use crate::robot::remark::Remark;
use crate::robot::urdf::{Element, elements};
use crate::toml_input::{nearest, read_text};

/// Largest number of included files.
const MOST_FILES: usize = 200;

/// [bytes] Longest included file.
const LONGEST: u64 = 8 << 20;

/// [bytes] Longest text of all included files together.
const LONGEST_TOGETHER: usize = 8 << 20;

/// Largest number of elements in all files together: a humanoid with hands has a few thousand.
const MOST_ELEMENTS: usize = 200_000;

/// Largest depth of nested includes: deeper ones could overflow the stack of this recursive reader.
const MOST_NESTED: usize = 8;

/// An element; an `<include>` is replaced by what the file contains.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub name: String,
    attributes: Vec<(String, String)>,
    pub children: Vec<Node>,
    file: Rc<PathBuf>,
    line: usize,
    /// Line in the main file: that of the element, or of the `<include>` through which it was read.
    pub main_line: usize,
}

impl Node {
    /// An attribute that is not blank.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(key, _)| key == name);
        found.map(|(_, value)| value.trim()).filter(|value| !value.is_empty())
    }

    /// All attributes.
    pub fn attributes(&self) -> impl Iterator<Item = (&str, &str)> {
        self.attributes.iter().map(|(name, value)| (name.as_str(), value.as_str()))
    }

    /// The element and its name, for errors and remarks: `joint elbow`.
    pub fn title(&self) -> String {
        self.attribute("name").map_or_else(|| self.name.clone(), |name| format!("{} {name}", self.name))
    }

    /// An error about one of its attributes.
    pub fn error(&self, attribute: &str, value: &str, expected: impl Into<String>) -> Error {
        let key = if attribute.is_empty() { self.title() } else { format!("{}: {attribute}", self.title()) };
        Error::input(&self.file, Place::Line(self.line), key, value, expected)
    }

    /// A remark about it.
    pub fn remark(&self, text: &str) -> Remark {
        Remark::new(&self.file, Place::Line(self.line), &self.title(), text)
    }

    /// The children with this name.
    pub fn all<'n>(&'n self, name: &'n str) -> impl Iterator<Item = &'n Node> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// Checks that the value of an attribute is one of these words, and returns it.
    pub fn word(&self, attribute: &str, value: &str, words: &[&'static str]) -> Result<&'static str> {
        words.iter().find(|word| **word == value).copied().ok_or_else(|| {
            let near =
                nearest(value, words.iter().copied()).map_or_else(String::new, |near| format!("; nearest is {near}"));
            self.error(attribute, value, format!("one of {}{near}", words.join(", ")))
        })
    }
}

/// Reads the element `<mujoco>` of a text, with all that it includes.
///
/// # Errors
/// A text is not XML; an included file cannot be read or is included twice; or there are too many files.
pub(super) fn read(file: &Path, text: &str) -> Result<Node> {
    let folder = file.parent().unwrap_or(Path::new("")).to_owned();
    let mut reader = Reader { folder, seen: BTreeSet::new(), length: 0, elements: 0, depth: 0 };
    let mut roots = reader.parse(file, text, None)?;
    match (roots.pop(), roots.is_empty()) {
        (Some(root), true) => Ok(root),
        _ => Err(Error::input(file, Place::Line(1), "MJCF", "", "one outermost element <mujoco>")),
    }
}

struct Reader {
    /// Folder of the main file.
    folder: PathBuf,
    seen: BTreeSet<PathBuf>,
    /// [bytes] read of included files.
    length: usize,
    elements: usize,
    /// Number of included files that are open around the current one.
    depth: usize,
}

impl Reader {
    /// The outermost elements of a text; `main_line`: the line of the main file that includes it.
    fn parse(&mut self, file: &Path, text: &str, main_line: Option<usize>) -> Result<Vec<Node>> {
        let shared = Rc::new(file.to_owned());
        let broken = |(line, expected)| Error::input(file, Place::Line(line), "MJCF", "", expected);
        let all = elements(text).map_err(broken)?;
        self.elements += all.len();
        if self.elements > MOST_ELEMENTS {
            return Err(Error::input(file, Place::File, "MJCF", "", format!("at most {MOST_ELEMENTS} elements")));
        }
        let mut out = Vec::new();
        for (index, element) in all.iter().enumerate() {
            if element.parent.is_none() {
                out.extend(self.node(&all, index, &shared, main_line)?);
            }
        }
        Ok(out)
    }

    /// An element with its children; several where it is an `<include>`.
    fn node(
        &mut self,
        all: &[Element<'_>],
        index: usize,
        file: &Rc<PathBuf>,
        main_line: Option<usize>,
    ) -> Result<Vec<Node>> {
        let element = &all[index];
        let mut node = Node {
            name: element.name.to_owned(),
            attributes: element
                .attributes
                .iter()
                .map(|(key, value)| ((*key).to_owned(), value.clone().into_owned()))
                .collect(),
            children: Vec::new(),
            file: Rc::clone(file),
            line: element.line,
            main_line: main_line.unwrap_or(element.line),
        };
        if node.name == "include" {
            return self.include(&node);
        }
        for &child in &element.children {
            node.children.extend(self.node(all, child, file, main_line)?);
        }
        Ok(vec![node])
    }

    /// The content of an included file. Its path is relative to the main file's folder or, if no file is there, to the including file's.
    fn include(&mut self, node: &Node) -> Result<Vec<Node>> {
        let name = node.attribute("file").ok_or_else(|| node.error("file", "", "the name of a file (missing)"))?;
        let beside = node.file.parent().unwrap_or(Path::new("")).join(name);
        let file = Some(self.folder.join(name)).filter(|file| file.is_file()).unwrap_or(beside);
        if !self.seen.insert(file.clone()) {
            return Err(node.error("file", name, "a file that is not included yet"));
        }
        if self.depth >= MOST_NESTED {
            return Err(node.error("file", name, format!("at most {MOST_NESTED} files that include each other")));
        }
        if self.seen.len() > MOST_FILES {
            return Err(node.error("file", name, format!("at most {MOST_FILES} included files")));
        }
        let text = read_text(&file, LONGEST)
            .map_err(|_| node.error("file", name, "an XML file that exists and can be read"))?;
        self.length += text.len();
        if self.length > LONGEST_TOGETHER {
            return Err(node.error("file", name, format!("at most {LONGEST_TOGETHER} bytes of included files")));
        }
        self.depth += 1;
        let roots = self.parse(&file, &text, Some(node.main_line))?;
        self.depth -= 1;
        Ok(roots.into_iter().flat_map(|root| root.children).collect())
    }
}

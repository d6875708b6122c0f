//! Line numbers in a URDF text: the URDF parser keeps none, so errors take theirs from here.

use std::fmt::Display;
use std::path::Path;

use super::grammar;
use super::scan::{Element, elements};
use crate::error::{Error, Place, Result};

/// A URDF text whose elements and numbers are checked.
pub(super) struct UrdfText<'a> {
    file: &'a Path,
    elements: Vec<Element<'a>>,
}

impl<'a> UrdfText<'a> {
    /// Scans and checks a text.
    ///
    /// # Errors
    /// It is no `<robot>`, a tag is not closed, an element or attribute is missing, or a value is not a number.
    pub(super) fn scan(file: &'a Path, text: &'a str) -> Result<Self> {
        let elements =
            elements(text).map_err(|(line, expected)| Error::input(file, Place::Line(line), "URDF", "", expected))?;
        let scanned = Self { file, elements };
        grammar::check(&scanned)?;
        Ok(scanned)
    }

    pub(super) fn file(&self) -> &'a Path {
        self.file
    }

    pub(super) fn elements(&self) -> &[Element<'a>] {
        &self.elements
    }

    /// The link or joint that contains an element, as `link forearm`; outside of both the element's own name.
    pub(super) fn title(&self, element: &Element<'a>) -> String {
        let mut at = element;
        while let Some(parent) = at.parent.map(|index| &self.elements[index]) {
            if parent.parent.is_none() {
                break;
            }
            at = parent;
        }
        format!("{} {}", at.name, at.attribute("name").unwrap_or("?"))
    }

    /// An error of the text itself.
    pub(super) fn broken(&self, line: usize, expected: impl Into<String>) -> Error {
        Error::input(self.file, Place::Line(line), "URDF", "", expected)
    }

    /// An error about a link or joint; `part` is one of its elements or attributes, or empty for the link or joint
    /// itself.
    pub(super) fn error(
        &self,
        kind: &str,
        name: &str,
        part: &str,
        value: impl Display,
        expected: impl Into<String>,
    ) -> Error {
        let key = if part.is_empty() { format!("{kind} {name}") } else { format!("{kind} {name}: {part}") };
        Error::input(self.file, self.place(kind, name, part), key, value, expected)
    }

    /// Whether a link or joint has an element of this name.
    pub(super) fn has(&self, kind: &str, name: &str, part: &str) -> bool {
        let is_owner = |element: &&Element<'_>| {
            element.parent == Some(0) && element.name == kind && element.attribute("name") == Some(name)
        };
        let owner = self.elements.iter().find(is_owner);
        owner.is_some_and(|owner| owner.children.iter().any(|&child| self.elements[child].name == part))
    }

    /// Line of a link or joint, or of the first of its elements of this name if it has one.
    fn place(&self, kind: &str, name: &str, part: &str) -> Place {
        let is_owner = |element: &Element<'_>| {
            element.parent == Some(0) && element.name == kind && element.attribute("name") == Some(name)
        };
        let Some(owner) = self.elements.iter().position(is_owner) else { return Place::File };
        let inside = |mut index: usize| loop {
            match self.elements[index].parent {
                Some(parent) if parent == owner => return true,
                Some(parent) => index = parent,
                None => return false,
            }
        };
        let part = (0..self.elements.len()).find(|&index| self.elements[index].name == part && inside(index));
        Place::Line(self.elements[part.unwrap_or(owner)].line)
    }
}

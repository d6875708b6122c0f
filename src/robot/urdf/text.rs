//! A scanned URDF text: its elements, and the lines that errors and remarks name.

use std::fmt::Display;
use std::path::Path;

use super::scan::{Element, elements};
use crate::error::{Error, Place, Result};
use crate::robot::remark::Remark;

/// A URDF text, divided into its elements.
pub(super) struct UrdfText<'a> {
    file: &'a Path,
    source: &'a str,
    elements: Vec<Element<'a>>,
}

impl<'a> UrdfText<'a> {
    /// Scans a text. `lines` gives the line of the file for every line of the text, if the two differ.
    ///
    /// # Errors
    /// The text is not XML, or its elements are nested too deeply.
    pub(super) fn scan(file: &'a Path, text: &'a str, lines: Option<&[usize]>) -> Result<Self> {
        let of_file = |line: usize| lines.and_then(|lines| lines.get(line - 1)).copied().unwrap_or(line);
        let broken = |(line, expected)| Error::input(file, Place::Line(of_file(line)), "URDF", "", expected);
        let mut elements = elements(text).map_err(broken)?;
        elements.iter_mut().for_each(|element| element.line = of_file(element.line));
        Ok(Self { file, source: text, elements })
    }

    /// The file, as errors name it.
    pub(super) fn file(&self) -> &'a Path {
        self.file
    }

    pub(super) fn elements(&self) -> &[Element<'a>] {
        &self.elements
    }

    /// The link or joint that contains an element, such as `link forearm`; for an element outside of both, its own name.
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

    /// A remark about a link or joint; `part` as for an error.
    pub(super) fn remark(&self, kind: &str, name: &str, part: &str, text: &str) -> Remark {
        Remark::new(self.file, self.place(kind, name, part), &format!("{kind} {name}"), text)
    }

    /// A remark about an element.
    pub(super) fn remark_at(&self, element: &Element<'a>, text: &str) -> Remark {
        Remark::new(self.file, Place::Line(element.line), &self.title(element), text)
    }

    /// The links or joints, in the order of the file.
    pub(super) fn owners(&self, kind: &str) -> impl Iterator<Item = &Element<'a>> {
        self.elements.first().into_iter().flat_map(move |robot| self.children(robot, kind))
    }

    /// The link or joint of this name.
    pub(super) fn owner(&self, kind: &str, name: &str) -> Option<&Element<'a>> {
        self.owners(kind).find(|element| element.attribute("name") == Some(name))
    }

    /// The elements directly inside another one.
    pub(super) fn inside(&self, element: &Element<'a>) -> impl Iterator<Item = &Element<'a>> {
        element.children.iter().map(|&child| &self.elements[child])
    }

    /// The elements of one name directly inside another one.
    pub(super) fn children(&self, element: &Element<'a>, name: &str) -> impl Iterator<Item = &Element<'a>> {
        self.inside(element).filter(move |child| child.name == name)
    }

    /// The first element of one name directly inside another one.
    pub(super) fn child(&self, element: &Element<'a>, name: &str) -> Option<&Element<'a>> {
        self.children(element, name).next()
    }

    /// The text inside an element, up to the next tag.
    pub(super) fn content(&self, element: &Element<'a>) -> &'a str {
        let inside = self.source.get(element.inside..element.range.end).unwrap_or_default();
        inside.split('<').next().unwrap_or_default()
    }

    /// Version of URDF, 1.0 if none is given.
    pub(super) fn version(&self) -> (u32, u32) {
        let given = self.elements.first().and_then(|robot| robot.attribute("version"));
        let split = given.and_then(|version| version.trim().split_once('.'));
        split.and_then(|(major, minor)| Some((major.parse().ok()?, minor.parse().ok()?))).unwrap_or((1, 0))
    }

    /// Line of a link or joint, or of the first of its elements of this name if it has one.
    pub(super) fn place(&self, kind: &str, name: &str, part: &str) -> Place {
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

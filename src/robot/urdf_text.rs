//! Where things stand in a URDF text, and whether its numbers are numbers.
//!
//! The URDF parser keeps no lines and drops what it cannot read within a vector; this scan gives errors their lines.

use std::path::Path;

use crate::error::{Error, Place, Result};

/// The opening tags of a URDF that belong to its links and joints.
pub(super) struct UrdfText<'a> {
    file: &'a Path,
    tags: Vec<Tag<'a>>,
}

struct Tag<'a> {
    line: usize,
    name: &'a str,
    attributes: Vec<(&'a str, &'a str)>,
    /// Index of the link or joint tag that this one stands in, or its own index if it is one.
    owner: usize,
}

impl Tag<'_> {
    fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| *key == name).map(|(_, value)| *value)
    }
}

/// Attributes that hold numbers: element, attribute, how many, whether it must be there, whether infinity is allowed.
const NUMBERS: &[(&str, &str, usize, bool, bool)] = &[
    ("origin", "xyz", 3, false, false),
    ("origin", "rpy", 3, false, false),
    ("axis", "xyz", 3, true, false),
    ("mass", "value", 1, true, false),
    ("inertia", "ixx", 1, true, false),
    ("inertia", "ixy", 1, true, false),
    ("inertia", "ixz", 1, true, false),
    ("inertia", "iyy", 1, true, false),
    ("inertia", "iyz", 1, true, false),
    ("inertia", "izz", 1, true, false),
    ("limit", "lower", 1, false, true),
    ("limit", "upper", 1, false, true),
    ("limit", "effort", 1, false, true),
    ("limit", "velocity", 1, false, true),
    ("dynamics", "damping", 1, false, false),
    ("dynamics", "friction", 1, false, false),
    ("mimic", "multiplier", 1, false, false),
    ("mimic", "offset", 1, false, false),
    ("box", "size", 3, true, false),
    ("sphere", "radius", 1, true, false),
    ("cylinder", "radius", 1, true, false),
    ("cylinder", "length", 1, true, false),
    ("capsule", "radius", 1, true, false),
    ("capsule", "length", 1, true, false),
    ("mesh", "scale", 3, false, false),
];

/// Attributes that hold names.
const NAMES: &[(&str, &str)] = &[
    ("link", "name"),
    ("joint", "name"),
    ("joint", "type"),
    ("parent", "link"),
    ("child", "link"),
    ("mesh", "filename"),
];

/// No URDF is nested as deep as this; the parser behind this scan would run out of stack.
const MAX_DEPTH: usize = 64;

impl<'a> UrdfText<'a> {
    /// Scans a text.
    ///
    /// # Errors
    /// It is no `<robot>`, a tag is not closed, a number is none, or a necessary attribute is missing.
    pub(super) fn scan(file: &'a Path, text: &'a str) -> Result<Self> {
        let mut scanned = Self { file, tags: Vec::new() };
        let mut open: Vec<(&str, usize)> = Vec::new();
        let mut owner = None;
        let mut seen_root = false;
        let mut line = 1;
        let mut rest = text;
        while let Some(start) = rest.find('<') {
            line += newlines(&rest[..start]);
            rest = &rest[start..];
            let length = markup_length(rest).ok_or_else(|| scanned.broken(line, "the end of this tag"))?;
            let (markup, after) = rest.split_at(length);
            if !markup.starts_with("<!") && !markup.starts_with("<?") {
                if let Some(name) = markup.strip_prefix("</") {
                    let name = name.trim_end_matches('>').trim();
                    match open.pop() {
                        Some((opened, _)) if opened == name => {}
                        Some((opened, at)) => {
                            return Err(
                                scanned.broken(line, format!("</{opened}> for the tag of line {at}, not </{name}>"))
                            );
                        }
                        None => return Err(scanned.broken(line, format!("no </{name}> here"))),
                    }
                    if open.len() < 2 {
                        owner = None;
                    }
                } else {
                    let closed = markup.ends_with("/>");
                    let inner = markup.trim_start_matches('<').trim_end_matches('>').trim_end_matches('/');
                    let (name, attributes) = split_tag(inner);
                    match open.len() {
                        0 if seen_root || name != "robot" => {
                            return Err(scanned.broken(line, "one <robot> around everything"));
                        }
                        0 => seen_root = true,
                        1 => owner = matches!(name, "link" | "joint").then_some(scanned.tags.len()),
                        _ => {}
                    }
                    if let Some(owner) = owner {
                        scanned.tags.push(Tag { line, name, attributes, owner });
                    }
                    if open.len() >= MAX_DEPTH {
                        return Err(scanned.broken(line, format!("at most {MAX_DEPTH} elements within each other")));
                    }
                    if !closed {
                        open.push((name, line));
                    } else if open.len() < 2 {
                        owner = None;
                    }
                }
            }
            line += newlines(markup);
            rest = after;
        }
        if let Some((name, at)) = open.pop() {
            return Err(scanned.broken(at, format!("a closing </{name}>")));
        }
        if !seen_root {
            return Err(scanned.broken(1, "one <robot> around everything"));
        }
        scanned.check_names()?;
        scanned.check_numbers()?;
        Ok(scanned)
    }

    /// An error about a link or joint: `part` is one of its elements (empty: itself), `key` what is wrong there.
    pub(super) fn error(
        &self,
        kind: &str,
        name: &str,
        part: &str,
        value: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> Error {
        let key = if part.is_empty() { format!("{kind} {name}") } else { format!("{kind} {name}: {part}") };
        Error::input(self.file, self.place(kind, name, part), key, value, expected)
    }

    /// Line of a link or joint, or of one of its elements where it has it.
    fn place(&self, kind: &str, name: &str, part: &str) -> Place {
        let owner = self
            .tags
            .iter()
            .enumerate()
            .find(|(index, tag)| tag.owner == *index && tag.name == kind && tag.attribute("name") == Some(name));
        let Some((index, owner)) = owner else { return Place::File };
        let part = self.tags.iter().find(|tag| tag.owner == index && tag.name == part);
        Place::Line(part.unwrap_or(owner).line)
    }

    fn broken(&self, line: usize, expected: impl Into<String>) -> Error {
        Error::input(self.file, Place::Line(line), "URDF", "", expected)
    }

    fn check_names(&self) -> Result<()> {
        for tag in &self.tags {
            for (_, attribute) in NAMES.iter().filter(|(element, _)| *element == tag.name) {
                if tag.attribute(attribute).is_none_or(str::is_empty) {
                    return Err(Error::input(
                        self.file,
                        Place::Line(tag.line),
                        self.key(tag, attribute),
                        "",
                        "a name (missing)",
                    ));
                }
            }
        }
        Ok(())
    }

    fn check_numbers(&self) -> Result<()> {
        for tag in &self.tags {
            for &(_, attribute, count, needed, infinite) in NUMBERS.iter().filter(|entry| entry.0 == tag.name) {
                let expected = if count == 1 { "a number".to_owned() } else { format!("{count} numbers") };
                let error = |value: &str, expected: String| {
                    Error::input(self.file, Place::Line(tag.line), self.key(tag, attribute), value, expected)
                };
                match tag.attribute(attribute) {
                    None if needed => return Err(error("", format!("{expected} (missing)"))),
                    None => {}
                    Some(text) if holds_numbers(text, count, infinite) => {}
                    Some(text) => return Err(error(&format!("\"{text}\""), expected)),
                }
            }
        }
        Ok(())
    }

    fn key(&self, tag: &Tag<'_>, attribute: &str) -> String {
        let owner = &self.tags[tag.owner];
        let name = owner.attribute("name").unwrap_or("?");
        if std::ptr::eq(owner, tag) {
            format!("{} {name}: {attribute}", owner.name)
        } else {
            format!("{} {name}: {} {attribute}", owner.name, tag.name)
        }
    }
}

fn holds_numbers(text: &str, count: usize, infinite: bool) -> bool {
    let is_number =
        |word: &str| word.parse::<f64>().is_ok_and(|value| value.is_finite() || (infinite && !value.is_nan()));
    text.split_whitespace().count() == count && text.split_whitespace().all(is_number)
}

fn newlines(text: &str) -> usize {
    text.bytes().filter(|&byte| byte == b'\n').count()
}

/// Length of the markup that a text begins with; `>` inside quotes and comments does not end it.
fn markup_length(text: &str) -> Option<usize> {
    for (opening, closing) in [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")] {
        if let Some(inside) = text.strip_prefix(opening) {
            return inside.find(closing).map(|at| opening.len() + at + closing.len());
        }
    }
    let mut quote = None;
    for (at, character) in text.char_indices() {
        match (quote, character) {
            (None, '"' | '\'') => quote = Some(character),
            (Some(open), _) if open == character => quote = None,
            (None, '>') => return Some(at + 1),
            _ => {}
        }
    }
    None
}

/// Name and attributes of an opening tag without its angle brackets.
fn split_tag(inner: &str) -> (&str, Vec<(&str, &str)>) {
    let inner = inner.trim();
    let end = inner.find(char::is_whitespace).unwrap_or(inner.len());
    let (name, mut rest) = inner.split_at(end);
    let mut attributes = Vec::new();
    while let Some((key, after)) = rest.split_once('=') {
        let after = after.trim_start();
        let Some(quote) = after.chars().next().filter(|c| matches!(c, '"' | '\'')) else { break };
        let Some((value, next)) = after[1..].split_once(quote) else { break };
        attributes.push((key.trim(), value));
        rest = next;
    }
    (name, attributes)
}

//! Elements of an XML text with their lines; covers only the part of XML that a URDF uses. Namespaces are not resolved: a prefix is part
//! of the name.

use std::borrow::Cow;

/// An element: its opening tag and its parent element.
pub(in crate::robot) struct Element<'a> {
    pub line: usize,
    pub name: &'a str,
    /// Names and values, entities resolved.
    pub attributes: Vec<Attribute<'a>>,
    /// Index of the parent element; `None` for the outermost.
    pub parent: Option<usize>,
    /// Indices of its direct children.
    pub children: Vec<usize>,
    /// Bytes of the text from its opening to its closing tag.
    pub range: std::ops::Range<usize>,
    /// First byte after its opening tag.
    pub inside: usize,
}

impl Element<'_> {
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| *key == name).map(|(_, value)| value.as_ref())
    }

    /// An attribute that is not blank.
    pub fn given(&self, name: &str) -> Option<&str> {
        self.attribute(name).filter(|value| !value.trim().is_empty())
    }
}

pub(in crate::robot) type Attribute<'a> = (&'a str, Cow<'a, str>);

/// A line, and what was expected there.
pub(in crate::robot) type Fault = (usize, String);

/// No URDF is nested as deeply as this; a recursive parser would overflow the stack.
const MAX_DEPTH: usize = 64;

/// The elements in the order of their opening tags.
///
/// # Errors
/// Tags that are not closed, or closed in the wrong order; more than one outermost element; attributes or entities that XML does not know.
pub(in crate::robot) fn elements(text: &str) -> Result<Vec<Element<'_>>, Fault> {
    let mut elements: Vec<Element<'_>> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    let mut line = 1;
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        line += newlines(&rest[..start]);
        let length = markup_length(&rest[start..]).ok_or_else(|| (line, "the end of this tag".to_owned()))?;
        let (markup, after) = rest[start..].split_at(length);
        let end = text.len() - after.len();
        if let Some(name) = markup.strip_prefix("</") {
            let closed = close(&elements, &mut open, name.trim_end_matches('>').trim());
            elements[closed.map_err(|expected| (line, expected))?].range.end = end;
        } else if !markup.starts_with("<!") && !markup.starts_with("<?") {
            if open.is_empty() && !elements.is_empty() {
                return Err((line, "nothing after the outermost element".to_owned()));
            }
            if open.len() >= MAX_DEPTH {
                return Err((line, format!("at most {MAX_DEPTH} elements within each other")));
            }
            let inner = markup.trim_start_matches('<').trim_end_matches('>');
            let (name, attributes) = split_tag(inner.trim_end_matches('/')).map_err(|expected| (line, expected))?;
            let parent = open.last().copied();
            if !inner.ends_with('/') {
                open.push(elements.len());
            }
            if let Some(parent) = parent {
                let index = elements.len();
                elements[parent].children.push(index);
            }
            let range = end - length..end;
            elements.push(Element { line, name, attributes, parent, children: Vec::new(), range, inside: end });
        }
        line += newlines(markup);
        rest = after;
    }
    match open.last() {
        Some(&last) => Err((elements[last].line, format!("a closing </{}>", elements[last].name))),
        None => Ok(elements),
    }
}

/// Closes the innermost open element, and returns its index.
fn close(elements: &[Element<'_>], open: &mut Vec<usize>, name: &str) -> Result<usize, String> {
    let Some(index) = open.pop() else {
        return Err(format!("no </{name}> here"));
    };
    let last = &elements[index];
    if last.name == name {
        return Ok(index);
    }
    Err(format!("</{}> for the tag of line {}, not </{name}>", last.name, last.line))
}

fn newlines(text: &str) -> usize {
    text.bytes().filter(|&byte| byte == b'\n').count()
}

/// Length of the markup at the beginning of a text; `>` inside quotes and comments does not end it.
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
fn split_tag(inner: &str) -> Result<(&str, Vec<Attribute<'_>>), String> {
    let end = inner.find(char::is_whitespace).unwrap_or(inner.len());
    let (name, mut rest) = inner.split_at(end);
    if name.is_empty() {
        return Err("the name of an element behind `<`".to_owned());
    }
    let mut attributes = Vec::new();
    while !rest.trim_start().is_empty() {
        let (key, value, next) =
            split_attribute(rest).ok_or_else(|| format!("attributes as name=\"value\" in <{name}>"))?;
        attributes.push((key, resolved(value)?));
        rest = next;
    }
    Ok((name, attributes))
}

/// The first attribute of a text: name, value, and what follows.
fn split_attribute(text: &str) -> Option<(&str, &str, &str)> {
    let (key, after) = text.split_once('=')?;
    let after = after.trim_start();
    let quote = after.chars().next().filter(|c| matches!(c, '"' | '\''))?;
    let (value, next) = after[1..].split_once(quote)?;
    let key = key.trim();
    (!key.is_empty() && !key.contains(char::is_whitespace)).then_some((key, value, next))
}

/// A value with its entities resolved.
fn resolved(value: &str) -> Result<Cow<'_, str>, String> {
    let mut parts = value.split('&');
    let first = parts.next().unwrap_or_default();
    if first.len() == value.len() {
        return Ok(Cow::Borrowed(value));
    }
    let mut text = first.to_owned();
    for part in parts {
        let known = part.split_once(';').and_then(|(name, after)| Some((character(name)?, after)));
        let (character, after) = known.ok_or("&amp; for the character `&`, or an entity that XML knows")?;
        text.push(character);
        text.push_str(after);
    }
    Ok(Cow::Owned(text))
}

fn character(entity: &str) -> Option<char> {
    match entity {
        "lt" => Some('<'),
        "gt" => Some('>'),
        "amp" => Some('&'),
        "quot" => Some('"'),
        "apos" => Some('\''),
        _ => {
            let number = entity.strip_prefix('#')?;
            let code = match number.strip_prefix('x') {
                Some(hex) => u32::from_str_radix(hex, 16).ok()?,
                None => number.parse().ok()?,
            };
            char::from_u32(code)
        }
    }
}

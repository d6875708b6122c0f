//! Text files: regular files of a bounded size, in UTF-8 or UTF-16.

use std::io::Read as _;
use std::path::Path;

use crate::error::{Error, Place, Result};
use crate::files::regular;

/// Reads a text file of at most `longest` bytes. UTF-16 with a byte order mark, which some Windows editors write, is read as well.
///
/// # Errors
/// It is not a regular file, it is too long, or it is neither UTF-8 nor UTF-16.
pub fn read_text(file: &Path, longest: u64) -> Result<String> {
    decoded(file, read_bytes(file, longest)?)
}

/// Reads a regular file of at most `longest` bytes: a device or a pipe may have no end.
///
/// # Errors
/// It is not a regular file, it is longer, or the operating system refuses it.
pub fn read_bytes(file: &Path, longest: u64) -> Result<Vec<u8>> {
    let refused = |source| Error::file(file, "read", source);
    if let Some(content) = crate::files::embedded(file) {
        return content.map_err(refused);
    }
    let (open, _) = regular::open(file, longest, "")?;
    let mut bytes = Vec::new();
    // Special files such as those in `/proc` may contain more than their stated length.
    open.take(longest + 1).read_to_end(&mut bytes).map_err(refused)?;
    if bytes.len() as u64 > longest {
        let expected = format!("at most {}", regular::shown(longest));
        return Err(Error::input(file, Place::File, "size", "more than its length says", expected));
    }
    Ok(bytes)
}

fn decoded(file: &Path, bytes: Vec<u8>) -> Result<String> {
    if let Some(rest) = bytes.strip_prefix(&[0xFF, 0xFE]) {
        return wide(file, rest, u16::from_le_bytes);
    }
    if let Some(rest) = bytes.strip_prefix(&[0xFE, 0xFF]) {
        return wide(file, rest, u16::from_be_bytes);
    }
    // Zero bytes behind the last letter end the text as a string of C ends.
    let mut bytes = bytes;
    if let Some(last) = bytes.iter().rposition(|&byte| byte != 0) {
        bytes.truncate(last + 1);
    }
    let line = |end: usize| Place::Line(1 + bytes[..end].iter().filter(|&&byte| byte == b'\n').count());
    // UTF-16 without a byte order mark: every second byte of its letters is zero, which never occurs in text.
    if let Some(zero) = bytes.iter().position(|&byte| byte == 0) {
        let expected = "UTF-8 text, which holds no zero bytes; save UTF-16 with its byte order mark, or as UTF-8";
        return Err(Error::input(file, line(zero), "", "", expected));
    }
    match std::str::from_utf8(&bytes) {
        Ok(text) => Ok(text.strip_prefix('\u{FEFF}').unwrap_or(text).to_owned()),
        Err(error) => Err(Error::input(file, line(error.valid_up_to()), "", "", "UTF-8 text")),
    }
}

/// Converts UTF-16 to a string. The encoding in an XML declaration is no longer true then, and is removed.
fn wide(file: &Path, bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<String> {
    let (units, rest) = bytes.as_chunks::<2>();
    let mut text = String::with_capacity(units.len());
    for character in char::decode_utf16(units.iter().map(|&pair| unit(pair))) {
        match character {
            Ok(character) => text.push(character),
            Err(_) => return Err(broken(file, &text)),
        }
    }
    if !rest.is_empty() {
        return Err(broken(file, &text));
    }
    if let Some(end) = text.strip_prefix("<?xml").and_then(|after| after.find("?>")).map(|at| at + "<?xml".len()) {
        let declaration = text[..end].to_owned();
        if let Some((before, _)) = declaration.split_once("encoding") {
            text.replace_range(..end, before);
        }
    }
    Ok(text)
}

fn broken(file: &Path, before: &str) -> Error {
    let line = 1 + before.matches('\n').count();
    Error::input(file, Place::Line(line), "", "", "UTF-16 text, as its byte order mark says")
}

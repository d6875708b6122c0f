//! Spelling of TOML where a file is written, and writing it whole or not at all.

use std::path::Path;

use crate::error::{Error, Result};

/// A number that reads back as the same `f64`.
pub fn written_number(value: f64) -> String {
    format!("{value:?}")
}

/// Text in quotes.
pub fn written_text(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A key, in quotes where it needs them.
pub fn written_key(key: &str) -> String {
    let bare = !key.is_empty() && key.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'-');
    if bare { key.to_owned() } else { written_text(key) }
}

/// Writes a file beside its place and moves it there, so that no reader ever sees half of it.
///
/// # Errors
/// The operating system refuses; nothing is left behind then.
pub fn write_atomically(file: &Path, content: &str) -> Result<()> {
    let mut name = file.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    let part = file.with_file_name(name);
    std::fs::write(&part, content).and_then(|()| std::fs::rename(&part, file)).map_err(|source| {
        // The part may not exist; the error worth telling is the first one.
        let _ = std::fs::remove_file(&part);
        Error::file(file, "write", source)
    })
}

//! Spelling of TOML values in written files, and writing a file completely or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Write};
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

/// A key, in quotes if it needs them.
pub fn written_key(key: &str) -> String {
    let bare = !key.is_empty() && key.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'-');
    if bare { key.to_owned() } else { written_text(key) }
}

/// Writes a temporary file and renames it, so that no reader sees an incomplete file.
///
/// # Errors
/// The operating system refuses; then nothing is left behind.
pub fn write_atomically(file: &Path, content: &str) -> Result<()> {
    write_atomically_with(file, |out| out.write_all(content.as_bytes()))
}

/// As [`write_atomically`], with content that is written piece by piece.
///
/// # Errors
/// The operating system refuses; then nothing is left behind.
pub fn write_atomically_with(file: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let mut name = file.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    let part = file.with_file_name(name);
    let written = || {
        let mut out = BufWriter::new(File::create(&part)?);
        content(&mut out)?;
        out.into_inner().map_err(io::IntoInnerError::into_error)?;
        std::fs::rename(&part, file)
    };
    written().map_err(|source| {
        // The temporary file may not exist; the first error is the one to report.
        let _ = std::fs::remove_file(&part);
        Error::file(file, "write", source)
    })
}

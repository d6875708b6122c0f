//! Opens files for reading: regular files of bounded size.
//!
//! Reading a device or a pipe may never end, and a file of unlimited size takes unlimited memory. Both are refused
//! before the first byte is read.

use std::fs::{self, File, Metadata};
use std::path::Path;

use crate::error::{Error, Place, Result};

/// Size [bytes] of a regular file of at most `max` bytes; `advice` says what to do with a larger one. Symbolic links
/// are followed.
///
/// # Errors
/// It is not a regular file, it is larger, or the operating system refuses it.
pub fn size(path: &Path, max: u64, advice: &str) -> Result<u64> {
    let found = fs::metadata(path).map_err(|source| Error::file(path, "read", source))?;
    if !found.is_file() {
        return Err(Error::input(path, Place::File, "", format!("({})", kind(&found)), "a regular file"));
    }
    let size = found.len();
    if size > max {
        let colon = if advice.is_empty() { "" } else { ": " };
        let expected = format!("at most {}{colon}{advice}", shown(max));
        return Err(Error::input(path, Place::File, "size", shown(size), expected));
    }
    Ok(size)
}

/// Opens a file that passes [`size`]; returns its length too.
///
/// # Errors
/// As [`size`].
pub fn open(path: &Path, max: u64, advice: &str) -> Result<(File, u64)> {
    size(path, max, advice)?;
    let file = File::open(path).map_err(|source| Error::file(path, "read", source))?;
    // The same check on the open file: the name may refer to another file by now.
    let found = file.metadata().map_err(|source| Error::file(path, "read", source))?;
    if !found.is_file() || found.len() > max {
        size(path, max, advice)?;
    }
    Ok((file, found.len()))
}

/// A size in the unit that suits it.
pub fn shown(bytes: u64) -> String {
    const UNITS: [(u64, &str); 3] = [(30, "GiB"), (20, "MiB"), (10, "KiB")];
    match UNITS.iter().find(|(shift, _)| bytes >> shift > 0) {
        Some(&(shift, unit)) => format!("{:.1} {unit}", bytes as f64 / (1_u64 << shift) as f64).replace(".0 ", " "),
        None => format!("{bytes} bytes"),
    }
}

/// What kind of file it is, if it is not a regular one.
fn kind(found: &Metadata) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        let kind = found.file_type();
        if kind.is_fifo() {
            return "a pipe";
        } else if kind.is_socket() {
            return "a socket";
        } else if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
    }
    if found.is_dir() { "a folder" } else { "no file" }
}

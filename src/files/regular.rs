//! Opening what is to be read: a regular file of bounded size.
//!
//! A device or a pipe never ends or never answers, and a file of any length takes any memory. Both are refused before the first byte is read.

use std::fs::{self, File, Metadata};
use std::path::Path;

use crate::error::{Error, Place, Result};

/// Size [bytes] of a regular file of at most `max` bytes; `advice` is what to do where it is larger. Symbolic links are followed.
///
/// # Errors
/// It is no regular file, or larger; and the operating system refuses.
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

/// Opens a file that [`size`] lets pass; gives its length too.
///
/// # Errors
/// As [`size`].
pub fn open(path: &Path, max: u64, advice: &str) -> Result<(File, u64)> {
    size(path, max, advice)?;
    let file = File::open(path).map_err(|source| Error::file(path, "read", source))?;
    // The same question to what was opened: the name may point elsewhere by now.
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

/// What it is instead of a regular file.
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

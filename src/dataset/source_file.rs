//! Opening what is to be read: a regular file of bounded size.
//!
//! A device or a pipe never ends or never answers, and a file of any length takes any memory. Both are refused before the first byte is read.

use std::fs::{self, File, Metadata};
use std::path::Path;

use crate::error::{Error, Place, Result};

/// Cells, rows times columns, of the largest table that is read: 30 minutes of six joints with eight channels each at 1 kHz are
/// 0.9·10⁸, and as numbers of eight bytes they fill the 0.8 GB that a recording may take in memory.
pub(super) const MAX_CELLS: usize = 100_000_000;

/// Columns of the widest table that is read. Above the 2400 of 300 joints with eight channels by a factor of 40.
pub(super) const MAX_COLUMNS: usize = 100_000;

/// Largest file of data [bytes], and the most that one decompresses to: [`MAX_CELLS`] written with twenty characters each, which is
/// what a number in full precision takes.
pub(super) const MAX_BYTES: u64 = 2 << 30;

/// Largest manifest [bytes]: 10,000 joints with eight channels of 100 characters each are 8 MB.
pub(super) const MAX_MANIFEST_BYTES: u64 = 16 << 20;

/// Refuses what is no regular file, is empty, or is larger than `max` bytes. Symbolic links are followed.
///
/// # Errors
/// As said; and the operating system refuses.
pub(super) fn check(path: &Path, max: u64) -> Result<u64> {
    let found = fs::metadata(path).map_err(|source| Error::file(path, "read", source))?;
    if !found.is_file() {
        return Err(Error::input(path, Place::File, "", format!("({})", kind(&found)), "a regular file"));
    }
    match found.len() {
        0 => Err(Error::input(path, Place::File, "size", "0 bytes", "a file that is not empty")),
        size if size > max => {
            let expected = format!(
                "at most {}: cut the recording into shorter sessions, or leave out what is not needed",
                shown(max)
            );
            Err(Error::input(path, Place::File, "size", shown(size), expected))
        }
        size => Ok(size),
    }
}

/// Opens a file that passes [`check`]; gives its length too.
///
/// # Errors
/// As [`check`].
pub(super) fn open(path: &Path) -> Result<(File, u64)> {
    check(path, MAX_BYTES)?;
    let file = File::open(path).map_err(|source| Error::file(path, "read", source))?;
    // The same question to what was opened: the name may point elsewhere by now.
    let found = file.metadata().map_err(|source| Error::file(path, "read", source))?;
    if !found.is_file() || found.len() > MAX_BYTES {
        check(path, MAX_BYTES)?;
    }
    Ok((file, found.len()))
}

/// A size in the unit that suits it.
pub(super) fn shown(bytes: u64) -> String {
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

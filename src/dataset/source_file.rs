//! Size limits of recordings, and opening one.

use std::fs::File;
use std::path::Path;

use crate::error::{Error, Place, Result};
use crate::files::regular;
pub(super) use crate::files::regular::shown;

/// Cells (rows times columns) of the largest table that is read. 30 minutes of six joints with eight channels each at 1
/// kHz are 0.9·10⁸ cells. With eight bytes each they take 0.8 GB. That leaves 0.2 GB of 1 GB for the program, the part of the file that is
/// being read, and room that was reserved for rows that do not come; so columns are made as long as they will be.
pub(super) const MAX_CELLS: usize = 100_000_000;

/// Columns of the widest table that is read: 40 times the 2400 columns of 300 joints with eight channels.
pub(super) const MAX_COLUMNS: usize = 100_000;

/// Largest data file, and largest decompressed size [bytes]: [`MAX_CELLS`] with twenty characters each, the length of a
/// number in full precision.
pub(super) const MAX_BYTES: u64 = 2 << 30;

/// Largest manifest [bytes]: 10,000 joints with eight channels of 100 characters each are 8 MB.
pub(super) const MAX_MANIFEST_BYTES: u64 = 16 << 20;

/// Advice for a larger file.
const ADVICE: &str = "cut the recording into shorter sessions, or leave out what is not needed";

/// Refuses a file that is not regular, is empty, or is larger than `max` bytes.
///
/// # Errors
/// As stated; or the operating system refuses.
pub(super) fn check(path: &Path, max: u64) -> Result<()> {
    regular::size(path, max, ADVICE).and_then(|size| not_empty(path, size))
}

/// Opens a recording that is not empty and has at most [`MAX_BYTES`]; returns its length too.
///
/// # Errors
/// As [`check`].
pub(super) fn open(path: &Path) -> Result<(File, u64)> {
    let (file, size) = regular::open(path, MAX_BYTES, ADVICE)?;
    not_empty(path, size)?;
    Ok((file, size))
}

fn not_empty(path: &Path, size: u64) -> Result<()> {
    if size > 0 {
        return Ok(());
    }
    Err(Error::input(path, Place::File, "size", "0 bytes", "a file that is not empty"))
}

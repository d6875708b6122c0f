//! The format of a file of data, recognised by its first bytes; its name does not matter. A format that is not read is
//! refused, with advice on how to convert the file.

use std::path::Path;

use super::csv::{GZIP, Text};
use crate::error::{Error, Place, Result};

/// The formats that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    /// Columns of text.
    Text,
    /// JSON.
    Json,
    /// MATLAB 5.
    Mat,
    /// An array of numpy.
    Npy,
    /// Arrays of numpy in a ZIP archive.
    Npz,
    /// Apache Parquet.
    Parquet,
    /// MCAP.
    Mcap,
    /// SQLite, in which ROS 2 keeps bags.
    Db3,
}

/// First bytes of formats that are read.
const READ: [(&[u8], Format); 6] = [
    (b"MATLAB 5.0", Format::Mat),
    (b"\x93NUMPY", Format::Npy),
    (b"PK\x03\x04", Format::Npz),
    (b"PAR1", Format::Parquet),
    (b"\x89MCAP0", Format::Mcap),
    (b"SQLite format 3\0", Format::Db3),
];

/// First bytes of formats that are not read; name of the format; advice on the conversion, in which `STEM` is the file's name without its
/// ending and `FILE` its whole name.
const REFUSED: [(&[u8], &str, &str); 14] = [
    (b"\x89HDF\r\n\x1a\n", "HDF5", HDF5),
    (b"MATLAB 7.3", "MATLAB 7.3, which is HDF5", MATLAB_73),
    (b"ARROW1", "Feather or Arrow", FEATHER),
    (b"FEA1", "Feather", FEATHER),
    (
        b"#ROSBAG V",
        "a bag of ROS 1",
        "an MCAP file: `mcap convert FILE STEM.mcap`, with the command `mcap` of foxglove",
    ),
    (b"\xd0\xcf\x11\xe0", "an old spreadsheet (.xls)", SPREADSHEET),
    (b"\x28\xb5\x2f\xfd", "compressed by zstd", "a file that is not compressed by zstd: `unzstd FILE -o STEM`"),
    (b"\xfd7zXZ", "compressed by xz", "a file that is not compressed by xz: `unxz FILE`"),
    (b"BZh", "compressed by bzip2", "a file that is not compressed by bzip2: `bunzip2 FILE`"),
    (b"\x80\x04", "a pickle of Python", PICKLE),
    (b"\x80\x05", "a pickle of Python", PICKLE),
    (b"ULog\x01", "a log of PX4 (ULog)", "CSV: `ulog2csv FILE`, of the Python package pyulog"),
    (b"TDSm", "TDMS of LabVIEW", "CSV: `tdmsinfo` and `nptdms` of Python convert it, or LabVIEW saves it as text"),
    (b"%PDF", "a PDF", "the data themselves, as CSV"),
];

const HDF5: &str = "CSV: `python3 -c \"import h5py, pandas; f = h5py.File('FILE'); pandas.DataFrame({k: v[()].ravel() \
                    for k, v in f.items() if getattr(v, 'size', 0) > 1}).to_csv('STEM.csv', index=False)\"`";
const MATLAB_73: &str = "a MATLAB 5 file: in MATLAB `s = load('FILE'); save('STEM_v7.mat', '-struct', 's', '-v7')`; or CSV: `python3 -c \
                         \"import h5py, pandas; f = h5py.File('FILE'); pandas.DataFrame({k: v[()].ravel() for k, v in f.items() \
                         if getattr(v, 'size', 0) > 1}).to_csv('STEM.csv', index=False)\"`";
const FEATHER: &str = "Parquet: `python3 -c \"import pandas; pandas.read_feather('FILE').to_parquet('STEM.parquet')\"`";
const PICKLE: &str = "CSV: `python3 -c \"import pandas; pandas.read_pickle('FILE').to_csv('STEM.csv')\"`";
const SPREADSHEET: &str = "the sheet saved as CSV";

/// Recognises the format of a file.
///
/// # Errors
/// It cannot be opened, or it has a format that is not read; the message names the format and the conversion.
pub(super) fn of(text: Text<'_>) -> Result<Format> {
    let head = text.raw_head()?;
    if let Some((_, format)) = READ.iter().find(|(magic, _)| head.starts_with(magic)) {
        return match format {
            Format::Npz if !has_arrays(&head) => {
                refuse(text.path(), "a spreadsheet (.xlsx) or another archive (ZIP)", SPREADSHEET)
            }
            format => Ok(*format),
        };
    }
    if let Some((_, what, way)) = REFUSED.iter().find(|(magic, ..)| head.starts_with(magic)) {
        return refuse(text.path(), what, way);
    }
    // MATLAB's own header may begin with any text; its end is fixed.
    if matches!(head.get(124..128), Some([0, 1, b'I', b'M'] | [1, 0, b'M', b'I'])) {
        return Ok(Format::Mat);
    }
    let head = if head.starts_with(GZIP) { text.head()?.0 } else { head };
    let begins = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head).trim_ascii_start();
    Ok(if matches!(begins, [b'{' | b'[', ..]) { Format::Json } else { Format::Text })
}

/// Whether the first entry of an archive is an array of numpy.
fn has_arrays(head: &[u8]) -> bool {
    let length = head.get(26..28).map_or(0, |bytes| usize::from(u16::from_le_bytes([bytes[0], bytes[1]])));
    head.get(30..30 + length).is_some_and(|name| name.ends_with(b".npy"))
}

fn refuse<T>(path: &Path, what: &str, way: &str) -> Result<T> {
    Err(Error::input(path, Place::File, "format", what, way_for(path, way)))
}

/// An advice for a file: `FILE` becomes its name, `STEM` its name without the ending.
pub(super) fn way_for(path: &Path, way: &str) -> String {
    let plain = |name: Option<&std::ffi::OsStr>, other: &str| {
        let name = name.unwrap_or_default().to_string_lossy();
        // Only characters that every shell and program takes as part of a name.
        let harmless = |c: char| c.is_alphanumeric() || matches!(c, '.' | '_' | '-' | '+');
        if !name.is_empty() && name.chars().all(harmless) { name.into_owned() } else { other.to_owned() }
    };
    way.replace("FILE", &plain(path.file_name(), "FILE")).replace("STEM", &plain(path.file_stem(), "NAME"))
}

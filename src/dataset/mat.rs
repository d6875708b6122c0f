//! MATLAB 5 files: every numeric vector is a column, every numeric matrix gives columns `name.1`, `name.2` ..., one for
//! each entry of its shorter side. The fields of a structure are read likewise, as `name.field`. Arrays of one element are parameters
//! of the experiment and are skipped. Left out: arrays of structures, cells, text, sparse arrays, objects.
//!
//! ```text
//!   128 bytes of header, the last two `IM` (least byte first) or `MI`; then elements, each a tag (type u32, length u32) and that many bytes:
//!   an array (type 14), or one compressed by zlib (type 15)
//! ```
//! Reference: MathWorks, "MAT-File Format", chapter 1.

mod array;

use std::io::{self, Read};
use std::path::Path;

use flate2::read::ZlibDecoder;

use self::array::{Bytes, Found};
use super::source_file::{self, MAX_BYTES};
use super::table::{Table, check_cells, check_count};
use crate::error::{Error, Place, Result};

/// Length of the header and of an element's tag [bytes].
const HEADER: usize = 128;
const TAG: u64 = 8;
/// Types of the elements of a file.
const ARRAY: u32 = 14;
const COMPRESSED: u32 = 15;

/// Reads all numeric arrays with more than one element.
///
/// # Errors
/// The file cannot be read, is not a MATLAB 5 file, is cut off or damaged, contains complex numbers or arrays of more than two
/// dimensions, or is too large.
pub(super) fn read(path: &Path) -> Result<Table> {
    let (file, size) = source_file::open(path)?;
    decode(path, io::BufReader::new(file.take(size)), size)
}

/// As [`read`], from memory.
///
/// # Errors
/// As [`read`].
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Table> {
    decode(path, bytes, bytes.len() as u64)
}

fn decode(path: &Path, mut input: impl Read, size: u64) -> Result<Table> {
    let little_endian = header(path, &mut input)?;
    let (mut columns, mut count) = (Vec::new(), 0);
    let (mut at, mut cells) = (HEADER as u64, 0);
    while at < size {
        count += 1;
        let key = format!("array {count}");
        let refuse = |value: String, expected: String| Err(Error::input(path, Place::File, &key, value, expected));
        let mut tag = Bytes { input: &mut input, left: TAG, little_endian };
        let (Ok(kind), Ok(length)) = (tag.u32(), tag.u32()) else {
            return refuse("cut off".into(), "a whole file".into());
        };
        at += TAG + u64::from(length);
        if kind != ARRAY && kind != COMPRESSED {
            return refuse(format!("element type {kind}"), format!("an array ({ARRAY} or {COMPRESSED})"));
        }
        if at > size {
            return refuse("cut off".into(), format!("a whole file: {at} bytes, it has {size}"));
        }
        let mut body = input.by_ref().take(u64::from(length));
        let found = if kind == ARRAY {
            array::read(Bytes { input: &mut body, left: u64::from(length), little_endian }, cells)
        } else {
            inflated(&mut body, little_endian, cells)
        };
        match found {
            Ok(Found::Columns(found)) => {
                cells += found.iter().map(|column| column.values.len() as u64).sum::<u64>();
                columns.extend(found);
            }
            Ok(Found::Unfit { name, value, expected }) => {
                return Err(Error::input(path, Place::File, name, value, expected));
            }
            Ok(Found::TooLarge(total)) => {
                return check_cells(path, total, 1).and_then(|()| refuse(String::new(), String::new()));
            }
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                return refuse("cut off".into(), "an array as long as its tag says".into());
            }
            Err(_) => return refuse("damaged".into(), "an array of MATLAB 5 as its format describes it".into()),
        }
        check_count(path, Place::File, columns.len())?;
        io::copy(&mut body, &mut io::sink()).map_err(|source| Error::file(path, "read", source))?;
    }
    Table::new(path, Place::File, columns, Vec::new())
}

/// Reads the header; returns whether the least byte comes first.
fn header(path: &Path, input: &mut impl Read) -> Result<bool> {
    let mut header = Vec::new();
    input.take(HEADER as u64).read_to_end(&mut header).map_err(|source| Error::file(path, "read", source))?;
    match header.get(HEADER - 2..) {
        Some(b"IM") => Ok(true),
        Some(b"MI") => Ok(false),
        _ => {
            let newer = header.starts_with(b"\x89HDF") || header.starts_with(b"MATLAB 7.3");
            let found = if newer { "MATLAB 7.3" } else { "" };
            Err(Error::input(path, Place::File, "format", found, "a MATLAB 5 file (save with -v6 or -v7)"))
        }
    }
}

/// The array in a compressed element. Only the data that are kept are decompressed.
fn inflated(body: &mut impl Read, little_endian: bool, cells: u64) -> io::Result<Found> {
    let mut plain = ZlibDecoder::new(body);
    let mut tag = Bytes { input: &mut plain, left: TAG, little_endian };
    let (kind, length) = (tag.u32()?, u64::from(tag.u32()?));
    if kind != ARRAY || length > MAX_BYTES {
        return Err(io::ErrorKind::InvalidData.into());
    }
    let found = array::read(Bytes { input: &mut plain, left: length, little_endian }, cells)?;
    // Reading to the end of the stream verifies its checksum.
    if matches!(&found, Found::Columns(columns) if !columns.is_empty()) && plain.read(&mut [0; 8])? != 0 {
        return Err(io::ErrorKind::InvalidData.into());
    }
    Ok(found)
}

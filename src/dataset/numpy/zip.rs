//! The entries of a ZIP archive, stored or deflated.
//!
//! ```text
//!   entries, directory, end of the directory: `PK\5\6` ... entries u16, size u32, place u32, length of a comment u16, comment
//! ```
//! Sizes of 4 GB and more stand in an extension (ZIP64); no recording is as large.
//! Reference: PKWARE, "APPNOTE.TXT - .ZIP File Format Specification", 4.3.

use std::io::{Read, Seek, SeekFrom};

use flate2::read::DeflateDecoder;

/// Length of the records without their names [bytes]: end of the directory, entry of the directory, head of an entry.
const END: u64 = 22;
const ENTRY: usize = 46;
const HEAD: usize = 30;
/// Longest comment of an archive [bytes].
const COMMENT: u64 = 1 << 16;
/// Largest directory [bytes]: 100,000 entries with names of 100 characters.
const MAX_DIRECTORY: u32 = 1 << 24;

/// An entry of an archive.
pub(super) struct Entry {
    pub(super) name: String,
    deflated: bool,
    /// [bytes] in the file.
    length: u64,
    place: u64,
}

/// The entries of an archive of `size` bytes; `None` if it is damaged, encrypted or compressed otherwise.
pub(super) fn entries<R: Read + Seek>(input: &mut R, size: u64) -> Option<Vec<Entry>> {
    let start = size.saturating_sub(END + COMMENT);
    let tail = bytes(input, start, size - start)?;
    let end = tail.windows(4).rposition(|four| four == b"PK\x05\x06")?;
    let (length, place) = (word(&tail, end + 12)?, word(&tail, end + 16)?);
    if length > MAX_DIRECTORY || u64::from(place) + u64::from(length) > size {
        return None;
    }
    let directory = bytes(input, u64::from(place), u64::from(length))?;
    let mut entries = Vec::new();
    let mut rest = directory.as_slice();
    while !rest.is_empty() {
        if !rest.starts_with(b"PK\x01\x02") || rest.len() < ENTRY {
            return None;
        }
        let [name, extra, comment] = [28, 30, 32].map(|at| half(rest, at).map_or(0, usize::from));
        let entry = Entry {
            name: String::from_utf8_lossy(rest.get(ENTRY..ENTRY + name)?).into_owned(),
            deflated: half(rest, 10)? == 8,
            length: u64::from(word(rest, 20)?),
            place: u64::from(word(rest, 42)?),
        };
        let known = half(rest, 8)? & 1 == 0 && matches!(half(rest, 10)?, 0 | 8);
        if !known || entry.place + entry.length > size {
            return None;
        }
        entries.push(entry);
        rest = rest.get(ENTRY + name + extra + comment..)?;
    }
    Some(entries)
}

/// The content of an entry.
pub(super) fn content<'a, R: Read + Seek>(input: &'a mut R, entry: &Entry) -> Option<Box<dyn Read + 'a>> {
    let head = bytes(input, entry.place, HEAD as u64)?;
    if !head.starts_with(b"PK\x03\x04") {
        return None;
    }
    let names = u64::from(half(&head, 26)?) + u64::from(half(&head, 28)?);
    input.seek(SeekFrom::Start(entry.place + HEAD as u64 + names)).ok()?;
    let packed = input.take(entry.length);
    Some(if entry.deflated { Box::new(std::io::BufReader::new(DeflateDecoder::new(packed))) } else { Box::new(packed) })
}

fn bytes<R: Read + Seek>(input: &mut R, place: u64, length: u64) -> Option<Vec<u8>> {
    input.seek(SeekFrom::Start(place)).ok()?;
    let mut bytes = Vec::new();
    input.take(length).read_to_end(&mut bytes).ok()?;
    (bytes.len() as u64 == length).then_some(bytes)
}

fn half(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

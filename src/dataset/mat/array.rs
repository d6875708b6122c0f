//! One array of a MATLAB 5 file.
//!
//! ```text
//!   flags (u32: class, complex; u32), dimensions (i32 each), name, real part [, imaginary part]
//! ```
//! Each part is a tag and its bytes, padded to eight; up to four bytes are in the tag itself.

use std::io::{self, ErrorKind, Read};

use super::super::source_file::MAX_CELLS;
use super::super::table::Column;

/// Classes of arrays of numbers, double to u64.
const NUMERIC: std::ops::RangeInclusive<u32> = 6..=15;
/// Flag of complex numbers.
const COMPLEX: u32 = 0x0800;
/// Largest size of dimensions and of a name [bytes]: MATLAB has names of 63 characters.
const MAX_PART: u64 = 4096;
/// Bytes of numbers that are converted at once.
const PIECE: usize = 1 << 16;

/// Content of an element.
pub(super) enum Found {
    /// A vector of real numbers.
    Column(Column),
    /// A single number, a structure, text, or nothing.
    Other,
    /// Numbers that are not a column.
    Unfit { name: String, value: String, expected: &'static str },
    /// Too many numbers; the total count.
    TooLarge(u64),
}

/// A part of an input of known length, with the byte order of its numbers.
pub(super) struct Bytes<'a, R> {
    pub(super) input: &'a mut R,
    pub(super) left: u64,
    pub(super) little_endian: bool,
}

/// The tag of a part: type of its numbers, their length in bytes, and the bytes in the tag itself.
struct Tag {
    kind: u32,
    length: u64,
    small: Option<[u8; 4]>,
}

impl<R: Read> Bytes<'_, R> {
    fn fill(&mut self, bytes: &mut [u8]) -> io::Result<()> {
        self.left = self.left.checked_sub(bytes.len() as u64).ok_or(ErrorKind::InvalidData)?;
        self.input.read_exact(bytes)
    }

    fn number<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        if !self.little_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// The next number.
    pub(super) fn u32(&mut self) -> io::Result<u32> {
        self.number().map(u32::from_le_bytes)
    }

    fn tag(&mut self) -> io::Result<Tag> {
        let word = self.u32()?;
        let (kind, length) = (word & 0xffff, word >> 16);
        if length == 0 {
            return Ok(Tag { kind, length: u64::from(self.u32()?), small: None });
        }
        let mut small = [0; 4];
        self.fill(&mut small)?;
        if length > 4 {
            Err(ErrorKind::InvalidData.into())
        } else {
            Ok(Tag { kind, length: u64::from(length), small: Some(small) })
        }
    }

    /// The bytes of a short part, without its padding.
    fn part(&mut self) -> io::Result<Vec<u8>> {
        let tag = self.tag()?;
        if let Some(small) = tag.small {
            return Ok(small[..tag.length as usize].to_vec());
        }
        if tag.length > MAX_PART {
            return Err(ErrorKind::InvalidData.into());
        }
        let mut bytes = vec![0; tag.length.next_multiple_of(8) as usize];
        self.fill(&mut bytes)?;
        bytes.truncate(tag.length as usize);
        Ok(bytes)
    }
}

/// Reads an array. `cells`: count of numbers that were read before.
///
/// # Errors
/// `UnexpectedEof` if the input ends, `InvalidData` if it does not follow the format.
pub(super) fn read<R: Read>(mut bytes: Bytes<'_, R>, cells: u64) -> io::Result<Found> {
    if bytes.left == 0 {
        return Ok(Found::Other);
    }
    let flags = word(&bytes.part()?, bytes.little_endian).ok_or(ErrorKind::InvalidData)?;
    if !NUMERIC.contains(&(flags & 0xff)) {
        return Ok(Found::Other);
    }
    let little_endian = bytes.little_endian;
    let sizes: Vec<u64> = bytes.part()?.chunks(4).filter_map(|size| word(size, little_endian)).map(u64::from).collect();
    let name = String::from_utf8_lossy(&bytes.part()?).into_owned();
    let count = sizes.iter().try_fold(1_u64, |product, size| product.checked_mul(*size)).unwrap_or(u64::MAX);
    // An array without a name contains MATLAB's own objects.
    if count < 2 || name.is_empty() {
        return Ok(Found::Other);
    }
    if flags & COMPLEX != 0 {
        return Ok(Found::Unfit { name, value: "complex numbers".into(), expected: "real numbers" });
    }
    if !sizes.contains(&count) {
        let value = sizes.iter().map(u64::to_string).collect::<Vec<_>>().join("×");
        return Ok(Found::Unfit { name, value, expected: "a vector: one row or one column" });
    }
    let total = cells.saturating_add(count);
    if total > MAX_CELLS as u64 {
        return Ok(Found::TooLarge(total));
    }
    numbers(&mut bytes, Column::new(name), count).map(Found::Column)
}

fn word(bytes: &[u8], little_endian: bool) -> Option<u32> {
    let bytes: [u8; 4] = bytes.get(..4)?.try_into().ok()?;
    Some(if little_endian { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
}

fn numbers<R: Read>(bytes: &mut Bytes<'_, R>, mut column: Column, count: u64) -> io::Result<Column> {
    let tag = bytes.tag()?;
    let size = width(tag.kind).ok_or(ErrorKind::InvalidData)?;
    if tag.length != count * size as u64 {
        return Err(ErrorKind::InvalidData.into());
    }
    if let Some(small) = tag.small {
        convert(&small[..tag.length as usize], tag.kind, bytes.little_endian, &mut column);
        return Ok(column);
    }
    let mut left = tag.length as usize;
    let mut piece = vec![0; PIECE.min(left)];
    while left > 0 {
        let length = left.min(PIECE);
        bytes.fill(&mut piece[..length])?;
        convert(&piece[..length], tag.kind, bytes.little_endian, &mut column);
        left -= length;
    }
    // The padding belongs to the array; files of other programs may lack it at the end.
    let padding = tag.length.next_multiple_of(8) - tag.length;
    let padding = padding.min(bytes.left) as usize;
    bytes.fill(&mut [0; 8][..padding])?;
    Ok(column)
}

/// Bytes of a number of that type.
fn width(kind: u32) -> Option<usize> {
    match kind {
        1 | 2 => Some(1),
        3 | 4 => Some(2),
        5..=7 => Some(4),
        9 | 12 | 13 => Some(8),
        _ => None,
    }
}

fn convert(bytes: &[u8], kind: u32, little_endian: bool, column: &mut Column) {
    for number in bytes.chunks_exact(width(kind).unwrap_or(1)) {
        // Extended to eight bytes by sign or zero, least byte first.
        let negative = if little_endian { number.last() } else { number.first() }.is_some_and(|&byte| byte >= 0x80);
        let fill = if matches!(kind, 1 | 3 | 5 | 12) && negative { 0xff } else { 0 };
        let mut wide = [fill; 8];
        for (at, &byte) in number.iter().enumerate() {
            wide[if little_endian { at } else { number.len() - 1 - at }] = byte;
        }
        match kind {
            7 => column.values.push(f64::from(f32::from_bits(u64::from_le_bytes(wide) as u32))),
            9 => column.values.push(f64::from_le_bytes(wide)),
            13 => match i64::try_from(u64::from_le_bytes(wide)) {
                Ok(value) => column.put_parts(value, 0.0),
                Err(_) => column.put(Some(u64::from_le_bytes(wide) as f64), String::new),
            },
            _ => column.put_parts(i64::from_le_bytes(wide), 0.0),
        }
    }
}

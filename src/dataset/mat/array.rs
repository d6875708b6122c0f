//! One array of a MATLAB 5 file.
//!
//! ```text
//!   flags (u32: class, complex; u32), dimensions (i32 each), name, real part [, imaginary part]
//! ```
//! Each part is a tag and its bytes, padded to eight; up to four bytes are in the tag itself.

use std::io::{self, ErrorKind, Read};

use super::super::source_file::{MAX_CELLS, MAX_COLUMNS};
use super::super::table::Column;

/// Classes of arrays of numbers, double to u64.
const NUMERIC: std::ops::RangeInclusive<u32> = 6..=15;
/// Class of structures.
const STRUCTURE: u32 = 2;
/// Type of an element that is an array.
const ARRAY: u32 = 14;
/// Deepest nesting of structures that is read.
const MAX_DEPTH: usize = 8;
/// Flag of complex numbers.
const COMPLEX: u32 = 0x0800;
/// Largest size of dimensions, of a name and of the names of a structure [bytes]: MATLAB has names of 63 characters.
const MAX_PART: u64 = 1 << 16;
/// Bytes of numbers that are converted at once.
const PIECE: usize = 1 << 16;

/// Content of an element.
pub(super) enum Found {
    /// The columns of real numbers; none for a single number, text, or nothing.
    Columns(Vec<Column>),
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
    array(&mut bytes, "", cells, 0)
}

/// Reads an array: a field of the structure `parent`, or a variable if `parent` is empty.
fn array<R: Read>(bytes: &mut Bytes<'_, R>, parent: &str, cells: u64, depth: usize) -> io::Result<Found> {
    let nothing = || Ok(Found::Columns(Vec::new()));
    if bytes.left == 0 {
        return nothing();
    }
    let little_endian = bytes.little_endian;
    let flags = word(&bytes.part()?, little_endian).ok_or(ErrorKind::InvalidData)?;
    let class = flags & 0xff;
    if !NUMERIC.contains(&class) && class != STRUCTURE {
        return nothing();
    }
    let sizes: Vec<u64> = bytes.part()?.chunks(4).filter_map(|size| word(size, little_endian)).map(u64::from).collect();
    let own = String::from_utf8_lossy(&bytes.part()?).into_owned();
    // A field has no name of its own, and neither have MATLAB's own objects.
    let name = if depth == 0 { own } else { parent.to_owned() };
    let count = sizes.iter().try_fold(1_u64, |product, size| product.checked_mul(*size)).unwrap_or(u64::MAX);
    if name.is_empty() {
        return nothing();
    }
    if class == STRUCTURE {
        return if count == 1 && depth < MAX_DEPTH { structure(bytes, &name, cells, depth) } else { nothing() };
    }
    if count < 2 {
        return nothing();
    }
    if flags & COMPLEX != 0 {
        return Ok(Found::Unfit { name, value: "complex numbers".into(), expected: "real numbers" });
    }
    let longest = sizes.iter().copied().max().unwrap_or(0);
    let side = count / longest.max(1);
    if sizes.iter().filter(|size| **size > 1).count() > 2 || side > MAX_COLUMNS as u64 {
        let value = sizes.iter().map(u64::to_string).collect::<Vec<_>>().join("×");
        return Ok(Found::Unfit { name, value, expected: "a vector, or a matrix with a column for each joint" });
    }
    let total = cells.saturating_add(count);
    if total > MAX_CELLS as u64 {
        return Ok(Found::TooLarge(total));
    }
    let all = numbers(bytes, Column::new(&name), count)?;
    if side == 1 {
        return Ok(Found::Columns(vec![all]));
    }
    // Numbers stand column by column; the longer side holds the samples.
    let by_rows = sizes.first() != Some(&longest);
    Ok(Found::Columns(split(&all, side as usize, by_rows)))
}

/// The columns of a matrix of `side` columns; `by_rows`: whether the numbers of one sample stand together.
fn split(all: &Column, side: usize, by_rows: bool) -> Vec<Column> {
    let rows = all.values.len() / side;
    let column = |at: usize| {
        let values = (0..rows).map(|row| all.values[if by_rows { row * side + at } else { at * rows + row }]);
        Column { values: values.collect(), origin: all.origin, ..Column::new(format!("{}.{}", all.name, at + 1)) }
    };
    (0..side).map(column).collect()
}

/// The columns of the fields of a structure: length of their names, names, then each field as an array of its own.
fn structure<R: Read>(bytes: &mut Bytes<'_, R>, name: &str, cells: u64, depth: usize) -> io::Result<Found> {
    let length = word(&bytes.part()?, bytes.little_endian).ok_or(ErrorKind::InvalidData)? as usize;
    let names = bytes.part()?;
    if length == 0 || length > MAX_PART as usize {
        return Err(ErrorKind::InvalidData.into());
    }
    let mut columns: Vec<Column> = Vec::new();
    for field in names.chunks(length) {
        let field = field.split(|&byte| byte == 0).next().unwrap_or_default();
        let field = format!("{name}.{}", String::from_utf8_lossy(field));
        let tag = bytes.tag()?;
        if tag.kind != ARRAY || tag.small.is_some() || tag.length > bytes.left {
            return Err(ErrorKind::InvalidData.into());
        }
        let read = cells + columns.iter().map(|column| column.values.len() as u64).sum::<u64>();
        let mut inner = Bytes { input: &mut *bytes.input, left: tag.length, little_endian: bytes.little_endian };
        match array(&mut inner, &field, read, depth + 1)? {
            Found::Columns(found) => columns.extend(found),
            other => return Ok(other),
        }
        let rest = inner.left;
        io::copy(&mut bytes.input.by_ref().take(rest), &mut io::sink())?;
        bytes.left -= tag.length;
    }
    Ok(Found::Columns(columns))
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

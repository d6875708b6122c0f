//! One array of numpy.
//!
//! ```text
//!   \x93NUMPY, version u8 u8, length of the header u16 (from version 2: u32), header, numbers
//!   {'descr': '<f8', 'fortran_order': False, 'shape': (30000, 2), }
//! ```

use std::io::Read;

use super::super::table::Column;

/// Largest header [bytes]: 1000 fields with names of 50 characters.
const MAX_HEADER: u32 = 1 << 16;
/// Most fields and columns of an array.
const MAX_WIDTH: u64 = 100_000;

/// Why an array is not read.
pub(super) enum Fault {
    /// It does not follow the format.
    Damaged,
    /// It holds something else than a table of numbers.
    Unfit(&'static str),
}

/// Type of the numbers of a field.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kind {
    /// `f`, `i`, `u`, or `b`.
    letter: char,
    /// [bytes]
    width: usize,
    big_endian: bool,
    /// [s] Unit of a date or duration.
    seconds: Option<f64>,
}

/// A field of a structured array. Any other array has one field, without a name.
#[derive(Debug, Clone, PartialEq)]
struct Field {
    name: String,
    kind: Kind,
    /// Count of numbers, or none for a single one.
    count: Option<usize>,
}

/// The header of an array.
#[derive(Debug)]
pub(super) struct Array {
    fields: Vec<Field>,
    rows: u64,
    /// Columns of a matrix; none for a vector.
    side: Option<usize>,
    /// Whether the numbers of a column stand together.
    by_columns: bool,
}

impl Array {
    /// Reads the header.
    pub(super) fn read(input: &mut dyn Read) -> Result<Self, Fault> {
        let header = header(input).ok_or(Fault::Damaged)?;
        let described = after(&header, "descr").ok_or(Fault::Damaged)?;
        let fortran = after(&header, "fortran_order").is_some_and(|text| text.starts_with("True"));
        let shape =
            after(&header, "shape").and_then(|text| text.strip_prefix('(')?.split_once(')')).ok_or(Fault::Damaged)?.0;
        let sizes = shape.split(',').map(str::trim).filter(|size| !size.is_empty());
        let sizes: Vec<u64> = sizes.map(str::parse).collect::<Result<_, _>>().map_err(|_| Fault::Damaged)?;
        let fields = fields(described)?;
        match *sizes.as_slice() {
            [rows] => Ok(Self { fields, rows, side: None, by_columns: false }),
            // The longer side holds the samples.
            [first, second] if fields.len() == 1 && fields[0].count.is_none() => {
                let (rows, side) = (first.max(second), first.min(second));
                let side = usize::try_from(side).ok().filter(|_| side <= MAX_WIDTH);
                let side = Some(side.ok_or(Fault::Unfit("too many columns"))?);
                Ok(Self { fields, rows, side, by_columns: fortran != (first < second) })
            }
            [] => Err(Fault::Unfit("a single number")),
            _ => Err(Fault::Unfit("more than two dimensions")),
        }
    }

    /// Count of rows.
    pub(super) fn rows(&self) -> u64 {
        self.rows
    }

    /// Count of columns.
    pub(super) fn width(&self) -> usize {
        self.side.unwrap_or_else(|| self.fields.iter().map(|field| field.count.unwrap_or(1)).sum())
    }

    /// Reads the numbers; `None` if they are cut off.
    pub(super) fn columns(&self, name: &str, input: &mut dyn Read) -> Option<Vec<Column>> {
        let mut columns = Vec::new();
        for field in &self.fields {
            let seconds = field.kind.seconds;
            let dot = if name.is_empty() || field.name.is_empty() { "" } else { "." };
            let name = format!("{name}{dot}{}", field.name);
            match self.side.or(field.count) {
                None => columns.push((Column { seconds, ..Column::new(name) }, field.kind)),
                Some(count) => columns.extend(
                    (0..count).map(|at| (Column { seconds, ..Column::new(format!("{name}.{at}")) }, field.kind)),
                ),
            }
        }
        if self.by_columns {
            for (column, kind) in &mut columns {
                (0..self.rows).try_for_each(|_| kind.put(input, column))?;
            }
        } else if !columns.is_empty() {
            for _ in 0..self.rows {
                columns.iter_mut().try_for_each(|(column, kind)| kind.put(input, column))?;
            }
        }
        Some(columns.into_iter().map(|(column, _)| column).collect())
    }
}

fn header(input: &mut dyn Read) -> Option<String> {
    let mut start = [0; 8];
    input.read_exact(&mut start).ok()?;
    if !start.starts_with(b"\x93NUMPY") {
        return None;
    }
    let mut length = [0; 4];
    input.read_exact(&mut length[..if start[6] == 1 { 2 } else { 4 }]).ok()?;
    let length = Some(u32::from_le_bytes(length)).filter(|length| *length <= MAX_HEADER)?;
    let mut header = vec![0; length as usize];
    input.read_exact(&mut header).ok()?;
    String::from_utf8(header).ok()
}

/// What follows a key of the header.
fn after<'h>(header: &'h str, key: &str) -> Option<&'h str> {
    let (_, rest) = header.split_once(&format!("'{key}'"))?;
    Some(rest.trim_start().strip_prefix(':')?.trim_start())
}

/// The fields of a description: `'<f8'`, or `[('time', '<f8'), ('q', '<f8', (6,))]`.
fn fields(described: &str) -> Result<Vec<Field>, Fault> {
    if let Some(text) = described.strip_prefix('\'') {
        let kind = Kind::of(text.split('\'').next().unwrap_or_default())?;
        return Ok(vec![Field { name: String::new(), kind, count: None }]);
    }
    let list = described.strip_prefix('[').ok_or(Fault::Damaged)?;
    let list = list.split(']').next().unwrap_or_default();
    // A unit of time has brackets of its own.
    let list = if list.contains("[") { &described[1..described.rfind(']').ok_or(Fault::Damaged)?] } else { list };
    let mut fields = Vec::new();
    for entry in list.split("('").skip(1) {
        let (name, rest) = entry.split_once('\'').ok_or(Fault::Damaged)?;
        let mut parts = rest.splitn(3, '\'').skip(1);
        let kind = Kind::of(parts.next().unwrap_or_default())?;
        let count = match parts.next().and_then(|rest| rest.split_once('(')) {
            None => None,
            Some((_, sizes)) => {
                let sizes = sizes.split(')').next().unwrap_or_default().trim_end_matches(',').trim();
                Some(sizes.parse().map_err(|_| Fault::Unfit("a field of several dimensions"))?)
            }
        };
        if count.is_some_and(|count| count as u64 > MAX_WIDTH) {
            return Err(Fault::Unfit("too many columns"));
        }
        fields.push(Field { name: name.to_owned(), kind, count });
    }
    if fields.is_empty() { Err(Fault::Unfit("no fields")) } else { Ok(fields) }
}

impl Kind {
    /// The type that numpy writes like this: `<f8`, `|b1`, `>i4`, `<M8[ns]`.
    fn of(text: &str) -> Result<Self, Fault> {
        let mut rest = text.chars();
        let big_endian = rest.next().ok_or(Fault::Damaged)? == '>';
        let letter = rest.next().ok_or(Fault::Damaged)?;
        let (width, unit) = rest.as_str().split_once('[').unwrap_or((rest.as_str(), ""));
        let width: usize = width.parse().map_err(|_| Fault::Unfit("text or objects"))?;
        let kind = |letter, seconds| Ok(Self { letter, width, big_endian, seconds });
        match (letter, width) {
            ('f', 4 | 8) | ('i' | 'u', 1 | 2 | 4 | 8) | ('b', 1) => kind(letter, None),
            ('M' | 'm', 8) => {
                let seconds = [("s]", 1.0), ("ms]", 1e-3), ("us]", 1e-6), ("ns]", 1e-9)];
                let seconds = seconds.into_iter().find(|(name, _)| *name == unit).map(|(_, seconds)| seconds);
                kind('i', Some(seconds.ok_or(Fault::Unfit("dates"))?))
            }
            ('c', _) => Err(Fault::Unfit("complex numbers")),
            _ => Err(Fault::Unfit("text or objects")),
        }
    }

    /// Reads a number into a column.
    fn put(self, input: &mut dyn Read, column: &mut Column) -> Option<()> {
        let mut bytes = [0; 8];
        input.read_exact(&mut bytes[..self.width]).ok()?;
        if self.big_endian {
            bytes[..self.width].reverse();
        }
        let unsigned = u64::from_le_bytes(bytes);
        match (self.letter, self.width) {
            ('f', 4) => column.values.push(f64::from(f32::from_bits(unsigned as u32))),
            ('f', _) => column.values.push(f64::from_bits(unsigned)),
            ('i', width) => {
                let shift = 64 - 8 * width as u32;
                let whole = (unsigned << shift).cast_signed() >> shift;
                // The smallest integer stands for a missing date.
                if self.seconds.is_some() && whole == i64::MIN {
                    column.put(None, String::new);
                } else {
                    column.put_parts(whole, 0.0);
                }
            }
            _ => match i64::try_from(unsigned) {
                Ok(whole) => column.put_parts(whole, 0.0),
                Err(_) => column.put(Some(unsigned as f64), String::new),
            },
        }
        Some(())
    }
}

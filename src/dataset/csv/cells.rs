//! The cells of a row: numbers, times, units; and rows whose cells are separated by blanks.

use std::io::{self, Cursor, Read};

use csv::ByteRecord;

use super::super::date_time;
use super::super::table::Column;
use super::super::unit_words;

/// Bytes of a cell that an error message shows.
const SHOWN_BYTES: usize = 40;
/// [s] Unit of dates and times of day.
const NANOSECOND: f64 = 1e-9;

/// Puts a cell into its column: a number, or a date or time in ns.
pub(super) fn put(column: &mut Column, cell: &[u8], decimal: u8) {
    let bytes = cell.trim_ascii();
    let text = std::str::from_utf8(bytes).ok();
    if decimal == b',' && bytes.contains(&b',') {
        let with_point = text.unwrap_or_default().replace(',', ".");
        return put_text(column, Some(&with_point), bytes);
    }
    put_text(column, text, bytes);
}

fn put_text(column: &mut Column, text: Option<&str>, bytes: &[u8]) {
    // Only a column that begins with a large number is stored relative to it.
    let relative = column.values.is_empty() || column.origin != 0;
    if let Some((whole, fraction)) = text.filter(|_| relative).and_then(parts) {
        return column.put_parts(whole, fraction);
    }
    let value = text.and_then(|text| text.parse().ok());
    if value.is_none() && (column.values.is_empty() || column.seconds.is_some()) {
        let shown = std::str::from_utf8(bytes).unwrap_or_default();
        if let Some(time) = date_time::nanoseconds(shown) {
            column.seconds = Some(NANOSECOND);
            return column.put_parts(time, 0.0);
        }
    }
    column.put(value, || String::from_utf8_lossy(&bytes[..bytes.len().min(SHOWN_BYTES)]).into_owned());
}

/// Whole part and fraction of a long decimal number such as a time stamp since 1970; `None` for anything else.
fn parts(text: &str) -> Option<(i64, f64)> {
    /// Least number of digits before the decimal point of a number that is split.
    const LONG: usize = 9;
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    if digits < LONG {
        return None;
    }
    let (whole, rest) = text.split_at(digits);
    let plain = rest.is_empty() || (rest.starts_with('.') && rest[1..].bytes().all(|byte| byte.is_ascii_digit()));
    let fraction = if rest.len() > 1 { rest.parse().ok()? } else { 0.0 };
    if plain { Some((whole.parse().ok()?, fraction)) } else { None }
}

/// Whether the cells of the row below the header are units: no numbers, and at least half of them known units.
pub(super) fn are_units(record: &ByteRecord) -> bool {
    let cells: Vec<String> = record.iter().map(|cell| super::dialect::decoded(cell).trim().to_owned()).collect();
    let filled = cells.iter().filter(|cell| !cell.is_empty());
    let known = cells.iter().filter(|cell| unit_words::unit_of(unit_words::bare(cell)).is_some()).count();
    let numbers = filled.clone().any(|cell| cell.parse::<f64>().is_ok());
    known > 0 && !numbers && 2 * known >= filled.count()
}

/// Passes text on with one blank for each run of blanks and tabs, and none at the ends of a line.
pub(super) struct Blanks<R> {
    input: R,
    /// Whether a blank must precede the next character, and whether its line has any text before it.
    due: bool,
    begun: bool,
    /// Bytes of the input that are converted, and how far they are passed on.
    ready: Cursor<Vec<u8>>,
}

impl<R: Read> Blanks<R> {
    pub(super) fn new(input: R) -> Self {
        Self { input, due: false, begun: false, ready: Cursor::default() }
    }

    /// Converts the next bytes; none at the end of the input.
    fn convert(&mut self) -> io::Result<Vec<u8>> {
        const PIECE: u64 = 1 << 14;
        // A piece may consist of blanks alone; an empty one is the end.
        loop {
            let mut raw = Vec::new();
            self.input.by_ref().take(PIECE).read_to_end(&mut raw)?;
            let mut ready = Vec::new();
            for byte in &raw {
                match byte {
                    b' ' | b'\t' => self.due = self.begun,
                    b'\n' | b'\r' => {
                        (self.due, self.begun) = (false, false);
                        ready.push(*byte);
                    }
                    other => {
                        if self.due {
                            ready.push(b' ');
                        }
                        (self.due, self.begun) = (false, true);
                        ready.push(*other);
                    }
                }
            }
            if raw.is_empty() || !ready.is_empty() {
                return Ok(ready);
            }
        }
    }
}

impl<R: Read> Read for Blanks<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.ready.position() == self.ready.get_ref().len() as u64 {
            self.ready = Cursor::new(self.convert()?);
        }
        self.ready.read(buffer)
    }
}

//! The text of a file, whatever its encoding: UTF-8 with or without a byte order mark, UTF-16, and either of them
//! compressed by gzip.

use std::cell::Cell;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::path::Path;
use std::rc::Rc;

use flate2::bufread::MultiGzDecoder;

use super::super::source_file::{self, MAX_BYTES};
use crate::error::{Error, Result};

/// First bytes of a file that is compressed by gzip.
pub(in super::super) const GZIP: &[u8] = b"\x1f\x8b";

/// Bytes at the beginning of a file by which its layout is recognised.
const HEAD: u64 = 1 << 16;

/// A file of text, on disk or in memory.
#[derive(Clone, Copy)]
pub(in super::super) enum Text<'a> {
    /// A file.
    File(&'a Path),
    /// The bytes of a file; its name is for messages.
    Memory(&'a Path, &'a [u8]),
}

/// How much of a file is read.
pub(in super::super) struct Extent {
    /// [bytes] Size of the file.
    pub size: u64,
    /// Bytes of the file that were converted to text, and bytes of that text; `None` where the file holds the text as it is.
    converted: Option<[Rc<Cell<u64>>; 2]>,
}

impl Extent {
    /// [bytes] Part of the file that gave the first `text` bytes of the text.
    pub fn read(&self, text: u64) -> u64 {
        let Some([file, whole]) = &self.converted else { return text };
        // The text is read ahead of the parser.
        (file.get() as f64 * text as f64 / whole.get().max(text).max(1) as f64) as u64
    }
}

/// Counts the bytes that it passes on.
struct Counted<R> {
    input: R,
    passed: Rc<Cell<u64>>,
}

impl<R> Counted<R> {
    fn add(&self, count: usize) {
        self.passed.set(self.passed.get() + count as u64);
    }
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(buffer)?;
        self.add(count);
        Ok(count)
    }
}

impl<R: BufRead> BufRead for Counted<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.input.fill_buf()
    }

    fn consume(&mut self, count: usize) {
        self.add(count);
        self.input.consume(count);
    }
}

impl<'a> Text<'a> {
    /// The file.
    pub(in super::super) fn path(self) -> &'a Path {
        match self {
            Self::File(path) | Self::Memory(path, _) => path,
        }
    }

    /// The text as UTF-8, and how much of the file is read. At most [`MAX_BYTES`] are passed on.
    ///
    /// # Errors
    /// The file cannot be opened.
    pub(in super::super) fn reader(self) -> Result<(Box<dyn Read + 'a>, Extent)> {
        let path = self.path();
        let read = |source| Error::file(path, "read", source);
        let head = self.raw_head()?;
        let (plain, size) = self.raw()?;
        let counts = [0, 0].map(|zero| Rc::new(Cell::new(zero)));
        let [of_file, of_text] = counts.clone();
        let plain = Counted { input: plain, passed: of_file };
        let packed = head.starts_with(GZIP);
        let (head, plain) = if packed {
            let mut unpacked: Box<dyn Read + 'a> = Box::new(MultiGzDecoder::new(plain));
            let mut start = Vec::new();
            unpacked.by_ref().take(HEAD).read_to_end(&mut start).map_err(read)?;
            (start.clone(), Box::new(Cursor::new(start).chain(unpacked)) as Box<dyn Read + 'a>)
        } else {
            (head, Box::new(plain) as Box<dyn Read + 'a>)
        };
        let limited = plain.take(MAX_BYTES);
        let order = utf16_order(&head);
        let text: Box<dyn Read + 'a> = match order {
            Some(little_endian) => Box::new(Utf16::new(limited, little_endian)),
            None => Box::new(limited),
        };
        let converted = (packed || order.is_some()).then_some(counts);
        Ok((Box::new(Counted { input: text, passed: of_text }), Extent { size, converted }))
    }

    /// The first bytes of the text, as UTF-8, and whether they are the complete text.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(in super::super) fn head(self) -> Result<(Vec<u8>, bool)> {
        let mut head = Vec::new();
        let (reader, _) = self.reader()?;
        reader.take(HEAD).read_to_end(&mut head).map_err(|source| Error::file(self.path(), "read", source))?;
        let whole = (head.len() as u64) < HEAD;
        Ok((head, whole))
    }

    fn raw(self) -> Result<(Box<dyn BufRead + 'a>, u64)> {
        Ok(match self {
            Self::File(path) => {
                let (file, size) = source_file::open(path)?;
                (Box::new(BufReader::new(file)), size)
            }
            Self::Memory(_, bytes) => (Box::new(bytes), bytes.len() as u64),
        })
    }

    /// The first bytes of the file.
    ///
    /// # Errors
    /// It is not a regular file, is empty or too large, or cannot be read.
    pub(in super::super) fn raw_head(self) -> Result<Vec<u8>> {
        let mut head = Vec::new();
        let (raw, _) = self.raw()?;
        raw.take(HEAD).read_to_end(&mut head).map_err(|source| Error::file(self.path(), "read", source))?;
        Ok(head)
    }
}

/// Converts UTF-16 to UTF-8.
struct Utf16<R> {
    input: R,
    little_endian: bool,
    /// Bytes of the input that are converted, and how far they are passed on.
    ready: Cursor<Vec<u8>>,
    /// The first half of a character of two units.
    half: Option<u16>,
}

/// Whether a text that begins like this is UTF-16, and then whether the least byte comes first. Without a byte
/// order mark, this is decided by three ASCII letters at the beginning.
fn utf16_order(head: &[u8]) -> Option<bool> {
    match head {
        [0xff, 0xfe, ..] => Some(true),
        [0xfe, 0xff, ..] => Some(false),
        [a, 0, b, 0, c, 0, ..] if ![a, b, c].contains(&&0) => Some(true),
        [0, a, 0, b, 0, c, ..] if ![a, b, c].contains(&&0) => Some(false),
        _ => None,
    }
}

impl<R: Read> Utf16<R> {
    fn new(input: R, little_endian: bool) -> Self {
        Self { input, little_endian, ready: Cursor::default(), half: None }
    }

    /// Converts the next bytes; none at the end of the input.
    fn convert(&mut self) -> io::Result<Vec<u8>> {
        const PIECE: u64 = 1 << 14;
        let mut raw = Vec::new();
        self.input.by_ref().take(PIECE).read_to_end(&mut raw)?;
        let unit = |pair: &[u8]| match *pair {
            [a, b] if self.little_endian => u16::from_le_bytes([a, b]),
            [a, b] => u16::from_be_bytes([a, b]),
            // A lone last byte is half a character.
            _ => 0xfffd,
        };
        let mut units: Vec<u16> = self.half.take().into_iter().chain(raw.chunks(2).map(unit)).collect();
        // A first half at the end of a piece belongs to the next one.
        let first_half = |unit: &mut u16| (0xd800..0xdc00).contains(unit);
        self.half = if raw.len() as u64 == PIECE { units.pop_if(first_half) } else { None };
        let decoded = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        Ok(decoded.collect::<String>().into_bytes())
    }
}

impl<R: Read> Read for Utf16<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.ready.position() == self.ready.get_ref().len() as u64 {
            self.ready = Cursor::new(self.convert()?);
        }
        self.ready.read(buffer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_utf16_of_any_length_becomes_the_same_text() {
        // Characters of one, two, three and four bytes; pieces end within them.
        let text: String = "aµ€𝄞".chars().cycle().take(40_001).collect();
        for little_endian in [true, false] {
            let bytes: Vec<u8> = std::iter::once(0xfeff)
                .chain(text.encode_utf16())
                .flat_map(|unit| if little_endian { unit.to_le_bytes() } else { unit.to_be_bytes() })
                .collect();
            let (mut read, _) = Text::Memory("a.csv".as_ref(), &bytes).reader().expect("a reader");
            let mut out = String::new();
            read.read_to_string(&mut out).expect("text");
            assert!(out.strip_prefix('\u{feff}') == Some(text.as_str()), "another text");
        }
    }
}

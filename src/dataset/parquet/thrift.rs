//! Walks through a structure in Thrift's compact protocol without trusting its lengths.
//!
//! The library reserves memory for as many elements as a list claims to have. Before that, every length is compared
//! here with the remaining bytes; each element takes at least one.
//! Reference: Apache Thrift, "Thrift Compact protocol".

/// Deepest nesting; Parquet's own structures have eight levels.
const MAX_DEPTH: usize = 24;

/// What is found on a walk, with the ids of the fields that lead to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Event {
    /// An element of a list of structures begins.
    Element,
    /// A whole number.
    Number(i64),
}

/// Types of fields and elements.
mod kind {
    pub(super) const TRUE: u8 = 1;
    pub(super) const FALSE: u8 = 2;
    pub(super) const BYTE: u8 = 3;
    pub(super) const I16: u8 = 4;
    pub(super) const I32: u8 = 5;
    pub(super) const I64: u8 = 6;
    pub(super) const DOUBLE: u8 = 7;
    pub(super) const BINARY: u8 = 8;
    pub(super) const LIST: u8 = 9;
    pub(super) const SET: u8 = 10;
    pub(super) const STRUCT: u8 = 12;
}

/// Walks a structure at the beginning of `bytes`; returns its length, or `None` if it is invalid.
pub(super) fn walk(bytes: &[u8], visit: &mut dyn FnMut(&[i16], Event)) -> Option<usize> {
    let mut walk = Walk { bytes, at: 0, path: Vec::new(), visit };
    walk.structure()?;
    Some(walk.at)
}

struct Walk<'a> {
    bytes: &'a [u8],
    at: usize,
    path: Vec<i16>,
    visit: &'a mut dyn FnMut(&[i16], Event),
}

impl Walk<'_> {
    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Some(value);
            }
        }
        None
    }

    fn zigzag(&mut self) -> Option<i64> {
        let value = self.varint()?;
        Some((value >> 1).cast_signed() ^ -((value & 1).cast_signed()))
    }

    fn skip(&mut self, count: u64) -> Option<()> {
        self.at = self.at.checked_add(usize::try_from(count).ok()?).filter(|&at| at <= self.bytes.len())?;
        Some(())
    }

    fn structure(&mut self) -> Option<()> {
        if self.path.len() >= MAX_DEPTH {
            return None;
        }
        let mut id = 0_i16;
        loop {
            let head = self.byte()?;
            let (delta, kind) = (head >> 4, head & 0xf);
            if kind == 0 {
                return Some(());
            }
            id = if delta == 0 { i16::try_from(self.zigzag()?).ok()? } else { id.checked_add(i16::from(delta))? };
            self.path.push(id);
            if kind != kind::TRUE && kind != kind::FALSE {
                self.value(kind)?;
            }
            self.path.pop();
        }
    }

    fn value(&mut self, kind: u8) -> Option<()> {
        match kind {
            kind::TRUE | kind::FALSE | kind::BYTE => self.skip(1),
            kind::I16 | kind::I32 | kind::I64 => {
                let number = self.zigzag()?;
                (self.visit)(&self.path, Event::Number(number));
                Some(())
            }
            kind::DOUBLE => self.skip(8),
            kind::BINARY => {
                let length = self.varint()?;
                self.skip(length)
            }
            kind::LIST | kind::SET => self.list(),
            kind::STRUCT => self.structure(),
            _ => None,
        }
    }

    fn list(&mut self) -> Option<()> {
        if self.path.len() >= MAX_DEPTH {
            return None;
        }
        let head = self.byte()?;
        let count = if head >> 4 == 0xf { self.varint()? } else { u64::from(head >> 4) };
        if count > (self.bytes.len() - self.at) as u64 {
            return None;
        }
        for _ in 0..count {
            if head & 0xf == kind::STRUCT {
                (self.visit)(&self.path, Event::Element);
            }
            // One level deeper, so that nested lists are bounded too.
            let depth = self.path.len();
            if head & 0xf == kind::LIST {
                self.path.push(0);
            }
            self.value(head & 0xf)?;
            self.path.truncate(depth);
        }
        Some(())
    }
}

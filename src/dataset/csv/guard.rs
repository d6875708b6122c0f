//! Protects the parser of comma-separated values from unsuitable files: binary data, and rows without end.

use std::io::{Error, ErrorKind, Read, Result};

/// Longest row [bytes]: [`MAX_COLUMNS`](crate::dataset) numbers of twenty characters are 2 MB; cells of text may be longer.
pub(super) const MAX_RECORD: usize = 16 << 20;

/// Longest byte order mark.
const MARK: usize = 3;

/// Why the parser gets no more bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fault {
    /// A byte of zero, and its line.
    Nul(usize),
    /// A row is longer than allowed.
    Long,
    /// The operating system refuses.
    Read(ErrorKind),
}

/// Passes bytes on as long as the text is acceptable.
#[derive(Debug)]
pub(super) struct Guard<R> {
    input: R,
    /// Bytes read ahead in search of a byte order mark, and how many of them have been passed on.
    head: Vec<u8>,
    given: usize,
    /// The last byte that was passed on.
    last: u8,
    /// Bytes that may still be read for this row.
    left: usize,
    line: usize,
    /// Reason for the end of reading.
    pub(super) fault: Option<Fault>,
}

impl<R: Read> Guard<R> {
    /// Examines the first bytes.
    ///
    /// # Errors
    /// They cannot be read.
    pub(super) fn new(mut input: R) -> std::result::Result<Self, Fault> {
        let mut head = Vec::new();
        input.by_ref().take(MARK as u64).read_to_end(&mut head).map_err(|error| Fault::Read(error.kind()))?;
        let given = if head == b"\xef\xbb\xbf" { MARK } else { 0 };
        Ok(Self { input, head, given, last: 0, left: usize::MAX, line: 1, fault: None })
    }

    /// Allows the parser to read that many bytes before it asks again.
    pub(super) fn allow(&mut self, bytes: usize) {
        self.left = bytes;
    }

    /// Whether the last byte that was passed on ends a line.
    pub(super) fn ends_a_line(&self) -> bool {
        matches!(self.last, b'\n' | b'\r')
    }

    fn refuse(&mut self, fault: Fault) -> Error {
        self.fault = Some(fault);
        Error::from(ErrorKind::InvalidData)
    }
}

impl<R: Read> Read for Guard<R> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        if self.left == 0 && !buffer.is_empty() {
            return Err(self.refuse(Fault::Long));
        }
        let most = buffer.len().min(self.left);
        let count = match self.head.get(self.given..).filter(|rest| !rest.is_empty()) {
            Some(mut rest) => rest.read(&mut buffer[..most]).inspect(|count| self.given += count)?,
            None => self.input.read(&mut buffer[..most])?,
        };
        self.left -= count;
        let read = &buffer[..count];
        let lines = |bytes: &[u8]| bytes.iter().filter(|&&byte| byte == b'\n').count();
        if let Some(at) = read.iter().position(|&byte| byte == 0) {
            let line = self.line + lines(&read[..at]);
            return Err(self.refuse(Fault::Nul(line)));
        }
        self.line += lines(read);
        self.last = read.last().copied().unwrap_or(self.last);
        Ok(count)
    }
}

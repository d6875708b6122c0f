//! Checksums of files: SHA-256 while a file is written, and of a file on disk.

use std::fs::File;
use std::path::Path;
use std::{fmt::Write as _, io};

use sha2::{Digest as _, Sha256};

/// Passes on written bytes, and computes their checksum.
#[derive(Debug)]
pub struct Summed<W> {
    out: W,
    digest: Sha256,
}

impl<W> Summed<W> {
    /// Starts without any bytes.
    pub fn new(out: W) -> Self {
        Self { out, digest: Sha256::new() }
    }

    /// The inner writer, and the SHA-256 of everything that was written.
    pub fn finish(self) -> (W, String) {
        (self.out, hexadecimal(self.digest.finalize().as_slice()))
    }
}

impl<W: io::Write> io::Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.digest.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// SHA-256 of the content of a file, in hexadecimal digits.
///
/// # Errors
/// The file cannot be read.
pub fn sha256_of(file: &Path) -> io::Result<String> {
    let mut sum = Summed::new(io::sink());
    io::copy(&mut File::open(file)?, &mut sum)?;
    Ok(sum.finish().1)
}

fn hexadecimal(digest: &[u8]) -> String {
    let mut text = String::new();
    for byte in digest {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
    }
    text
}

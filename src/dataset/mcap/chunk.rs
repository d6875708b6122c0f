//! A chunk of an MCAP file: many records, compressed together.
//!
//! ```text
//!   first and last time u64, uncompressed size u64, its CRC-32 u32 (0: none), compression: string, compressed size u64, records
//! ```

use std::io::{Error, ErrorKind, Read, Result};

use flate2::Crc;
use lz4_flex::frame::FrameDecoder;
use zstd::stream::read::Decoder;

/// Largest record, and largest chunk when decompressed [bytes]. Writers cut chunks at 1 to 8 MB.
pub(super) const MAX_RECORD: u64 = 256 << 20;

/// Longest name of a compression.
const MAX_NAME: u32 = 32;

/// The header of a chunk.
pub(super) struct Chunk {
    /// Length of the records when decompressed [bytes].
    pub(super) size: u64,
    crc: u32,
    compression: Vec<u8>,
    compressed: u64,
}

impl Chunk {
    /// Reads the header.
    ///
    /// # Errors
    /// It is cut off.
    pub(super) fn read(input: &mut impl Read) -> Result<Self> {
        let mut times = [0; 16];
        input.read_exact(&mut times)?;
        let size = u64::from_le_bytes(number(input)?);
        let crc = u32::from_le_bytes(number(input)?);
        let length = u32::from_le_bytes(number(input)?);
        if length > MAX_NAME {
            return Err(ErrorKind::InvalidData.into());
        }
        let mut compression = vec![0; length as usize];
        input.read_exact(&mut compression)?;
        Ok(Self { size, crc, compression, compressed: u64::from_le_bytes(number(input)?) })
    }

    /// Puts the records into `body`.
    ///
    /// # Errors
    /// They are cut off, of an unknown compression, of another size than stated, or damaged.
    pub(super) fn inflate(&self, input: &mut impl Read, body: &mut Vec<u8>) -> Result<()> {
        body.clear();
        let packed = input.take(self.compressed);
        match self.compression.as_slice() {
            b"" => packed.take(self.size).read_to_end(body)?,
            b"zstd" => Decoder::new(packed)?.take(self.size).read_to_end(body)?,
            b"lz4" => FrameDecoder::new(packed).take(self.size).read_to_end(body)?,
            _ => return Err(Error::from(ErrorKind::Unsupported)),
        };
        if (body.len() as u64) < self.size {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        let mut crc = Crc::new();
        crc.update(body);
        if self.crc != 0 && self.crc != crc.sum() { Err(ErrorKind::InvalidData.into()) } else { Ok(()) }
    }
}

fn number<const N: usize>(input: &mut impl Read) -> Result<[u8; N]> {
    let mut bytes = [0; N];
    input.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Passes the records of a chunk to `take`; `Err(())` if one does not lie within the chunk.
pub(super) fn records<E>(
    mut bytes: &[u8],
    mut take: impl FnMut(u8, &[u8]) -> std::result::Result<(), E>,
) -> std::result::Result<std::result::Result<(), E>, ()> {
    while let Some((&opcode, rest)) = bytes.split_first() {
        let (length, rest) = rest.split_first_chunk::<8>().ok_or(())?;
        let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| ())?;
        let (record, rest) = rest.split_at_checked(length).ok_or(())?;
        if let Err(error) = take(opcode, record) {
            return Ok(Err(error));
        }
        bytes = rest;
    }
    Ok(Ok(()))
}

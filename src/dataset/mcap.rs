//! MCAP recordings of ROS robots: the messages `sensor_msgs/JointState` become `<joint>.position`, `.velocity`,
//! `.effort`.
//!
//! Two encodings are read: that of ROS 1 and the CDR of ROS 2. Time is that of the message headers, starting at the
//! first message.
//! Left out: other messages; topics whose set of joints changes.
//!
//! ```text
//!   magic, records, magic; a record is an opcode u8, a length u64 and that many bytes
//! ```
//! The records are read here and not by the crate `mcap`, because its reader does not terminate if a chunk decompresses
//! to fewer bytes than its header states. Every length is compared with the available bytes before memory is allocated.
//! Reference: the MCAP format, version 0.

mod channels;
mod chunk;

use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use self::channels::Channels;
use self::chunk::{Chunk, MAX_RECORD};
use super::source_file::{self, MAX_BYTES};
use super::table::Table;
use crate::error::{Error, Place, Result};

/// The magic bytes at both ends of a file.
const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
/// Length of opcode and length before a record [bytes].
const HEAD: u64 = 9;

/// Opcodes of the records that are read.
mod opcode {
    pub(super) const SCHEMA: u8 = 3;
    pub(super) const CHANNEL: u8 = 4;
    pub(super) const MESSAGE: u8 = 5;
    pub(super) const CHUNK: u8 = 6;
}

/// Largest total size of the decompressed chunks of a file [bytes]: other content, above all pictures, is decompressed
/// and skipped.
const MAX_INFLATED: u64 = 2 * MAX_BYTES;

/// Reads the joint states of the topic with the most messages.
///
/// # Errors
/// The file cannot be read or is cut off; it has no joint states, or ones whose joints change.
pub(super) fn read(path: &Path) -> Result<Table> {
    let (file, size) = source_file::open(path)?;
    decode(path, io::BufReader::new(file), size)
}

/// As [`read`], from memory.
///
/// # Errors
/// As [`read`].
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Table> {
    decode(path, io::Cursor::new(bytes), bytes.len() as u64)
}

fn decode(path: &Path, mut input: impl Read + Seek, size: u64) -> Result<Table> {
    let mut magic = [0; MAGIC.len()];
    if input.read_exact(&mut magic).is_err() || magic != MAGIC {
        return Err(Error::input(path, Place::File, "format", "", "an MCAP file"));
    }
    // One pass for the sizes, before anything is decompressed, and one for the content.
    let mut inflated = 0;
    each_record(path, &mut input, size, |at, opcode, _, record| {
        if opcode == opcode::CHUNK {
            let chunk = Chunk::read(record).map_err(|error| damaged(path, at, &error))?;
            inflated = chunk.size.saturating_add(inflated);
            if chunk.size > MAX_RECORD || inflated > MAX_INFLATED {
                return Err(too_large(path, at, chunk.size, inflated));
            }
        }
        Ok(())
    })?;
    let mut channels = Channels::new(path);
    let mut body = Vec::new();
    each_record(path, &mut input, size, |at, opcode, length, record| {
        let unreadable = |error: &io::Error| damaged(path, at, error);
        match opcode {
            opcode::SCHEMA | opcode::CHANNEL | opcode::MESSAGE if length <= MAX_RECORD => {
                body.clear();
                record.read_to_end(&mut body).map_err(|error| unreadable(&error))?;
                channels.take(opcode, &body)
            }
            opcode::CHUNK => {
                let chunk = Chunk::read(record).map_err(|error| unreadable(&error))?;
                chunk.inflate(record, &mut body).map_err(|error| unreadable(&error))?;
                chunk::records(&body, |opcode, record| channels.take(opcode, record))
                    .unwrap_or_else(|()| Err(unreadable(&io::ErrorKind::InvalidData.into())))
            }
            _ => Ok(()),
        }
    })?;
    channels.table()
}

/// Hands place, opcode, length and content of every record to `take`.
///
/// # Errors
/// A record does not lie within the file, the file does not end with its magic bytes, or `take` fails.
fn each_record<R: Read + Seek>(
    path: &Path,
    input: &mut R,
    size: u64,
    mut take: impl FnMut(u64, u8, u64, &mut io::Take<&mut R>) -> Result<()>,
) -> Result<()> {
    let unreadable = |at: u64, error: &io::Error| damaged(path, at, error);
    let mut at = MAGIC.len() as u64;
    input.seek(SeekFrom::Start(at)).map_err(|error| unreadable(at, &error))?;
    while at + HEAD <= size {
        let (opcode, length) = head(input).map_err(|error| unreadable(at, &error))?;
        // The second magic of the file cannot be part of a record.
        if length > size.saturating_sub(at + HEAD + MAGIC.len() as u64) {
            return Err(unreadable(at, &io::ErrorKind::UnexpectedEof.into()));
        }
        let mut record = input.by_ref().take(length);
        take(at, opcode, length, &mut record)?;
        let rest = record.limit().cast_signed();
        input.seek_relative(rest).map_err(|error| unreadable(at, &error))?;
        at += HEAD + length;
    }
    let mut magic = [0; MAGIC.len()];
    if input.read_exact(&mut magic).is_err() || magic != MAGIC {
        return Err(unreadable(at, &io::ErrorKind::UnexpectedEof.into()));
    }
    Ok(())
}

fn damaged(path: &Path, at: u64, source: &io::Error) -> Error {
    let value = if source.kind() == io::ErrorKind::UnexpectedEof { "cut off" } else { "damaged" };
    Error::input(path, Place::File, format!("record at byte {at}"), value, "a whole MCAP file")
}

fn head(input: &mut impl Read) -> io::Result<(u8, u64)> {
    let mut head = [0; HEAD as usize];
    input.read_exact(&mut head)?;
    let [opcode, length @ ..] = head;
    Ok((opcode, u64::from_le_bytes(length)))
}

fn too_large(path: &Path, at: u64, size: u64, inflated: u64) -> Error {
    let (value, expected) = if size > MAX_RECORD {
        (size, format!("a chunk of at most {}", source_file::shown(MAX_RECORD)))
    } else {
        (
            inflated,
            format!("at most {} in all chunks: filter the topic of joint states out", source_file::shown(MAX_INFLATED)),
        )
    };
    let key = format!("uncompressed size, chunk at byte {at}");
    Error::input(path, Place::File, key, source_file::shown(value), expected)
}

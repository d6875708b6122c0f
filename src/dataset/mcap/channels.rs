//! The channels of an MCAP file with joint states.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use super::super::ros::{Reader, Topics, Wire, is_joint_state};
use super::super::table::Table;
use super::opcode;
use crate::error::Result;

/// Length of the header of a message: channel, number, two times [bytes].
const MESSAGE_HEAD: usize = 2 + 4 + 8 + 8;

/// State of reading.
pub(super) struct Channels<'a> {
    /// Ids of the schemas of joint states.
    schemas: HashSet<u16>,
    /// Index in `topics`, and the encoding of its messages, by the id of a channel.
    channels: HashMap<u16, (usize, Wire)>,
    topics: Topics<'a>,
}

impl<'a> Channels<'a> {
    /// The state before the first record.
    pub(super) fn new(path: &'a Path) -> Self {
        Self { schemas: HashSet::new(), channels: HashMap::new(), topics: Topics::new(path) }
    }

    /// Processes a record. Records that are not joint states, or are incomplete, are skipped.
    ///
    /// # Errors
    /// There are too many numbers.
    pub(super) fn take(&mut self, opcode: u8, record: &[u8]) -> Result<()> {
        match opcode {
            opcode::SCHEMA => {
                self.schema(record);
            }
            opcode::CHANNEL => {
                self.channel(record);
            }
            opcode::MESSAGE => return self.message(record),
            _ => {}
        }
        Ok(())
    }

    fn schema(&mut self, record: &[u8]) -> Option<()> {
        let mut reader = Reader::packed(record);
        let (id, name) = (reader.u16()?, reader.string()?);
        if is_joint_state(&name) {
            self.schemas.insert(id);
        }
        Some(())
    }

    fn channel(&mut self, record: &[u8]) -> Option<()> {
        let mut reader = Reader::packed(record);
        let (id, schema) = (reader.u16()?, reader.u16()?);
        if !self.schemas.contains(&schema) || self.channels.contains_key(&id) {
            return None;
        }
        let (name, encoding) = (reader.string()?, reader.string()?);
        self.channels.insert(id, (self.topics.place(name), Wire::of_encoding(&encoding)));
        Some(())
    }

    fn message(&mut self, record: &[u8]) -> Result<()> {
        let Some((head, content)) = record.split_at_checked(MESSAGE_HEAD) else { return Ok(()) };
        let Some((place, wire)) = self.channels.get(&u16::from_le_bytes([head[0], head[1]])) else { return Ok(()) };
        self.topics.take(*place, wire, content)
    }

    /// The topic with the most messages.
    ///
    /// # Errors
    /// There is none, or one of its messages cannot be used.
    pub(super) fn table(self) -> Result<Table> {
        self.topics.table()
    }
}

//! The joint states of an MCAP file, topic by topic.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use super::super::Note;
use super::super::table::{Column, Table, check_cells, list};
use super::joint_state::{JointState, Reader, Wire};
use super::opcode;
use crate::error::{Error, Place, Result};

/// Names of the message in ROS 1 and ROS 2.
const SCHEMAS: [&str; 2] = ["sensor_msgs/JointState", "sensor_msgs/msg/JointState"];

/// Length of the header of a message: channel, number, two times [bytes].
const MESSAGE_HEAD: usize = 2 + 4 + 8 + 8;

/// State of reading.
pub(super) struct Topics<'a> {
    path: &'a Path,
    /// Ids of the schemas of joint states.
    schemas: HashSet<u16>,
    /// Index in `topics`, and the encoding of its messages, by the id of a channel.
    channels: HashMap<u16, (usize, Option<Wire>)>,
    topics: Vec<Topic>,
    /// Index in `topics` by name.
    places: HashMap<String, usize>,
    cells: u64,
}

/// The messages of one topic.
struct Topic {
    name: String,
    /// The first message.
    first: Option<JointState>,
    /// One column for the time, and one for each of the three quantities of each joint of the first message.
    columns: Vec<Column>,
    /// The first message that cannot be used: its row, what it is, what was expected.
    fault: Option<(usize, String, String)>,
}

impl<'a> Topics<'a> {
    /// The state before the first record.
    pub(super) fn new(path: &'a Path) -> Self {
        Self {
            path,
            schemas: HashSet::new(),
            channels: HashMap::new(),
            topics: Vec::new(),
            places: HashMap::new(),
            cells: 0,
        }
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
        if SCHEMAS.contains(&name.as_str()) {
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
        let place = *self.places.entry(name.clone()).or_insert_with(|| {
            self.topics.push(Topic { name, first: None, columns: Vec::new(), fault: None });
            self.topics.len() - 1
        });
        self.channels.insert(id, (place, Wire::of_encoding(&encoding)));
        Some(())
    }

    fn message(&mut self, record: &[u8]) -> Result<()> {
        let Some((head, content)) = record.split_at_checked(MESSAGE_HEAD) else { return Ok(()) };
        let Some(&(place, wire)) = self.channels.get(&u16::from_le_bytes([head[0], head[1]])) else { return Ok(()) };
        let topic = &mut self.topics[place];
        let added = topic.add(wire.and_then(|wire| wire.joint_state(content)));
        self.cells += added as u64;
        check_cells(self.path, self.cells, 1)
    }

    /// The topic with the most messages.
    ///
    /// # Errors
    /// There is none, or one of its messages cannot be used.
    pub(super) fn table(mut self) -> Result<Table> {
        self.topics.retain(|topic| topic.first.is_some() || topic.fault.is_some());
        let Some(chosen) = (0..self.topics.len()).rev().max_by_key(|&place| self.topics[place].rows()) else {
            let expected = "messages of type sensor_msgs/JointState";
            return Err(Error::input(self.path, Place::File, "messages", "", expected));
        };
        let topic = self.topics.swap_remove(chosen);
        if let Some((row, value, expected)) = topic.fault {
            return Err(Error::input(self.path, Place::Row(row), topic.name, value, expected));
        }
        let mut notes = Vec::new();
        if !self.topics.is_empty() {
            let others: Vec<&str> = self.topics.iter().map(|other| other.name.as_str()).collect();
            let text = format!("joint states of {} taken, those of {} left out", topic.name, list(&others));
            notes.push(Note { file: self.path.to_owned(), place: Place::File, column: String::new(), text });
        }
        Table::new(self.path, Place::File, topic.columns, notes)
    }
}

impl Topic {
    fn rows(&self) -> usize {
        self.columns.first().map_or(0, |time| time.values.len())
    }

    /// Adds a message; returns its count of numbers.
    fn add(&mut self, state: Option<JointState>) -> usize {
        if self.fault.is_some() {
            return 0;
        }
        let row = self.rows() + 1;
        let Some(state) = state else {
            self.fault = Some((row, String::new(), "a readable sensor_msgs/JointState".into()));
            return 0;
        };
        let first = self.first.get_or_insert_with(|| {
            let names = state.quantities().map(|(name, quantity)| Column::new(format!("{name}.{quantity}")));
            let time = Column { seconds: Some(1.0), ..Column::new("time") };
            self.columns = std::iter::once(time).chain(names).collect();
            state.clone()
        });
        if !state.has_the_joints_of(first) {
            let names = |state: &JointState| list(&state.names.iter().map(String::as_str).collect::<Vec<_>>());
            self.fault = Some((row, names(&state), format!("the joints of the first message: {}", names(first))));
            return 0;
        }
        let (seconds, nanoseconds) = state.stamp;
        let since = (seconds - first.stamp.0) as f64 + (f64::from(nanoseconds) - f64::from(first.stamp.1)) * 1e-9;
        for (column, value) in self.columns.iter_mut().zip(std::iter::once(since).chain(state.values())) {
            column.values.push(value);
        }
        self.columns.len()
    }
}

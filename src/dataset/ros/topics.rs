//! The joint states of a recording, topic by topic. The topic with the most messages becomes the table.

use std::collections::HashMap;
use std::path::Path;

use super::super::Note;
use super::super::table::{Column, Table, check_cells, list};
use super::joint_state::{JointState, Wire};
use crate::error::{Error, Place, Result};

/// Names of the message in ROS 1 and ROS 2.
const NAMES: [&str; 2] = ["sensor_msgs/JointState", "sensor_msgs/msg/JointState"];

/// First bytes of a message that rosbag2 has compressed by Zstandard. CDR begins with a zero, ROS 1 with a counter that
/// would take years to this number.
const COMPRESSED: &[u8] = b"\x28\xb5\x2f\xfd";

/// Whether a type of messages is that of joint states.
pub(crate) fn is_joint_state(name: &str) -> bool {
    NAMES.contains(&name)
}

/// State of reading.
pub(crate) struct Topics<'a> {
    path: &'a Path,
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
    /// The state before the first message.
    pub(crate) fn new(path: &'a Path) -> Self {
        Self { path, topics: Vec::new(), places: HashMap::new(), cells: 0 }
    }

    /// Index of a topic of joint states, by its name.
    pub(crate) fn place(&mut self, name: String) -> usize {
        *self.places.entry(name.clone()).or_insert_with(|| {
            self.topics.push(Topic { name, first: None, columns: Vec::new(), fault: None });
            self.topics.len() - 1
        })
    }

    /// Takes the next message of a topic.
    ///
    /// # Errors
    /// There are too many numbers.
    pub(crate) fn take(&mut self, place: usize, wire: &Wire, content: &[u8]) -> Result<()> {
        self.cells += self.topics[place].add(wire, content) as u64;
        check_cells(self.path, self.cells, 1)
    }

    /// The topic with the most messages.
    ///
    /// # Errors
    /// There is none, or one of its messages cannot be used.
    pub(crate) fn table(mut self) -> Result<Table> {
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
    fn add(&mut self, wire: &Wire, content: &[u8]) -> usize {
        if self.fault.is_some() {
            return 0;
        }
        let row = self.rows() + 1;
        let Some(state) = wire.joint_state(content) else {
            let (value, expected) = unreadable(wire, content);
            self.fault = Some((row, value, expected));
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

/// What a message is that cannot be read, and what was expected.
fn unreadable(wire: &Wire, content: &[u8]) -> (String, String) {
    let readable = "a readable sensor_msgs/JointState";
    match wire {
        Wire::Other(encoding) => (encoding.clone(), format!("{readable}, encoded as cdr or ros1")),
        _ if content.starts_with(COMPRESSED) => (
            "a message compressed by zstd".to_owned(),
            format!(
                "{readable}: `ros2 bag convert -i FOLDER -o convert.yaml` with the folder of the bag, where convert.yaml holds \
                 `output_bags: [{{uri: plain, all_topics: true}}]`"
            ),
        ),
        _ => (String::new(), readable.to_owned()),
    }
}

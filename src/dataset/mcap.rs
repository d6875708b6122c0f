//! MCAP recordings of robots that speak ROS: the messages `sensor_msgs/JointState` become `<joint>.position`, `.velocity`, `.effort`.
//!
//! Both encodings are read, that of ROS 1 and the CDR of ROS 2. Time is that of the message headers, from the first message on.
//! Left out: other messages; joints that come and go between messages of one topic.

use std::path::Path;

use mcap::MessageStream;

use super::Note;
use super::joint_state::{JointState, Wire};
use super::table::{Column, Table};
use crate::error::{Error, Place, Result};

/// Names of the message in ROS 1 and ROS 2.
const SCHEMAS: [&str; 2] = ["sensor_msgs/JointState", "sensor_msgs/msg/JointState"];

/// Reads the joint states of the topic that has most of them.
///
/// # Errors
/// The file cannot be read or is cut off; it has no joint states, or ones whose joints change.
pub(super) fn read(path: &Path) -> Result<Table> {
    let bytes = std::fs::read(path).map_err(|source| Error::file(path, "read", source))?;
    check_records(path, &bytes)?;
    let unreadable = |error: mcap::McapError| Error::input(path, Place::File, "mcap", error, "a whole MCAP file");
    let mut topics: Vec<(String, Vec<JointState>)> = Vec::new();
    for message in MessageStream::new(&bytes).map_err(unreadable)? {
        let message = message.map_err(unreadable)?;
        let channel = &message.channel;
        if !channel.schema.as_ref().is_some_and(|schema| SCHEMAS.contains(&schema.name.as_str())) {
            continue;
        }
        let index = topics.iter().position(|topic| topic.0 == channel.topic).unwrap_or_else(|| {
            topics.push((channel.topic.clone(), Vec::new()));
            topics.len() - 1
        });
        let row = topics[index].1.len() + 1;
        let state = Wire::of_encoding(&channel.message_encoding).and_then(|wire| wire.joint_state(&message.data));
        let refuse = || Error::input(path, Place::Row(row), &channel.topic, "", "a readable sensor_msgs/JointState");
        topics[index].1.push(state.ok_or_else(refuse)?);
    }
    let Some(chosen) = (0..topics.len()).rev().max_by_key(|&index| topics[index].1.len()) else {
        return Err(Error::input(path, Place::File, "messages", "", "messages of type sensor_msgs/JointState"));
    };
    let (topic, states) = topics.swap_remove(chosen);
    let mut notes = Vec::new();
    if !topics.is_empty() {
        let others: Vec<&str> = topics.iter().map(|other| other.0.as_str()).collect();
        let text = format!("joint states of {topic} taken, those of {} left out", others.join(", "));
        notes.push(Note { file: path.to_owned(), place: Place::File, column: String::new(), text });
    }
    Ok(Table { file: path.to_owned(), columns: columns(path, &topic, &states)?, notes })
}

/// Walks the records, each an opcode, a length and that many bytes: all must lie within the file.
fn check_records(path: &Path, bytes: &[u8]) -> Result<()> {
    /// Length of the magic at both ends, and of opcode and length before a record [bytes].
    const MAGIC: usize = 8;
    const HEAD: usize = 9;
    let mut at = MAGIC;
    while at + MAGIC < bytes.len() {
        let length = bytes.get(at + 1..at + HEAD).and_then(|word| <[u8; 8]>::try_from(word).ok());
        let length = length.and_then(|word| usize::try_from(u64::from_le_bytes(word)).ok());
        let end = length.and_then(|length| at.checked_add(HEAD)?.checked_add(length));
        match end {
            Some(end) if end <= bytes.len() => at = end,
            _ => {
                return Err(Error::input(
                    path,
                    Place::File,
                    format!("record at byte {at}"),
                    "cut off",
                    "a whole MCAP file",
                ));
            }
        }
    }
    Ok(())
}

/// One column for the time, and one for each of the three quantities of each joint that the first message has.
fn columns(path: &Path, topic: &str, states: &[JointState]) -> Result<Vec<Column>> {
    let column = |name: String| Column { name, values: Vec::with_capacity(states.len()), fault: None };
    let first = &states[0];
    let mut columns = vec![column("time".into())];
    for (name, quantity) in first.quantities() {
        columns.push(column(format!("{name}.{quantity}")));
    }
    for (row, state) in states.iter().enumerate() {
        if !state.has_the_joints_of(first) {
            let expected = format!("the joints of the first message: {}", first.names.join(", "));
            return Err(Error::input(path, Place::Row(row + 1), topic, state.names.join(", "), expected));
        }
        let (seconds, nanoseconds) = state.stamp;
        let since = (seconds - first.stamp.0) as f64 + (f64::from(nanoseconds) - f64::from(first.stamp.1)) * 1e-9;
        for (column, value) in columns.iter_mut().zip(std::iter::once(since).chain(state.values())) {
            column.values.push(value);
        }
    }
    Ok(columns)
}

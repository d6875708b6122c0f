//! Bags of ROS 2 in SQLite.

use std::path::Path;

use rusqlite::{Connection, params};

use super::recordings::positions;

/// Name of the message in ROS 2.
pub const JOINT_STATE: &str = "sensor_msgs/msg/JointState";

/// The tables of a bag.
pub const TABLES: &str = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
        serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
    CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
    CREATE INDEX timestamp_idx ON messages (timestamp ASC);";

/// A message in CDR, least byte first.
pub fn message(row: usize, names: &[&str], lists: [&[f64]; 3]) -> Vec<u8> {
    // The first four bytes give the byte order; alignment counts behind them.
    let mut bytes: Vec<u8> = vec![0, 1, 0, 0];
    let number = |bytes: &mut Vec<u8>, value: u32| {
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        bytes.extend(value.to_le_bytes());
    };
    let text = |bytes: &mut Vec<u8>, text: &str| {
        number(bytes, text.len() as u32 + 1);
        bytes.extend(text.as_bytes());
        bytes.push(0);
    };
    number(&mut bytes, 1_700_000_000);
    number(&mut bytes, row as u32 * 1_000_000);
    text(&mut bytes, "base");
    number(&mut bytes, names.len() as u32);
    names.iter().for_each(|name| text(&mut bytes, name));
    for list in lists {
        number(&mut bytes, list.len() as u32);
        if !list.is_empty() {
            bytes.resize((bytes.len() - 4).next_multiple_of(8) + 4, 0);
        }
        bytes.extend(list.iter().flat_map(|value| value.to_le_bytes()));
    }
    bytes
}

/// Of the turntable.
pub fn messages() -> Vec<Vec<u8>> {
    let message = |(row, position): (usize, &f64)| message(row, &["turn"], [&[*position], &[], &[-position]]);
    positions().iter().enumerate().map(message).collect()
}

/// Adds a topic and its messages to a bag.
pub fn add(base: &Connection, name: &str, kind: &str, format: &str, messages: &[Vec<u8>]) {
    base.execute("INSERT INTO topics VALUES (NULL, ?1, ?2, ?3, '')", params![name, kind, format]).expect("a topic");
    let id = base.last_insert_rowid();
    for (row, data) in messages.iter().enumerate() {
        let values = params![id, row as i64 * 1_000_000, data];
        base.execute("INSERT INTO messages VALUES (NULL, ?1, ?2, ?3)", values).expect("a message");
    }
}

/// The bytes of a database with pages of so many bytes that `fill` fills.
pub fn written(page: u32, fill: impl FnOnce(&Connection)) -> Vec<u8> {
    let mut base = Connection::open_in_memory().expect("a database");
    base.pragma_update(None, "page_size", page).expect("a size");
    fill(&base);
    base.serialize("main").expect("its bytes").to_vec()
}

/// A bag with one topic.
pub fn bag(kind: &str, format: &str, messages: &[Vec<u8>]) -> Vec<u8> {
    written(4096, |base| {
        base.execute_batch(TABLES).expect("tables");
        add(base, "/joint_states", kind, format, messages);
    })
}

/// A good file with pages of so many bytes.
pub fn good(page: u32) -> Vec<u8> {
    written(page, |base| {
        base.execute_batch(TABLES).expect("tables");
        add(base, "/joint_states", JOINT_STATE, "cdr", &messages());
        add(base, "/rosout", "rcl_interfaces/msg/Log", "cdr", &[vec![0; 3 * page as usize]]);
    })
}

/// A database on disk, opened for writing.
pub fn on_disk(path: &Path) -> Connection {
    let base = Connection::open(path).expect("a database");
    base.execute_batch(TABLES).expect("tables");
    base
}

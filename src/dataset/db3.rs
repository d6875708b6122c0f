//! Bags of ROS 2 in SQLite (`.db3`): the messages `sensor_msgs/msg/JointState` become `<joint>.position`, `.velocity`,
//! `.effort`, as those of an MCAP file do.
//!
//! ```text
//!   topics(id, name, type, serialization_format, …)   messages(id, topic_id, timestamp, data)
//! ```
//! The database is opened read-only and as one that nobody changes, so that SQLite neither locks it nor creates a file
//! beside it. What a recorder has not yet written into the database itself, a write-ahead log or a journal, is therefore
//! not seen: a bag with one of these beside it is refused.
//! Only the two tables are read. Views and computed columns of these names could run for any time, and do not count.
//! Reference: rosbag2_storage_sqlite3, schema versions 1 to 4.

use std::collections::HashMap;
use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use rusqlite::{Connection, Error as Sqlite, ErrorCode, OpenFlags};

use super::format::way_for;
use super::ros::{Topics, Wire, is_joint_state};
use super::source_file;
use super::table::{Table, list};
use crate::error::{Error, Place, Result};

/// The columns that are read of each table.
const TABLES: [(&str, &[&str]); 2] =
    [("topics", &["id", "name", "type", "serialization_format"]), ("messages", &["topic_id", "data"])];

/// Longest message of joint states [bytes]: 10,000 joints take 1 MB.
const LONGEST: u64 = 16 << 20;

/// Instructions of SQLite between two counts of them.
const COUNTED: u32 = 10_000;
/// Instructions that reading may take per byte of the file. A message is longer than 20 bytes and takes 10 of them; more mean pages that
/// refer to each other in a circle.
const PER_BYTE: u64 = 100;

/// Length of the header of a write-ahead log [bytes]; a log of that length is empty.
const EMPTY_LOG: u64 = 32;
/// First bytes of a journal that has to be rolled back.
const JOURNAL: &[u8] = b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7";
/// Places in the header of a database of the versions for writing and reading; both are 2 with a write-ahead log, else 1.
const VERSIONS: std::ops::Range<usize> = 18..20;

/// Reads the joint states of the topic with the most messages.
///
/// # Errors
/// The file cannot be read, is no bag or a damaged one, or was not closed; it has no joint states, or ones whose joints change.
pub(super) fn read(path: &Path) -> Result<Table> {
    let (_, size) = source_file::open(path)?;
    check_closed(path)?;
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    decode(path, Connection::open_with_flags(address(path), flags), size)
}

/// As [`read`], from memory.
///
/// # Errors
/// As [`read`].
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Table> {
    let mut bytes = bytes.to_vec();
    // SQLite opens no database in memory that would have a write-ahead log.
    if let Some(versions) = bytes.get_mut(VERSIONS) {
        versions.fill(1);
    }
    let opened = Connection::open_in_memory().and_then(|mut base| {
        base.deserialize_read_exact("main", bytes.as_slice(), bytes.len(), true)?;
        Ok(base)
    });
    decode(path, opened, bytes.len() as u64)
}

/// Refuses a bag whose last messages lie in a file beside it.
///
/// # Errors
/// As stated.
fn check_closed(path: &Path) -> Result<()> {
    let real = std::fs::canonicalize(path).map_err(|source| Error::file(path, "read", source))?;
    let beside = |ending: &str| {
        let mut name: OsString = real.clone().into_os_string();
        name.push(ending);
        File::open(name)
    };
    let log = beside("-wal").and_then(|log| log.metadata()).is_ok_and(|log| log.len() > EMPTY_LOG);
    let mut head = [0; JOURNAL.len()];
    let journal = beside("-journal").and_then(|mut journal| journal.read_exact(&mut head)).is_ok() && head == JOURNAL;
    let (ending, what) = match (log, journal) {
        (true, _) => ("-wal", "a write-ahead log"),
        (_, true) => ("-journal", "a journal"),
        _ => return Ok(()),
    };
    let way = format!(
        "a closed bag: stop the recorder; if it has stopped, `sqlite3 FILE 'pragma journal_mode = delete'` brings the content of FILE{ending} \
         into the bag"
    );
    Err(Error::input(path, Place::File, "bag", format!("not closed: {what} is beside it"), way_for(path, &way)))
}

/// The address by which SQLite opens a file that nobody changes. Every byte that could mean something in an address is
/// written as its number.
fn address(path: &Path) -> String {
    let mut address = String::from("file:");
    for &byte in path.as_os_str().as_encoded_bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'.' | b'_' | b'-' => address.push(char::from(byte)),
            _ => {
                let _ = write!(address, "%{byte:02X}");
            }
        }
    }
    address + "?immutable=1"
}

fn decode(path: &Path, base: Result<Connection, Sqlite>, size: u64) -> Result<Table> {
    let unreadable = |error: Sqlite| damaged(path, &error);
    let mut base = base.map_err(unreadable)?;
    let (mut counted, most) = (0, PER_BYTE.saturating_mul(size) / u64::from(COUNTED) + PER_BYTE);
    let too_many = move || {
        counted += 1;
        counted > most
    };
    base.progress_handler(COUNTED.cast_signed(), Some(too_many)).map_err(unreadable)?;
    check_tables(path, &base)?;

    let mut topics = Topics::new(path);
    let places = places(&base, &mut topics).map_err(unreadable)?;
    let ids: Vec<String> = places.keys().map(i64::to_string).collect();
    // By the order of the table, which is that of recording: an index would give another one.
    let wanted = format!(
        "SELECT topic_id, CASE WHEN length(data) <= {LONGEST} THEN data END FROM messages NOT INDEXED WHERE topic_id IN ({})",
        ids.join(",")
    );
    let mut statement = base.prepare(&wanted).map_err(unreadable)?;
    let mut rows = statement.query([]).map_err(unreadable)?;
    while let Some(row) = rows.next().map_err(unreadable)? {
        let topic = row.get_ref(0).ok().and_then(|id| id.as_i64().ok()).and_then(|id| places.get(&id));
        let Some((place, wire)) = topic else { continue };
        // A cell that is no message is an empty one.
        let content = row.get_ref(1).ok().and_then(|data| data.as_blob().ok()).unwrap_or_default();
        topics.take(*place, wire, content)?;
    }
    topics.table()
}

/// Index among the topics, and encoding, of each topic of joint states, by its id.
fn places(base: &Connection, topics: &mut Topics<'_>) -> Result<HashMap<i64, (usize, Wire)>, Sqlite> {
    let mut statement = base.prepare("SELECT id, name, type, serialization_format FROM topics NOT INDEXED")?;
    let mut rows = statement.query([])?;
    let mut places = HashMap::new();
    while let Some(row) = rows.next()? {
        let text = |column| row.get_ref(column).ok().and_then(|text| text.as_bytes().ok()).unwrap_or_default();
        let text = |column| String::from_utf8_lossy(text(column)).into_owned();
        if let Some(id) = row.get_ref(0)?.as_i64().ok().filter(|_| is_joint_state(&text(2))) {
            places.insert(id, (topics.place(text(1)), Wire::of_encoding(&text(3))));
        }
    }
    Ok(places)
}

/// Refuses a database without the tables of a bag.
///
/// # Errors
/// As stated, or it is damaged.
fn check_tables(path: &Path, base: &Connection) -> Result<()> {
    let texts = |query: &str, of: &[&str]| -> Result<Vec<String>> {
        let found = base.prepare(query).and_then(|mut statement| {
            let rows = statement.query_map(rusqlite::params_from_iter(of), |row| row.get::<_, String>(0))?;
            rows.collect()
        });
        found.map_err(|error| damaged(path, &error))
    };
    // A view has no page of its own, nor has a table that a program computes.
    let tables = texts("SELECT name FROM sqlite_schema WHERE type = 'table' AND rootpage > 0", &[])?;
    for (table, columns) in TABLES {
        let names = |names: &[String]| list(&names.iter().map(String::as_str).collect::<Vec<_>>());
        let (found, what) = if tables.iter().any(|name| name == table) {
            (texts("SELECT name FROM pragma_table_info(?1)", &[table])?, format!("columns of {table}"))
        } else {
            (tables.clone(), "tables".to_owned())
        };
        if what == "tables" || columns.iter().any(|column| !found.iter().any(|name| name == column)) {
            let value = if found.is_empty() { "none".to_owned() } else { names(&found) };
            let expected = format!("a bag of ROS 2, in which the table {table} has {}", columns.join(", "));
            return Err(Error::input(path, Place::File, what, value, expected));
        }
    }
    Ok(())
}

fn damaged(path: &Path, error: &Sqlite) -> Error {
    let value = match error.sqlite_error_code() {
        Some(ErrorCode::OutOfMemory) => "needs more memory than there is",
        Some(ErrorCode::CannotOpen | ErrorCode::PermissionDenied) => "cannot be opened",
        _ => "damaged",
    };
    let way = "a whole bag; `sqlite3 FILE .recover | sqlite3 recovered.db3` saves what is left of a damaged one";
    Error::input(path, Place::File, "SQLite", value, way_for(path, way))
}

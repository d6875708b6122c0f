//! Bags of ROS 2 in SQLite.

use lostmotion::dataset;
use lostmotion::timeseries::Channel;

use super::support::db3::{JOINT_STATE, TABLES, add, bag, good, message, messages, on_disk, written};
use super::support::recordings::{ROWS, positions};
use super::{Folder, each_is_refused};

/// Asserts that a file is the recording of the turntable.
#[track_caller]
fn is_the_turntable(session: &dataset::Session) {
    let series = &session.series;
    assert_eq!(series.len(), ROWS);
    assert!(series.time.iter().enumerate().all(|(row, time)| (time - 0.001 * row as f64).abs() < 1e-12));
    let joint = series.joint("turn").expect("the joint");
    assert_eq!(joint.get(Channel::Position), Some(positions().as_slice()));
    assert!(joint.get(Channel::Velocity).is_none() && joint.get(Channel::Torque).is_some());
}

#[test]
fn recover_the_planted_motion_from_bags_of_every_page_size() {
    let folder = Folder::new();
    for page in [512, 4096, 65_536] {
        let path = folder.put("run.db3", good(page));
        is_the_turntable(&dataset::load_alone(&path).expect("read"));
        is_the_turntable(&dataset::parse_alone(&path, &good(page)).expect("read from memory"));
    }
    // The name of the file does not matter, nor what its characters mean in an address.
    for name in ["run", "a?mode=rwc#b", "%41 b", "ü", "50%"] {
        let path = folder.put(name, good(4096));
        is_the_turntable(&dataset::load_alone(&path).expect("read"));
    }
    assert!(!folder.names().contains(&"A b".to_owned()));
}

#[test]
fn property_of_several_topics_the_longest_is_taken_and_the_others_are_named() {
    let folder = Folder::new();
    let few: Vec<Vec<u8>> = (0..5).map(|row| message(row, &["turn"], [&[9.0], &[], &[]])).collect();
    for first in [true, false] {
        let bytes = written(4096, |base| {
            base.execute_batch(TABLES).expect("tables");
            let mut topics = [("/few", &few), ("/joint_states", &messages())];
            topics.sort_by_key(|(name, _)| (*name == "/few") != first);
            topics.iter().for_each(|(name, messages)| add(base, name, JOINT_STATE, "cdr", messages));
        });
        let session = dataset::load_alone(&folder.put("run.db3", bytes)).expect("read");
        is_the_turntable(&session);
        let said = "joint states of /joint_states taken, those of /few left out";
        assert!(session.notes.iter().any(|note| note.text == said), "{:?}", session.notes);
    }
}

#[test]
fn regress_what_is_no_bag_of_joint_states_is_refused() {
    let sql = |text: &str| written(4096, |base| base.execute_batch(text).expect("tables"));
    let endless = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format);
        CREATE VIEW messages AS WITH RECURSIVE n(topic_id, data) AS (SELECT 1, x'' UNION ALL SELECT 1, x'' FROM n) SELECT * FROM n;";
    let computed = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format);
        CREATE TABLE messages(topic_id, data AS (zeroblob(500000000)));";
    each_is_refused(
        "run.db3",
        &[
            (
                sql("CREATE TABLE notes(text)"),
                &["run.db3: tables = notes", "a bag of ROS 2", "the table topics has id, name"][..],
            ),
            (sql("CREATE TABLE t(a); DROP TABLE t"), &["tables = none", "a bag of ROS 2"]),
            (
                sql("CREATE TABLE topics(id); CREATE TABLE messages(id)"),
                &["columns of topics = id", "serialization_format"],
            ),
            (sql(endless), &["tables = topics", "the table messages has topic_id, data"]),
            (sql(computed), &["columns of messages = topic_id", "the table messages has topic_id, data"]),
            (sql(TABLES), &["messages", "messages of type sensor_msgs/JointState"]),
            (bag("std_msgs/msg/String", "cdr", &messages()), &["messages of type sensor_msgs/JointState"]),
            (bag(JOINT_STATE, "cdr", &[]), &["messages of type sensor_msgs/JointState"]),
        ],
    );
}

#[test]
fn regress_damaged_bags_are_refused() {
    let topic = "/joint_states";
    let readable = "a readable sensor_msgs/JointState";
    let two = |second: Vec<u8>| bag(JOINT_STATE, "cdr", &[message(0, &["turn"], [&[1.0], &[], &[]]), second]);
    let whole = good(512);
    let mut middle = whole.clone();
    let half = middle.len() / 2;
    middle[half - 8192..half + 8192].fill(0xff);
    let mut state = message(1, &["turn"], [&[1.0], &[], &[]]);
    state.pop();
    let text = written(4096, |base| {
        base.execute_batch(TABLES).expect("tables");
        add(base, topic, JOINT_STATE, "cdr", &[]);
        base.execute("INSERT INTO messages VALUES (1, 1, 0, 'text')", []).expect("a message");
    });
    each_is_refused(
        "run.db3",
        &[
            (whole[..16].to_vec(), &["run.db3: SQLite = damaged", "a whole bag; `sqlite3 run.db3 .recover"][..]),
            (whole[..100].to_vec(), &["SQLite = damaged", "a whole bag"]),
            (whole[..whole.len() - 512].to_vec(), &["SQLite = damaged", "a whole bag"]),
            (whole[..whole.len() / 2].to_vec(), &["SQLite = damaged", "a whole bag"]),
            (middle, &["SQLite = damaged", "a whole bag"]),
            (bag(JOINT_STATE, "protobuf", &messages()), &["row 1", "/joint_states = protobuf", "encoded as cdr"]),
            (two(state), &["row 2", topic, readable]),
            (two(Vec::new()), &["row 2", topic, readable]),
            (two(vec![0, 1, 0, 0, 255, 255, 255, 255]), &["row 2", topic, readable]),
            (two(vec![0; (16 << 20) + 1]), &["row 2", topic, readable]),
            (text, &["row 1", topic, readable]),
            (
                bag(JOINT_STATE, "cdr", &[b"\x28\xb5\x2f\xfd message".to_vec()]),
                &["row 1", "/joint_states = a message compressed by zstd", "ros2 bag convert -i FOLDER"],
            ),
            (two(message(1, &["arm"], [&[1.0], &[], &[]])), &["row 2", "/joint_states = arm", "turn"]),
            (two(message(0, &["turn"], [&[2.0], &[], &[]])), &["row 2", "time = 0", "repeated"]),
            (two(message(1, &["turn"], [&[f64::NAN], &[], &[]])), &["row 2", "turn.position = NaN", "finite"]),
        ],
    );
    let folder = Folder::new();
    folder.put("run.db3.zstd", b"\x28\xb5\x2f\xfd\0");
    folder.refuses_data("run.db3.zstd", &["compressed by zstd", "`unzstd run.db3.zstd -o run.db3`"]);
}

/// A recorder that has not ended keeps messages beside its bag. Neither the bag nor its folder changes when it is read.
#[test]
fn property_a_bag_that_is_not_closed_is_refused_and_nothing_is_touched() {
    for (mode, beside, what) in
        [("wal", "run.db3-wal", "a write-ahead log"), ("delete", "run.db3-journal", "a journal")]
    {
        let folder = Folder::new();
        let path = folder.path("run.db3");
        let base = on_disk(&path);
        base.pragma_update(None, "journal_mode", mode).expect("a mode");
        // So small a memory makes SQLite write to the file, and therefore the journal, before the end of a transaction.
        base.pragma_update(None, "cache_size", 1).expect("a size");
        if mode == "delete" {
            base.execute_batch("BEGIN").expect("a transaction");
        }
        add(&base, "/joint_states", JOINT_STATE, "cdr", &messages());
        assert!(folder.names().contains(&beside.to_owned()), "{:?}", folder.names());
        // What a recorder that is killed leaves behind.
        let copy = Folder::new();
        for name in folder.names().iter().filter(|name| name.starts_with("run.db3")) {
            copy.put(name, std::fs::read(folder.path(name)).expect("its bytes"));
        }
        let state =
            || copy.names().into_iter().map(|name| (std::fs::read(copy.path(&name)).ok(), name)).collect::<Vec<_>>();
        let before = state();
        copy.refuses_data(
            "run.db3",
            &["run.db3: bag = not closed", what, "a closed bag", "pragma journal_mode = delete"],
        );
        assert!(before == state(), "the folder has changed: {:?}", copy.names());
        if mode == "wal" {
            // The way out of the message.
            let base = rusqlite::Connection::open(copy.path("run.db3")).expect("the bag");
            base.pragma_update(None, "journal_mode", "delete").expect("a mode");
            drop(base);
            is_the_turntable(&dataset::load_alone(&copy.path("run.db3")).expect("read"));
        }
    }
}

/// A recorder that ends leaves its bag in the mode of a write-ahead log, without one. SQLite would create it again.
#[test]
fn property_a_closed_bag_with_a_write_ahead_log_is_read_and_nothing_is_touched() {
    let folder = Folder::new();
    let path = folder.path("run.db3");
    let base = on_disk(&path);
    base.pragma_update(None, "journal_mode", "wal").expect("a mode");
    add(&base, "/joint_states", JOINT_STATE, "cdr", &messages());
    base.close().expect("closed");
    let (names, bytes) = (folder.names(), std::fs::read(&path).expect("its bytes"));
    assert_eq!(bytes[18..20], [2, 2], "the mode of a write-ahead log");
    is_the_turntable(&dataset::load_alone(&path).expect("read"));
    is_the_turntable(&dataset::parse_alone(&path, &bytes).expect("read from memory"));
    // An empty log and a journal without content are those of a closed bag.
    folder.put("run.db3-wal", "");
    folder.put("run.db3-journal", [0; 512]);
    is_the_turntable(&dataset::load_alone(&path).expect("read"));
    assert!(std::fs::read(&path).is_ok_and(|after| after == bytes));
    let after: Vec<String> = folder.names().into_iter().filter(|name| !name.starts_with("run.db3-")).collect();
    assert_eq!(after, names);
    assert_eq!(folder.names().len(), names.len() + 2);
}

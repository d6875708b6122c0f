//! MCAP recordings.

use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};

use super::recordings::positions;

/// A message as ROS 1 writes it.
pub fn message(row: usize, names: &[&str], lists: [&[f64]; 3]) -> Vec<u8> {
    let mut bytes: Vec<u8> = Vec::new();
    let number = |bytes: &mut Vec<u8>, value: u32| bytes.extend(value.to_le_bytes());
    number(&mut bytes, 7);
    number(&mut bytes, 1_700_000_000);
    number(&mut bytes, row as u32 * 1_000_000);
    number(&mut bytes, 0);
    number(&mut bytes, names.len() as u32);
    for name in names {
        number(&mut bytes, name.len() as u32);
        bytes.extend(name.as_bytes());
    }
    for list in lists {
        number(&mut bytes, list.len() as u32);
        bytes.extend(list.iter().flat_map(|value| value.to_le_bytes()));
    }
    bytes
}

/// Of the turntable.
pub fn messages() -> Vec<Vec<u8>> {
    let message = |(row, position): (usize, &f64)| message(row, &["turn"], [&[*position], &[], &[-position]]);
    positions().iter().enumerate().map(message).collect()
}

/// A file as the library writes it.
pub fn written(messages: &[Vec<u8>], compression: Option<Compression>, schema: &str, encoding: &str) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer =
        WriteOptions::new().compression(compression).chunk_size(Some(4096)).create(&mut bytes).expect("a writer");
    let schema = writer.add_schema(schema, "ros1msg", b"").expect("a schema");
    let channel_id = writer.add_channel(schema, "/joint_states", encoding, &Default::default()).expect("a channel");
    for (sequence, data) in messages.iter().enumerate() {
        let header = MessageHeader { channel_id, sequence: sequence as u32, log_time: 0, publish_time: 0 };
        writer.write_to_known_channel(&header, data).expect("a message");
    }
    writer.finish().expect("the file");
    drop(writer);
    bytes.into_inner()
}

/// A good file of each compression.
pub fn good(compression: Option<Compression>) -> Vec<u8> {
    written(&messages(), compression, "sensor_msgs/JointState", "ros1")
}

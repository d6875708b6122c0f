//! MCAP recordings.

use std::io::Write as _;

use lostmotion::dataset;
use mcap::Compression;

use super::support::mcap::{good, message, messages, written};
use super::support::recordings::ROWS;
use super::{Folder, each_is_refused};

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat()
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

/// A chunk that says that it has so many bytes.
fn chunk(size: u64, compression: &str, packed: &[u8]) -> Vec<u8> {
    let head = [&[0; 16][..], &size.to_le_bytes(), &[0; 4], &text(compression), &(packed.len() as u64).to_le_bytes()];
    record(6, &[&head.concat(), packed].concat())
}

fn file(records: &[Vec<u8>]) -> Vec<u8> {
    [MAGIC, &records.concat(), MAGIC].concat()
}

fn zstd(bytes: &[u8]) -> Vec<u8> {
    zstd::encode_all(bytes, 3).expect("compressed")
}

fn lz4(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
    encoder.write_all(bytes).expect("compressed");
    encoder.finish().expect("compressed")
}

#[test]
fn regress_chunks_of_every_compression_are_read() {
    let folder = Folder::new();
    for compression in [None, Some(Compression::Zstd), Some(Compression::Lz4)] {
        let path = folder.put("run.mcap", good(compression));
        let series = dataset::load_alone(&path).expect("read").series;
        assert_eq!(series.len(), ROWS);
        assert!(series.time.iter().enumerate().all(|(row, time)| (time - 0.001 * row as f64).abs() < 1e-12));
    }
}

#[test]
fn regress_a_chunk_that_claims_more_than_it_holds_ends() {
    let bytes = vec![0; 1000];
    let cases: Vec<(Vec<u8>, &[&str])> = vec![
        // The library's own reader waits for these bytes without end.
        (file(&[chunk(5000, "zstd", &zstd(&bytes))]), &["record at byte 8 = cut off", "whole MCAP"]),
        (file(&[chunk(5000, "lz4", &lz4(&bytes))]), &["record at byte 8 = cut off"]),
        (file(&[chunk(5000, "", &bytes)]), &["record at byte 8 = cut off"]),
        (file(&[chunk(5000, "zstd", &[])]), &["record at byte 8 = cut off"]),
        (file(&[chunk(5000, "lz4", &[])]), &["record at byte 8 = cut off"]),
        (file(&[chunk(1000, "zstd", b"neither")]), &["record at byte 8 = "]),
        (file(&[chunk(1000, "lz4", b"neither")]), &["record at byte 8 = "]),
        (file(&[chunk(1000, "bz2", &bytes)]), &["record at byte 8 = damaged"]),
        (file(&[chunk(1000, "zstd", &zstd(&[7; 1000]))]), &["record at byte 8 = damaged"]),
        (file(&[chunk(u64::MAX, "zstd", &zstd(&bytes))]), &["chunk at byte 8", "at most 256 MiB"]),
        (file(&[chunk(3 << 30, "lz4", &lz4(&bytes))]), &["chunk at byte 8 = 3 GiB", "at most 256 MiB"]),
        (file(&[record(6, &[0; 10])]), &["record at byte 8 = cut off"]),
    ];
    each_is_refused("run.mcap", &cases);
    // Seventeen chunks of 256 MiB of nothing: 8 KB each.
    let zeros = vec![0_u8; 1 << 20];
    let mut encoder = zstd::Encoder::new(Vec::new(), 1).expect("a compressor");
    let mut empty = record(99, &[]);
    empty[1..9].copy_from_slice(&((256_u64 << 20) - 9).to_le_bytes());
    encoder.write_all(&empty).expect("compressed");
    (0..256).for_each(|_| encoder.write_all(&zeros).expect("compressed"));
    let packed = encoder.finish().expect("compressed");
    let folder = Folder::new();
    folder.put("run.mcap", file(&vec![chunk(256 << 20, "zstd", &packed); 17]));
    folder.refuses_data("run.mcap", &["run.mcap: uncompressed size", "4.2 GiB", "at most 4 GiB", "filter the topic"]);
}

#[test]
fn regress_broken_recordings_of_messages_are_refused() {
    let good = good(None);
    let joint_state = "sensor_msgs/JointState";
    let two =
        |second: Vec<u8>| written(&[message(0, &["turn"], [&[1.0], &[], &[]]), second], None, joint_state, "ros1");
    let mut long = record(5, &[0; 30]);
    long[1..9].copy_from_slice(&u64::MAX.to_le_bytes());
    let mut count = message(1, &["turn"], [&[1.0], &[], &[]]);
    count[16..20].copy_from_slice(&u32::MAX.to_le_bytes());
    let topic = "/joint_states";
    let readable = "a readable sensor_msgs/JointState";
    each_is_refused(
        "run.mcap",
        &[
            (b"not an MCAP file".to_vec(), &["run.mcap:1: header = not an MCAP file"][..]),
            (MAGIC.to_vec(), &["record at byte 8 = cut off"]),
            (file(&[]), &["messages", "messages of type sensor_msgs/JointState"]),
            (file(&[long]), &["record at byte 8 = cut off"]),
            (good[..good.len() - 1].to_vec(), &["cut off", "a whole MCAP file"]),
            (good[..good.len() / 2].to_vec(), &["cut off", "a whole MCAP file"]),
            (written(&messages(), None, "std_msgs/String", "ros1"), &["messages of type sensor_msgs/JointState"]),
            (
                written(&messages(), None, joint_state, "json"),
                &["row 1", "/joint_states = json", readable, "cdr or ros1"],
            ),
            (written(&messages(), None, joint_state, "cdr"), &["row 1", topic, readable]),
            (two(message(1, &["arm"], [&[1.0], &[], &[]])), &["row 2", "/joint_states = arm", "turn"]),
            (two(message(1, &["turn", "arm"], [&[1.0, 2.0], &[], &[]])), &["row 2", "turn, arm"]),
            (two(message(1, &["turn"], [&[1.0, 2.0], &[], &[]])), &["row 2", topic, readable]),
            (two(message(1, &[], [&[], &[], &[]])), &["row 2", topic, readable]),
            (two(count), &["row 2", topic, readable]),
            (two(message(0, &["turn"], [&[2.0], &[], &[]])), &["row 2", "time = 0", "repeated"]),
            (two(message(1, &["turn"], [&[f64::NAN], &[], &[]])), &["row 2", "turn.position = NaN", "finite"]),
            (
                written(&[message(0, &["turn", "turn"], [&[1.0, 2.0], &[], &[]])], None, joint_state, "ros1"),
                &["column = turn.position", "once"],
            ),
            (
                written(&[message(0, &["a\u{1b}"], [&[1.0], &[], &[]])], None, joint_state, "ros1"),
                &["column = a\\u{1b}.position", "control"],
            ),
        ],
    );
}

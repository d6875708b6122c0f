//! Parquet files.

use lostmotion::dataset;
use parquet::basic::Compression;

use super::support::parquet::{Third, counts, good, written};
use super::support::recordings::{ROWS, positions};
use super::{Folder, each_is_refused};

#[test]
fn regress_time_stamps_are_read_in_their_own_unit() {
    let folder = Folder::new();
    let torque = positions();
    for (unit, step) in [("MILLIS", 1), ("MICROS", 1000), ("NANOS", 1_000_000)] {
        let third = ("required double turn.torque;", Third::Numbers(&torque));
        let time = format!("(TIMESTAMP({unit},true))");
        let path = folder.put("run.parquet", written(&time, &counts(step), third.0, &third.1, Compression::SNAPPY));
        let series = dataset::load_alone(&path).expect("read").series;
        // Nanoseconds since 1970 as an f64 would be off by 1e-7.
        assert!(series.time.iter().enumerate().all(|(row, time)| (time - 0.001 * row as f64).abs() < 1e-15), "{unit}");
        // The same numbers without a type are recognised by their size and steps.
        let path = folder.put("run.parquet", written("", &counts(step), third.0, &third.1, Compression::SNAPPY));
        assert_eq!(dataset::load_alone(&path).expect("read").series, series);
        // A manifest may not say otherwise.
        folder.put("run.parquet", written(&time, &counts(step), third.0, &third.1, Compression::SNAPPY));
        let manifest = "schema = 'lostmotion/dataset/1'\nfile = 'run.parquet'\n[time]\ncolumn = 'time'\nunit = 'ms'\n\
                        [joints.turn]\nposition = { column = 'turn.position' }\n";
        folder.put("turn.toml", manifest);
        folder.refuses_data("turn.toml", &["turn.toml:4: time.unit = ms", "time stamps"]);
    }
}

#[test]
fn regress_columns_that_are_no_numbers_are_told_by_their_type() {
    let whole: Vec<i64> = (0..ROWS as i64).collect();
    let file = |third: &str, content: Third<'_>| {
        written("(TIMESTAMP_MICROS)", &counts(1000), third, &content, Compression::UNCOMPRESSED)
    };
    let name = "row 1: turn.torque = ";
    each_is_refused(
        "run.parquet",
        &[
            (
                file("required fixed_len_byte_array(16) turn.torque (DECIMAL(38,10));", Third::Bytes),
                &[name, "(decimal numbers of more than 18 digits)", "a number"][..],
            ),
            (file("required binary turn.torque (UTF8);", Third::Text), &[name, "(text)", "a number"]),
            (file("required fixed_len_byte_array(16) turn.torque;", Third::Bytes), &[name, "(bytes)"]),
            (
                file("required group turn.torque { required int64 x; }", Third::Whole(&whole)),
                &[name, "(lists or structures)"],
            ),
        ],
    );
    let folder = Folder::new();
    let decimal = file("required int64 turn.torque (DECIMAL(18,2));", Third::Whole(&whole));
    let session = dataset::load_alone(&folder.put("run.parquet", decimal)).expect("read");
    let torque = session.series.joints[0].get(lostmotion::timeseries::Channel::Torque).expect("torque");
    assert_eq!(torque[150], 1.5);
}

#[test]
fn regress_broken_parquet_files_are_refused_without_a_panic() {
    let good = good(Compression::SNAPPY);
    let end = good.len();
    let length = u32::from_le_bytes(good[end - 8..end - 4].try_into().expect("four bytes")) as usize;
    let footer = end - 8 - length;
    let with = |at: usize, bytes: &[u8]| {
        let mut changed = good.clone();
        changed[at..at + bytes.len()].copy_from_slice(bytes);
        changed
    };
    // A footer of one list of two thousand million row groups, and one of a schema without end.
    let claims = |body: &[u8]| [&b"PAR1"[..], body, &(body.len() as u32).to_le_bytes(), b"PAR1"].concat();
    let list = claims(&[0x15, 0x02, 0x19, 0xfc, 0xff, 0xff, 0xff, 0xff, 0x07, 0x00, 0x00]);
    let groups = claims(&[0x15, 0x02, 0x29, 0xfc, 0xff, 0xff, 0xff, 0xff, 0x07, 0x00, 0x00]);
    let flags = claims(&[0x15, 0x02, 0x89, 0xf1, 0xff, 0xff, 0xff, 0xff, 0x07, 0x00, 0x00]);
    // A chain of 2000 groups, each in the one before.
    let node = [0x48, 0x01, b'g', 0x15, 0x02, 0x00];
    let chain = claims(&[&[0x15, 0x02, 0x19, 0xfc, 0xd0, 0x0f][..], &node.repeat(2000), &[0x00]].concat());
    let damaged = "parquet = damaged footer";
    each_is_refused(
        "run.parquet",
        &[
            (good[..end - 1].to_vec(), &["parquet = cut off", "an Apache Parquet file"][..]),
            (good[..footer].to_vec(), &["parquet = cut off"]),
            (b"PAR1".to_vec(), &["parquet = cut off"]),
            (b"PAR1PAR1".to_vec(), &["parquet = "]),
            (with(end - 4, b"PARE"), &["parquet = encrypted"]),
            (with(end - 8, &u32::MAX.to_le_bytes()), &[damaged]),
            (with(end - 8, &[1, 0, 0, 0]), &["parquet = damaged"]),
            (with(footer, &[0xff; 40]), &[damaged]),
            (list, &[damaged]),
            (groups, &[damaged]),
            (flags, &[damaged]),
            (chain, &[damaged]),
            (with(4, &[0xff; 20]), &["time = a damaged page"]),
            (with(40, &[0xaa; 200]), &["run.parquet"]),
        ],
    );
}

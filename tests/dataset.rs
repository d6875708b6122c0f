//! Measured data: what is read, what is mended, what is refused.

use std::fs;
use std::time::Instant;

use lostmotion::dataset::{self, Session};
use lostmotion::error::Result;
use lostmotion::timeseries::{Channel, JointSeries, Samples, TimeSeries};
use lostmotion::units::{DEG, JointKind};

fn arm() -> Vec<(String, JointKind)> {
    vec![("shoulder".into(), JointKind::Revolute), ("slide".into(), JointKind::Prismatic)]
}

fn load_text(name: &str, text: &str) -> Result<Session> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    fs::write(&path, text).expect("a file in a temporary folder");
    dataset::load(&path, &arm())
}

#[track_caller]
fn says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "`{part}` not in: {message}");
    }
}

#[test]
fn property_canonical_columns_become_channels() {
    let text = "time,shoulder.position,slide.force,slide.velocity\n0,1,2,3\n0.05,4,5,6\n0.1,7,8,9\n";
    let session = load_text("run.csv", text).expect("a good file");
    assert_eq!(session.series.name, "run");
    assert_eq!(session.series.time, [0.0, 0.05, 0.1]);
    let joint = |name: &str| session.series.joint(name).expect("joint");
    assert_eq!(joint("shoulder").get(Channel::Position), Some(&[1.0, 4.0, 7.0][..]));
    assert_eq!(joint("slide").get(Channel::Torque), Some(&[2.0, 5.0, 8.0][..]));
    assert_eq!(joint("slide").get(Channel::Velocity), Some(&[3.0, 6.0, 9.0][..]));
    assert!(session.notes.is_empty(), "{:?}", session.notes);
}

/// Behind the gear a turning joint has a torque and a sliding one a force.
#[test]
fn property_torque_behind_the_gear_has_a_column_of_its_own() {
    let text = "time,shoulder.position,shoulder.link_torque,slide.link_force\n0,1,2,3\n0.05,4,5,6\n0.1,7,8,9\n";
    let session = load_text("run.csv", text).expect("a good file");
    let joint = |name: &str| session.series.joint(name).expect("joint");
    assert_eq!(joint("shoulder").get(Channel::LinkTorque), Some(&[2.0, 5.0, 8.0][..]));
    assert_eq!(joint("slide").get(Channel::LinkTorque), Some(&[3.0, 6.0, 9.0][..]));
    assert_eq!(joint("shoulder").get(Channel::Torque), None);
    let wrong = load_text("run.csv", &text.replace("link_force", "link_torque")).expect_err("a slide has forces");
    says(&wrong.to_string(), &["slide.link_torque", "link_force"]);
}

#[test]
fn property_written_csv_reads_back_bit_by_bit() {
    // A slide does not get farther than some metres in a millisecond.
    let positions = [0.1 + 0.2, -1.0 / 3.0, 1e-300, 1.23456789];
    let torques = [-0.1 - 0.2, 1.0 / 3.0, -1e-300, -123456.789];
    let measured = [Channel::Torque, Channel::LinkTorque].map(|channel| (channel, torques.to_vec()));
    let channels = [(Channel::Position, positions.to_vec()), measured[0].clone(), measured[1].clone()]
        .map(|(channel, values)| (channel, Samples::from(values)));
    let joints = ["shoulder", "slide"].map(|name| JointSeries { name: name.into(), channels: channels.clone().into() });
    let series = TimeSeries { name: "trip".into(), time: vec![0.0, 1e-3, 2e-3, 3e-3], joints: joints.into() };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("trip.csv");
    dataset::write_csv(&path, &series, &[JointKind::Revolute, JointKind::Prismatic]).expect("written");
    assert_eq!(dataset::load(&path, &arm()).expect("read").series, series);
    let left: Vec<_> = fs::read_dir(folder.path()).expect("folder").collect();
    assert_eq!(left.len(), 1, "nothing but the file is left");
}

#[test]
fn property_a_last_row_that_was_cut_off_is_dropped_and_said() {
    let session = load_text("a.csv", "time,shoulder.position\n0,1\n.01,2\n.02,3\n.03,").expect("mended");
    assert_eq!(session.series.time, [0.0, 0.01, 0.02]);
    says(&session.notes[0].to_string(), &["a.csv", "row 4", "cut off"]);
}

#[test]
fn property_rows_that_repeat_are_dropped_and_said() {
    let session =
        load_text("a.csv", "time,shoulder.position\n0,1\n.01,2\n.01,2\n.02,3\n.02,3\n.03,4\n").expect("mended");
    assert_eq!(session.series.time, [0.0, 0.01, 0.02, 0.03]);
    says(&session.notes[0].to_string(), &["row 3", "2 rows that repeat"]);
}

#[test]
fn property_missing_samples_and_dead_channels_are_said() {
    let session = load_text("a.csv", "time,shoulder.position\n0,1\n.01,1\n.02,1\n.04,1\n.05,1\n").expect("usable");
    says(&session.notes[0].to_string(), &["row 4", "time", "1 steps longer"]);
    says(&session.notes[1].to_string(), &["shoulder.position", "constant at 1"]);
}

/// Every tenth step is twice as long: nothing is missing here and there, and times are taken as they are.
#[test]
fn property_uneven_sampling_is_no_defect() {
    let rows = (0..200).map(|k| format!("{},{}\n", 0.01 * f64::from(k + k / 10), 0.1 * f64::from(k)));
    let text = format!("time,shoulder.position\n{}", rows.collect::<String>());
    assert_eq!(load_text("a.csv", &text).expect("usable").notes, Vec::new());
}

#[test]
fn property_a_manifest_gives_names_units_and_scale() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("raw.csv"), "ms,angle,load,note\n0,180,1,a\n50,90,2,b\n100,45,-4,c\n").expect("data");
    let manifest = folder.path().join("turn.toml");
    let text = "schema = 'lostmotion/dataset/1'\nfile = 'raw.csv'\n[time]\ncolumn = 'ms'\nunit = 'ms'\n[joints.shoulder]\n\
        position = { column = 'angle', unit = 'deg', scale = 0.5 }\ntorque = { column = 'load', unit = 'V', scale = 3 }\n";
    fs::write(&manifest, text).expect("manifest");
    let session = dataset::load(&manifest, &arm()).expect("a good manifest");
    assert_eq!(session.series.name, "turn");
    assert_eq!(session.series.time, [0.0, 0.05, 0.1]);
    let shoulder = session.series.joint("shoulder").expect("joint");
    assert_eq!(shoulder.get(Channel::Torque), Some(&[3.0, 6.0, -12.0][..]));
    let expected = [90.0 * DEG, 45.0 * DEG, 22.5 * DEG];
    let position = shoulder.get(Channel::Position).expect("position");
    // One rounding of the factor, one of the product: two units in the last place of 1.6.
    assert!(position.iter().zip(expected).all(|(a, b)| (a - b).abs() < 5e-16), "{position:?}");
}

#[test]
fn property_a_long_recording_reads_in_under_a_second() {
    const ROWS: usize = 160_000;
    let mut text =
        String::from("time,shoulder.position,shoulder.velocity,shoulder.current,slide.position,slide.velocity\n");
    for row in 0..ROWS {
        let phase = row as f64 * 1e-3;
        text +=
            &format!("{phase:.3},{:.7},{:.6},{:.5},{:.7},{:.6}\n", phase.sin(), phase.cos(), -phase.sin(), phase, 1.0);
    }
    let start = Instant::now();
    let session = load_text("long.csv", &text).expect("a good file");
    assert_eq!(session.series.len(), ROWS);
    // Measured: 0.06 s optimised; a second leaves room for a slow disk and a build without optimisation.
    assert!(start.elapsed().as_secs_f64() < 1.0, "{:?}", start.elapsed());
}

#[test]
fn property_a_survey_says_what_a_file_holds_and_a_first_manifest_reads_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("log.csv");
    let text = "t_ms,shoulder_position_deg,shoulder_torque_nm,state\n0,1,2,idle\n1,2,2,run\n2,3,2,run\n";
    fs::write(&path, text).expect("a file");
    let table = dataset::read_table(&path).expect("a table");
    let survey = dataset::survey(&table);
    for part in ["3 rows, 4 columns", "increasing, median step 1.0000e0", "constant 2", "row 1: \"idle\""] {
        assert!(survey.contains(part), "`{part}` not in {survey}");
    }
    let manifest = folder.path().join("log.toml");
    fs::write(&manifest, dataset::first_manifest(&table, "log.csv", None)).expect("a file");
    let series = dataset::load(&manifest, &arm()).expect("a readable manifest").series;
    assert_eq!(series.time, [0.0, 0.001, 0.002]);
    let shoulder = series.joint("shoulder").expect("joint");
    assert_eq!(shoulder.get(Channel::Position), Some(&[DEG, 2.0 * DEG, 3.0 * DEG][..]));
    assert_eq!(shoulder.get(Channel::Torque), Some(&[2.0; 3][..]));
}

#[cfg(feature = "parquet")]
#[test]
fn property_parquet_reads_as_the_same_csv() {
    use parquet::data_type::{DoubleType, Int64Type};
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;

    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("run.parquet");
    let schema = "message run { required int64 time (TIMESTAMP_MICROS); required double shoulder.position; optional double slide.force; }";
    let schema = std::sync::Arc::new(parse_message_type(schema).expect("a schema"));
    let file = fs::File::create(&path).expect("a file");
    let properties = WriterProperties::builder().set_compression(parquet::basic::Compression::SNAPPY).build();
    let mut writer = SerializedFileWriter::new(file, schema, properties.into()).expect("a writer");
    let mut rows = writer.next_row_group().expect("rows");
    let mut column = rows.next_column().expect("rows").expect("time");
    column.typed::<Int64Type>().write_batch(&[0, 1000, 2000], None, None).expect("time");
    column.close().expect("time");
    for values in [[0.1, 0.2, 0.3], [4.0, 5.0, 6.0]] {
        let mut column = rows.next_column().expect("rows").expect("a column");
        let defined = [1_i16; 3];
        let defined = (values[0] == 4.0).then_some(&defined[..]);
        column.typed::<DoubleType>().write_batch(&values, defined, None).expect("values");
        column.close().expect("a column");
    }
    rows.close().expect("rows");
    writer.close().expect("the file");

    let series = dataset::load(&path, &arm()).expect("a recording").series;
    let text = "time,shoulder.position,slide.force\n0,0.1,4\n0.001,0.2,5\n0.002,0.3,6\n";
    assert_eq!(series, load_text("run.csv", text).expect("the same").series);

    let good = fs::read(&path).expect("bytes");
    for cut in 0..good.len() {
        fs::write(&path, &good[..cut]).expect("a file");
        says(&dataset::load(&path, &arm()).expect_err("cut off").to_string(), &["run.parquet"]);
        // A changed byte may yield other numbers; it must not end the program.
        let mut changed = good.clone();
        changed[cut] ^= 0x55;
        fs::write(&path, &changed).expect("a file");
        dataset::load(&path, &arm()).ok();
    }
}

#[cfg(feature = "mcap")]
mod mcap_files {
    use std::path::Path;

    use super::*;
    use mcap::Writer;
    use mcap::records::MessageHeader;

    /// A message in the CDR of ROS 2 or as ROS 1 writes it.
    fn message(cdr: bool, stamp: (u32, u32), names: &[&str], lists: [&[f64]; 3]) -> Vec<u8> {
        let mut bytes: Vec<u8> = Vec::new();
        let align = |bytes: &mut Vec<u8>, to: usize| {
            if cdr {
                bytes.resize(bytes.len().next_multiple_of(to), 0);
            }
        };
        let number = |bytes: &mut Vec<u8>, value: u32| {
            align(bytes, 4);
            bytes.extend(value.to_le_bytes());
        };
        let string = |bytes: &mut Vec<u8>, text: &str| {
            number(bytes, (text.len() + usize::from(cdr)) as u32);
            bytes.extend(text.as_bytes());
            bytes.extend(vec![0; usize::from(cdr)]);
        };
        if !cdr {
            number(&mut bytes, 7);
        }
        number(&mut bytes, stamp.0);
        number(&mut bytes, stamp.1);
        string(&mut bytes, "base");
        number(&mut bytes, names.len() as u32);
        names.iter().for_each(|name| string(&mut bytes, name));
        for list in lists {
            number(&mut bytes, list.len() as u32);
            for value in list {
                align(&mut bytes, 8);
                bytes.extend(value.to_le_bytes());
            }
        }
        if cdr { [&[0, 1, 0, 0], bytes.as_slice()].concat() } else { bytes }
    }

    fn write(path: &Path, cdr: bool, messages: &[Vec<u8>]) {
        let mut writer = Writer::new(fs::File::create(path).expect("a file")).expect("a writer");
        let name = if cdr { "sensor_msgs/msg/JointState" } else { "sensor_msgs/JointState" };
        let schema = writer.add_schema(name, "ros2msg", b"").expect("a schema");
        let encoding = if cdr { "cdr" } else { "ros1" };
        let channel_id = writer.add_channel(schema, "/joint_states", encoding, &Default::default()).expect("a channel");
        for (sequence, data) in messages.iter().enumerate() {
            let header = MessageHeader { channel_id, sequence: sequence as u32, log_time: 0, publish_time: 0 };
            writer.write_to_known_channel(&header, data).expect("a message");
        }
        writer.finish().expect("the file");
    }

    #[test]
    fn property_joint_states_of_both_encodings_read_as_canonical_columns() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("run.mcap");
        for cdr in [true, false] {
            let states = [(10, 999_000_000), (11, 0), (11, 1_000_000)].map(|stamp| {
                let t = f64::from(stamp.0) + 1e-9 * f64::from(stamp.1);
                message(cdr, stamp, &["shoulder", "slide"], [&[t, -t], &[], &[2.0 * t, 5.0]])
            });
            write(&path, cdr, &states);
            let series = dataset::load(&path, &arm()).expect("a recording").series;
            // Nanoseconds as a double.
            assert!(series.time.iter().zip([0.0, 1e-3, 2e-3]).all(|(a, b)| (a - b).abs() < 1e-12), "{:?}", series.time);
            let joint = |name: &str| series.joint(name).expect("joint");
            assert_eq!(joint("slide").get(Channel::Position), Some(&[-10.999, -11.0, -11.001][..]));
            assert_eq!(joint("shoulder").get(Channel::Torque), Some(&[21.998, 22.0, 22.002][..]));
            assert_eq!(joint("slide").get(Channel::Torque), Some(&[5.0; 3][..]));
            assert_eq!(joint("slide").get(Channel::Velocity), None);
        }
    }

    #[test]
    fn property_broken_recordings_are_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("run.mcap");
        let good = message(true, (1, 0), &["shoulder"], [&[1.0], &[], &[]]);
        let changed = message(true, (2, 0), &["slide"], [&[1.0], &[], &[]]);
        let unfit = message(true, (2, 0), &["shoulder"], [&[1.0, 2.0], &[], &[]]);
        let refusal = || dataset::load(&path, &arm()).expect_err("refused").to_string();
        write(&path, true, &[good.clone(), changed]);
        says(&refusal(), &["run.mcap", "row 2", "/joint_states", "slide", "shoulder"]);
        write(&path, true, &[good.clone(), unfit]);
        says(&refusal(), &["row 2", "readable sensor_msgs/JointState"]);
        for cut in 0..good.len() {
            write(&path, true, &[good[..cut].to_vec()]);
            says(&refusal(), &["row 1", "readable sensor_msgs/JointState"]);
        }
        write(&path, true, &[]);
        says(&refusal(), &["messages of type sensor_msgs/JointState"]);
        write(&path, true, &[good.clone(), good]);
        let whole = fs::read(&path).expect("bytes");
        for cut in 0..whole.len() {
            fs::write(&path, &whole[..cut]).expect("a file");
            // What lies behind the data may be missing; then the two equal messages are one row, too few.
            says(&refusal(), &["run.mcap"]);
        }
    }
}

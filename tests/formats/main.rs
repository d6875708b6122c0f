//! One recording in the formats that users have, written by the libraries that they use (`make.py`): every file is read as
//! the same recording, at once or by the manifest that `lostmotion data` prints, or is refused with the way out.
//!
//! `LOSTMOTION_REFRESH=1 cargo test --test formats` writes the table of `docs/formats.md` anew.

mod cases;
mod commands;

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use lostmotion::dataset::{self, Session};
use lostmotion::timeseries::{Channel, JointSeries, TimeSeries};

use cases::{CASES, Case, Read};

/// Marks of the table in `docs/formats.md`.
const BEGIN: &str = "<!-- written by tests/formats -->\n";
const END: &str = "<!-- end of written -->\n";

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn corpus(name: &str) -> PathBuf {
    root().join("tests/formats/corpus").join(name)
}

fn source() -> TimeSeries {
    dataset::load_alone(&corpus("plain.csv")).expect("the recording itself").series
}

/// Formats that this build lacks are left out.
fn cases() -> impl Iterator<Item = &'static Case> {
    CASES.iter().filter(|case| {
        let lacks = |ending: &str, feature: bool| case.file.ends_with(ending) && !feature;
        !lacks(".parquet", cfg!(feature = "parquet"))
            && !lacks(".mcap", cfg!(feature = "mcap"))
            && !lacks(".db3", cfg!(feature = "db3"))
    })
}

/// The session of a file by its first manifest, saved beside a copy of it.
fn by_manifest(case: &Case) -> Session {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let copy = folder.path().join(case.file);
    fs::copy(corpus(case.file), &copy).expect("a copy");
    let table = dataset::read_table(&copy).unwrap_or_else(|error| panic!("{error}"));
    let text = dataset::first_manifest(&table, case.file, None);
    let manifest = folder.path().join("first.toml");
    fs::write(&manifest, &text).expect("a manifest");
    dataset::load_alone(&manifest).unwrap_or_else(|error| panic!("{}: {error}\n{text}", case.file))
}

/// Compares a session with the recording, in the channels that the case has.
fn compare(case: &Case, session: &Session) {
    let source = source();
    let found = &session.series;
    assert_eq!(found.len(), source.len(), "{}", case.file);
    for (row, (time, expected)) in found.time.iter().zip(&source.time).enumerate() {
        let error = (time - expected).abs();
        assert!(error <= case.time_error, "{}, row {row}: {time} s for {expected} s", case.file);
    }
    assert_eq!(found.joints.len(), source.joints.len(), "{}: {:?}", case.file, names(found));
    for (joint, expected) in found.joints.iter().zip(&source.joints) {
        compare_joint(case, joint, expected);
    }
}

fn compare_joint(case: &Case, joint: &JointSeries, expected: &JointSeries) {
    let channels: Vec<Channel> = case.channels.iter().map(|channel| channel.0).collect();
    assert_eq!(joint.channels.keys().copied().collect::<Vec<_>>(), channels, "{}: {}", case.file, joint.name);
    for (channel, of) in case.channels {
        let (found, expected) = (joint.get(*channel).expect("a channel"), expected.get(*of).expect("its source"));
        // Values are rounded to f32 or to degrees and back; the largest is 15.
        let most = if case.single { 1e-6 } else { 1e-13 };
        let worst = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst <= most, "{}: {channel:?} of {} is off by {worst:e}", case.file, joint.name);
    }
}

fn names(series: &TimeSeries) -> Vec<&str> {
    series.joints.iter().map(|joint| joint.name.as_str()).collect()
}

#[test]
fn equivalent_every_format_reads_as_the_same_recording() {
    for case in cases() {
        let loaded = dataset::load_alone(&corpus(case.file));
        match (&case.read, loaded) {
            (Read::Directly, Ok(session)) => compare(case, &session),
            (Read::ByManifest(doubt), Err(error)) => {
                let message = error.to_string();
                assert!(message.contains(doubt) && message.contains("manifest"), "{}: {message}", case.file);
            }
            (Read::Refused(way), Err(error)) => {
                let message = error.to_string();
                assert!(message.contains(way), "{}: {message}", case.file);
            }
            (_, Ok(_)) => panic!("{} is read without a word", case.file),
            (_, Err(error)) => panic!("{error}"),
        }
    }
}

#[test]
fn equivalent_every_first_manifest_loads_as_the_same_recording() {
    for case in cases().filter(|case| !matches!(case.read, Read::Refused(_))) {
        compare(case, &by_manifest(case));
    }
}

#[test]
fn property_a_doubt_is_marked_in_the_first_manifest() {
    for case in cases() {
        let Read::ByManifest(_) = case.read else { continue };
        let table = dataset::read_table(&corpus(case.file)).expect("a table");
        let text = dataset::first_manifest(&table, case.file, None);
        assert!(text.contains("# guess: "), "{}:\n{text}", case.file);
    }
}

/// With a model, joints that have numbers only are its joints in its order, and a note says so.
#[test]
fn property_numbers_are_matched_with_the_joints_of_a_model_in_its_order() {
    let turns = lostmotion::units::JointKind::Revolute;
    let joints = [("shoulder".to_owned(), turns), ("elbow".to_owned(), turns)];
    for file in ["numbered.csv", "ur_rtde.csv", "q_dq_tau.csv", "brackets.csv", "matrices.mat", "plotjuggler.csv"] {
        let session = dataset::load(&corpus(file), &joints).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(names(&session.series), ["shoulder", "elbow"], "{file}");
        let said = session.notes.iter().any(|note| note.text.contains("by their numbers, in its order"));
        assert!(said, "{file}: {:?}", session.notes);
        let error = dataset::load(&corpus(file), &joints[..1]).expect_err("two joints for one").to_string();
        assert!(error.contains("are not those of the model") && error.contains("shoulder"), "{error}");
    }
    // Counted from 0, `position_1` is the second joint, even where the model has a `joint1`.
    let counted = [("joint1".to_owned(), turns), ("joint2".to_owned(), turns)];
    for file in ["numbered.csv", "ur_rtde.csv", "brackets.csv", "matrices_compressed.npz"] {
        let found = dataset::load(&corpus(file), &counted).unwrap_or_else(|error| panic!("{error}")).series;
        assert_eq!(names(&found), ["joint1", "joint2"], "{file}");
        let position = |series: &TimeSeries| series.joints[0].get(Channel::Position).map(<[f64]>::to_vec);
        assert_eq!(position(&found), position(&source()), "{file}");
        let three = [&counted[..], &[("joint3".to_owned(), turns)]].concat();
        let error = dataset::load(&corpus(file), &three).expect_err("two joints for three").to_string();
        assert!(error.contains("are not those of the model"), "{error}");
    }
    // Names go to names, whatever the order.
    let named = [("joint2".to_owned(), turns), ("joint1".to_owned(), turns)];
    for file in ["plotjuggler.csv", "vectors.mat", "struct.mat", "units_in_brackets.csv"] {
        let session = dataset::load(&corpus(file), &named).unwrap_or_else(|error| panic!("{error}"));
        let source = source();
        for joint in ["joint1", "joint2"] {
            let position = |series: &TimeSeries| {
                series.joint(joint).and_then(|joint| joint.get(Channel::Position).map(<[f64]>::to_vec))
            };
            let (found, expected) =
                (position(&session.series).expect("position"), position(&source).expect("position"));
            assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-13), "{file}: {joint}");
        }
        assert!(!session.notes.iter().any(|note| note.text.contains("by their numbers")), "{file}");
    }
}

/// What `docs/formats.md` says of each file of the corpus.
fn table() -> String {
    let mut text = String::from("| file | written by | read |\n|---|---|---|\n");
    for case in CASES {
        let read = match &case.read {
            Read::Directly => format!("directly{}", channels(case)),
            Read::ByManifest(doubt) => format!(
                "with the manifest that `lostmotion data` prints{}; asks: {}",
                channels(case),
                doubt.trim_end_matches('?')
            ),
            Read::Refused(_) => {
                let error = dataset::load_alone(&corpus(case.file)).expect_err("refused").to_string();
                let way = error.split_once(": expected ").map_or("", |(_, way)| way).replace('|', "\\|");
                format!("no; the message gives the way out: {way}")
            }
        };
        let _ = writeln!(text, "| {} | {} | {read} |", case.file, case.made);
    }
    text
}

fn channels(case: &Case) -> String {
    let name =
        |of: Channel| dataset::CHANNEL_COLUMNS.iter().find(|(_, channel)| *channel == of).map_or("", |(name, _)| name);
    let names: Vec<&str> = case.channels.iter().map(|(channel, _)| name(*channel)).collect();
    format!(": {}", names.join(", "))
}

#[test]
fn property_the_table_of_formats_is_current() {
    let path = root().join("docs/formats.md");
    let text = fs::read_to_string(&path).expect("docs/formats.md");
    let (head, rest) = text.split_once(BEGIN).expect("the beginning of the table");
    let (_, tail) = rest.split_once(END).expect("its end");
    let current = format!("{head}{BEGIN}{}{END}{tail}", table());
    if std::env::var_os("LOSTMOTION_REFRESH").is_some() {
        fs::write(&path, current).expect("written");
    } else {
        assert!(text == current, "docs/formats.md is out of date: LOSTMOTION_REFRESH=1 cargo test --test formats");
    }
}

/// Every file of the corpus is in the table of cases, and is small.
#[test]
fn property_the_corpus_is_complete_and_small() {
    let entries = fs::read_dir(corpus("")).expect("the corpus").map(|entry| entry.expect("an entry"));
    let mut size = 0;
    for entry in entries {
        let name = entry.file_name().to_string_lossy().into_owned();
        size += entry.metadata().expect("its size").len();
        assert!(name == "VERSIONS" || CASES.iter().any(|case| case.file == name), "{name} is no case");
    }
    for case in CASES {
        assert!(Path::new(&corpus(case.file)).is_file(), "{}", case.file);
    }
    // Half a megabyte: a repository that everyone fetches carries it.
    assert!(size < 512 << 10, "{size} bytes");
}

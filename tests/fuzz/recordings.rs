//! Recordings.

use std::path::Path;

use lostmotion::dataset;

use super::campaign::{Good, Reached, run};
use super::support::recordings::{array, compressed, doubles, mat, positions, run_csv, times};

/// Breaks a recording of one format, in all its variants.
fn survive(format: &str, text: bool, variants: Vec<Vec<u8>>) {
    let name = format!("run.{format}");
    let path = Path::new(&name);
    let corpus: Vec<Good> = variants.into_iter().map(|bytes| Good { path: path.to_owned(), bytes }).collect();
    for good in &corpus {
        assert!(dataset::parse_alone(path, &good.bytes).is_ok(), "{:?}", dataset::parse_alone(path, &good.bytes).err());
    }
    run(format, text, &corpus, |_, bytes| {
        let reached = match dataset::parse_alone(path, bytes) {
            Ok(session) => {
                check(&session);
                dataset::survey_session(&session);
                Reached::Done
            }
            Err(error) => {
                let message = error.to_string();
                assert!(message.starts_with(&name) && message.len() < 3000, "{message}");
                assert!(!message.chars().any(char::is_control), "{message}");
                Reached::Refused
            }
        };
        if let Ok(table) = dataset::parse_table(path, bytes) {
            dataset::survey(&table);
            dataset::readable(&table).ok();
            dataset::first_manifest(&table, &name, None);
        }
        reached
    });
}

/// What a session promises.
pub fn check(session: &dataset::Session) {
    let series = &session.series;
    assert!(series.time.windows(2).all(|pair| pair[1] > pair[0]), "time that does not rise");
    for values in series.joints.iter().flat_map(|joint| joint.channels.values()) {
        assert_eq!(values.len(), series.len());
        assert!(values.iter().all(|value| value.is_finite()), "a value that is not finite");
    }
}

#[test]
fn property_no_broken_csv_panics_hangs_or_swells() {
    let of_windows = run_csv().replace('\n', "\r\n");
    survive("csv", true, vec![run_csv().into_bytes(), of_windows.into_bytes()]);
}

#[test]
fn property_no_broken_mat_panics_hangs_or_swells() {
    let numbers: Vec<u8> = (0..200_i16).flat_map(i16::to_le_bytes).collect();
    let good = mat(&[
        doubles("time", &times()),
        compressed(&doubles("turn.position", &positions())),
        array(10, &[200, 1], "turn.torque", 3, &numbers),
        array(4, &[1, 4], "note", 4, &[0; 8]),
    ]);
    survive("mat", false, vec![good, super::support::recordings::run_mat()]);
}

#[cfg(feature = "mcap")]
#[test]
fn property_no_broken_mcap_panics_hangs_or_swells() {
    use mcap::Compression;
    let compressions = [None, Some(Compression::Zstd), Some(Compression::Lz4)];
    survive("mcap", false, compressions.map(super::support::mcap::good).to_vec());
}

/// From memory, and as a file: SQLite takes other ways for the two.
#[cfg(feature = "db3")]
#[test]
fn property_no_broken_db3_panics_hangs_or_swells() {
    survive("db3", false, [512, 4096].map(super::support::db3::good).to_vec());
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("run.db3");
    let corpus = [Good { path: path.clone(), bytes: super::support::db3::good(512) }];
    run("db3_file", false, &corpus, |_, bytes| {
        std::fs::write(&path, bytes).expect("a file");
        dataset::load_alone(&path).map_or(Reached::Refused, |session| {
            check(&session);
            Reached::Done
        })
    });
}

#[cfg(feature = "parquet")]
#[test]
fn property_no_broken_parquet_panics_hangs_or_swells() {
    use parquet::basic::{Compression, ZstdLevel};
    let compressions = [
        Compression::UNCOMPRESSED,
        Compression::SNAPPY,
        Compression::ZSTD(ZstdLevel::default()),
        Compression::LZ4,
        Compression::LZ4_RAW,
    ];
    survive("parquet", false, compressions.map(super::support::parquet::good).to_vec());
}

/// Files of the corpus of `tests/formats` whose name ends so; the first is one that is read as it is.
fn of_corpus(endings: &[&str]) -> Vec<Vec<u8>> {
    let files = endings.iter().flat_map(|ending| super::campaign::corpus("tests/formats/corpus", ending));
    files.map(|good| good.bytes).filter(|bytes| dataset::parse_alone(Path::new("run"), bytes).is_ok()).collect()
}

/// Broken text of every dialect, with bytes and not lines changed: some of it is UTF-16 or compressed.
#[test]
fn property_no_broken_text_of_any_dialect_panics_hangs_or_swells() {
    survive("txt", false, of_corpus(&[".csv", ".tsv", ".txt", ".dat", ".gz"]));
}

#[test]
fn property_no_broken_numpy_array_panics_hangs_or_swells() {
    survive("npy", false, of_corpus(&["structured.npy"]));
    survive("npz", false, of_corpus(&[".npz"]));
}

#[test]
fn property_no_broken_json_panics_hangs_or_swells() {
    survive("json", true, of_corpus(&[".json"]));
}

/// Structures and matrices.
#[test]
fn property_no_broken_mat_of_the_corpus_panics_hangs_or_swells() {
    survive("mat_corpus", false, of_corpus(&["struct.mat", "matrices.mat", "rows.mat", "compressed.mat"]));
}

/// All codecs, types of time and indices that pandas writes.
#[cfg(feature = "parquet")]
#[test]
fn property_no_broken_parquet_of_pandas_panics_hangs_or_swells() {
    survive("parquet_pandas", false, of_corpus(&[".parquet"]));
}

//! How much more memory commands take for a longer recording. `benches/memory` measures all of them, with `diagnose`, which takes half a
//! minute of any recording, at the full length.
#![cfg(target_os = "linux")]

#[path = "support/memory.rs"]
mod memory;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use memory::{MODEL, scenario, taken};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const BINARY: &str = env!("CARGO_BIN_EXE_lostmotion");
/// [bytes] for a sample of six joints: what half an hour at 1 kHz, 1.8 million of them, may take of 1 GB beside the 40 MB of the program
/// and its model. Read as it stands in the file, a sample with all that six drives record is 37 numbers, 296 bytes.
const MOST: f64 = (1e9 - 40e6) / 1.8e6;

/// Peak of a command for the recording in `folder`, beside which a scenario of `seconds` stands.
fn peaks(folder: &Path, seconds: u32) -> Vec<(&'static str, u64)> {
    let [plain, identified] = ["none", "identify"].map(|procedure| scenario(folder, seconds, procedure));
    let (data, out) = (folder.join("csv").join("long.csv").display().to_string(), folder.join("out"));
    let commands: [(&str, Vec<&str>, Option<&Path>); 6] = [
        ("run", vec!["run", &plain], Some(&out)),
        ("check", vec!["check", &data], None),
        ("data", vec!["data", &data], None),
        ("identify", vec!["identify", "--model", MODEL, "--data", &data], Some(&out)),
        ("replay", vec!["replay", "--model", MODEL, "--data", &data], Some(&out)),
        ("run, identify", vec!["run", &identified], Some(&out)),
    ];
    let csv = folder.join("csv");
    let mut peaks = vec![("run --csv", taken(BINARY, &["run", &plain, "--csv"], Some(&csv), Some(1)).peak)];
    // On one thread, so that the peak is the same on every machine.
    peaks.extend(commands.map(|(name, arguments, out)| (name, taken(BINARY, &arguments, out, Some(1)).peak)));
    peaks
}

fn rows(folder: &Path) -> f64 {
    let text = fs::read_to_string(folder.join("csv").join("long.csv")).expect("a recording");
    text.lines().count() as f64 - 1.0
}

#[test]
fn regress_half_an_hour_of_six_joints_fits_in_a_gigabyte() {
    let [short, long] = [(); 2].map(|()| tempfile::tempdir().expect("a temporary folder"));
    // The shorter one is long enough for an identification.
    let [of_short, of_long] = std::thread::scope(|scope| {
        let of_long = scope.spawn(|| peaks(long.path(), 120));
        [peaks(short.path(), 60), of_long.join().expect("the longer one")]
    });
    let more = rows(long.path()) - rows(short.path());
    for ((name, short), (_, long)) in of_short.iter().zip(&of_long) {
        let each = (*long as f64 - *short as f64) / more;
        println!("{name}: {:.0} MB, {:.0} MB, {each:.0} bytes a sample", *short as f64 / 1e6, *long as f64 / 1e6);
        assert!(each < MOST, "{name}: {each:.0} bytes a sample of six joints, at most {MOST:.0}");
    }
}

/// [bytes] for a cell of a table: what the largest table that is read, 1e8 cells, may take of 1 GB beside the 40 MB of the program.
const MOST_OF_A_CELL: f64 = (1e9 - 40e6) / 1e8;

/// A table of a time and random digits, compressed by gzip or as it is.
fn table(folder: &Path, columns: usize, rows: usize, compressed: bool) -> PathBuf {
    let mut text = (1..columns).fold("time".to_owned(), |names, column| names + &format!(",c{column}"));
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for row in 0..rows {
        text += &format!("\n{row}e-3");
        (1..columns).for_each(|_| text.extend([',', char::from(random.random_range(b'0'..=b'9'))]));
    }
    text.push('\n');
    let file = folder.join(format!("{columns}_{rows}.csv"));
    let mut out = fs::File::create(&file).expect("a file");
    if compressed {
        GzEncoder::new(out, Compression::fast()).write_all(text.as_bytes()).expect("written");
    } else {
        out.write_all(text.as_bytes()).expect("written");
    }
    file
}

#[test]
fn regress_a_table_at_the_limit_of_cells_fits_in_a_gigabyte() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let peak = |columns: usize, rows: usize, compressed: bool| {
        let file = table(folder.path(), columns, rows, compressed).display().to_string();
        taken(BINARY, &["data", &file], None, Some(1)).peak as f64
    };
    // Many columns of few rows, whose room would come from the heap and leave holes in it as they grow, and few columns of many.
    for (columns, rows) in [(9000, 1100), (300, 33_300), (10, 999_000)] {
        for compressed in [false, true] {
            let more = peak(columns, rows, compressed) - peak(columns, rows / 10, compressed);
            let each = more / (columns * (rows - rows / 10)) as f64;
            println!("{columns} columns, compressed {compressed}: {each:.1} bytes a cell");
            assert!(each < MOST_OF_A_CELL, "{columns} columns: {each:.1} bytes a cell, at most {MOST_OF_A_CELL:.1}");
        }
    }
}

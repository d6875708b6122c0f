//! How much more memory commands take for a longer recording. `benches/memory` measures all of them, with `diagnose`, which takes half a
//! minute of any recording, at the full length.
#![cfg(target_os = "linux")]

#[path = "support/memory.rs"]
mod memory;

use std::fs;
use std::path::Path;

use memory::{MODEL, scenario, taken};

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

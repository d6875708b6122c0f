//! Peak memory and time of every command for half an hour of six joints at 1 kHz. Takes some minutes, and 4 GB of disk.

#[path = "../tests/support/memory.rs"]
mod memory;

use std::path::Path;

use memory::{MODEL, scenario, taken};

const BINARY: &str = env!("CARGO_BIN_EXE_lostmotion");
/// [s] Length of the recording.
const LENGTH: u32 = 1800;

fn main() {
    if !cfg!(target_os = "linux") {
        println!("the peak is read from /proc, which Linux alone has");
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [plain, identified, diagnosed] =
        ["none", "identify", "diagnose"].map(|procedure| scenario(folder.path(), LENGTH, procedure));
    let [csv, before, out] = ["csv", "before", "out"].map(|name| folder.path().join(name));
    let [data, reference] = [&csv, &before].map(|folder| folder.join("long.csv").display().to_string());
    let of = |verb: &'static str| vec![verb, "--model", MODEL, "--data", &data];
    let commands: [(&str, Vec<&str>, Option<&Path>); 11] = [
        ("run --csv", vec!["run", &plain, "--csv"], Some(&csv)),
        // Another recording of the same machine: the same one twice is refused.
        ("run --csv, again", vec!["run", &plain, "--csv", "--set", "session[1].seed=2"], Some(&before)),
        ("run", vec!["run", &plain], Some(&out)),
        ("run, identify", vec!["run", &identified], Some(&out)),
        ("run, diagnose", vec!["run", &diagnosed], Some(&out)),
        ("check", vec!["check", &data], None),
        ("data", vec!["data", &data], None),
        ("identify", of("identify"), Some(&out)),
        ("replay", of("replay"), Some(&out)),
        ("diagnose", of("diagnose"), Some(&out)),
        ("diagnose --reference", [of("diagnose"), vec!["--reference", &reference]].concat(), Some(&out)),
    ];
    println!("{:<22} {:>9} {:>8}", "command", "peak [MB]", "time [s]");
    for (name, arguments, out) in commands {
        let taken = taken(BINARY, &arguments, out, None);
        println!("{name:<22} {:>9.0} {:>8.1}", taken.peak as f64 / 1e6, taken.time.as_secs_f64());
    }
}

//! Peak memory and time of every command for half an hour of six joints at 1 kHz. Takes some minutes, and 3 GB of disk.

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
    let (csv, out) = (folder.path().join("csv"), folder.path().join("out"));
    let data = csv.join("long.csv").display().to_string();
    let of = |verb: &'static str| vec![verb, "--model", MODEL, "--data", &data];
    let commands: [(&str, Vec<&str>, Option<&Path>); 10] = [
        ("run --csv", vec!["run", &plain, "--csv"], Some(&csv)),
        ("run", vec!["run", &plain], Some(&out)),
        ("run, identify", vec!["run", &identified], Some(&out)),
        ("run, diagnose", vec!["run", &diagnosed], Some(&out)),
        ("check", vec!["check", &data], None),
        ("data", vec!["data", &data], None),
        ("identify", of("identify"), Some(&out)),
        ("replay", of("replay"), Some(&out)),
        ("diagnose", of("diagnose"), Some(&out)),
        ("diagnose --reference", [of("diagnose"), vec!["--reference", &data]].concat(), Some(&out)),
    ];
    println!("{:<22} {:>9} {:>8}", "command", "peak [MB]", "time [s]");
    for (name, arguments, out) in commands {
        let taken = taken(BINARY, &arguments, out, None);
        println!("{name:<22} {:>9.0} {:>8.1}", taken.peak as f64 / 1e6, taken.time.as_secs_f64());
    }
}

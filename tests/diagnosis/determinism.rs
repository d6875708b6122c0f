//! The same input gives the same files, byte by byte: in every process, and with any number of worker threads.
//! Left out is `trace.rrd`, whose chunks the viewer's format numbers by the clock.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A scenario of the project, its staircases cut short: fewer stairs, each for a shorter time.
fn shortened(name: &str, folder: &Path) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let own = root.join("scenarios").join(name);
    let text = fs::read_to_string(own.join("scenario.toml")).unwrap();
    let robot = text.lines().find_map(|line| line.strip_prefix("robot = \"")?.strip_suffix('"')).expect("a robot");
    let robot = own.join(robot).canonicalize().unwrap();
    let mut short = String::new();
    for line in text.lines() {
        let key = line.split('=').next().unwrap_or_default().trim();
        match key {
            "robot" => short += &format!("robot = {:?}\n", robot.display().to_string()),
            "increment_deg" => short += "increment_deg = 1.9\n",
            "steady_time" => short += "steady_time = 0.6\n",
            // What a short run can reach is not what the scenario expects.
            _ if line.starts_with("[expect") => break,
            _ => short += &format!("{line}\n"),
        }
    }
    let file = folder.join("scenario.toml");
    fs::write(&file, short).unwrap();
    file.to_str().unwrap().to_owned()
}

/// Everything that a run writes: standard output, and the files by name.
fn run(scenario: &str, engine: &str, threads: usize) -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = Command::new(env!("CARGO_BIN_EXE_lostmotion"))
        .args(["run", scenario, "--json", "--csv", "--quiet", "--out", out.to_str().unwrap()])
        .args(["--set", &format!("plant.engine={engine}")])
        .env("RAYON_NUM_THREADS", threads.to_string())
        .output()
        .unwrap();
    // 3: done, with warnings, which a short run may have.
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(matches!(output.status.code(), Some(0 | 3)), "{error}");
    let mut written: BTreeMap<String, Vec<u8>> = fs::read_dir(&out)
        .unwrap()
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.file_name() != "trace.rrd" && entry.path().is_file())
        .map(|entry| (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap()))
        .collect();
    written.insert("standard output".to_owned(), output.stdout);
    written
}

#[test]
fn property_results_do_not_depend_on_process_or_threads() {
    let cases: [(&str, &str, &[usize]); 2] =
        [("02_name_the_cause", "rapier", &[5]), ("01_identify_scara", "reduced", &[1, 2, 5])];
    for (name, engine, others) in cases {
        let folder = tempfile::tempdir().unwrap();
        let scenario = shortened(name, folder.path());
        let first = run(&scenario, engine, 1);
        assert!(first.len() >= 5 && first.values().all(|bytes| !bytes.is_empty()), "{:?}", first.keys());
        assert!(first["report.json"].len() > 1000 && first.keys().any(|file| file.ends_with(".csv")));
        for &threads in others {
            let again = run(&scenario, engine, threads);
            let differ: Vec<_> = first.keys().filter(|&file| again.get(file) != first.get(file)).collect();
            assert!(differ.is_empty() && again.len() == first.len(), "{name}, {threads} threads: {differ:?} differ");
        }
    }
}

//! A folder with a small machine, a scenario and a recording, and the program run in it.

use std::collections::BTreeMap;
use std::fs;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::process::{Child, Output, Stdio};
use std::time::{Duration, Instant};

use super::support::Folder;
pub use super::support::{PLAIN_MODEL as MODEL, refused};

pub const SCENARIO: &str = r#"schema = "lostmotion/scenario/1"
name = "to_and_fro"
robot = "model.toml"
control_period = 0.001

[[session]]
name = "first"
kind = "waypoints"
rest = 0.1
[session.joints.turn]
positions_deg = [5, 0]
speed_deg = 40
acceleration_deg = 400

[[session]]
name = "second"
kind = "rest"
duration = 0.2

[[session]]
name = "third"
kind = "rest"
duration = 0.2

[controller]
law = "pi"

[controller.joints.turn]
proportional = 2.0
integral = 20.0
"#;

/// The files of a result of `run --csv` that a build without the viewer's format writes.
pub const RESULTS: [&str; 5] = ["report.json", "report.html", "first.csv", "second.csv", "third.csv"];

/// A folder with one good file of every kind.
pub struct Files(Folder);

impl Deref for Files {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

impl Files {
    pub fn new() -> Self {
        let files = Self(Folder::plain());
        files.put("scenario.toml", SCENARIO);
        let rows: String = (0..400)
            .map(|row| 0.001 * f64::from(row))
            .map(|time| format!("{time},{},{}\n", (20.0 * time).sin(), -(20.0 * time).sin()))
            .collect();
        files.put("run.csv", format!("time,turn.position,turn.torque\n{rows}"));
        files
    }

    pub fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Starts the program and leaves it running.
    pub fn start(&self, arguments: &[&str]) -> Child {
        self.command(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program runs")
    }

    /// Replays the recording into a folder: a command that writes `report.json` and `report.html`.
    pub fn replay(&self, out: &str) -> Output {
        self.lostmotion(&["replay", "--quiet", "--model", "model.toml", "--data", "run.csv", "--out", out])
    }

    /// Runs the scenario into a folder: a command that also writes a recording of each session.
    pub fn run(&self, out: &str, seed: &str) -> Output {
        self.lostmotion(&["run", "scenario.toml", "--quiet", "--csv", "--seed", seed, "--out", out])
    }

    /// Path and content of every file and link below a folder, the program's own folder left out; a link's content is where it leads.
    pub fn snapshot(&self, folder: &str) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut all = BTreeMap::new();
        collect(&self.path(folder), &mut all);
        all
    }

    /// Names of the entries of a folder in it, sorted.
    pub fn names(&self, folder: &str) -> Vec<String> {
        super::support::names(&self.path(folder))
    }
}

fn collect(folder: &Path, all: &mut BTreeMap<PathBuf, Vec<u8>>) {
    for entry in fs::read_dir(folder).expect("the folder") {
        let path = entry.expect("an entry").path();
        let kind = path.symlink_metadata().expect("an entry").file_type();
        if kind.is_symlink() {
            let target = fs::read_link(&path).expect("a link");
            all.insert(path, target.to_string_lossy().into_owned().into_bytes());
        } else if kind.is_file() {
            let content = fs::read(&path).expect("a file");
            all.insert(path, content);
        } else if kind.is_dir() && path.file_name().is_some_and(|name| name != ".lostmotion") {
            collect(&path, all);
        }
    }
}

/// Asserts exit code 0 (or 3, done with warnings).
#[track_caller]
pub fn done(output: &Output) {
    let code = output.status.code();
    assert!(matches!(code, Some(0 | 3)), "{code:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Waits until something holds, without a pause, or fails after two minutes.
#[track_caller]
pub fn wait_for(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < Duration::from_secs(120), "waited for {what}");
        std::thread::yield_now();
    }
}

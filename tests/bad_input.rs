//! Broken input of every kind: the program says what is wrong where, ends with exit code 2, leaves nothing behind, and never panics.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use lostmotion::dataset;
use lostmotion::robot::Model;
use lostmotion::scenario::Scenario;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tempfile::TempDir;

const URDF: &str = r#"<?xml version="1.0"?>
<robot name="turntable">
  <link name="base"/>
  <link name="table">
    <inertial><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.03"/></inertial>
  </link>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="table"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="5" velocity="4"/>
  </joint>
</robot>
"#;

const MODEL: &str = r#"schema = "lostmotion/model/1"
name = "turntable"
urdf = "robot.urdf"

[joints.turn]
gear_ratio = 5.0
rotor_inertia = 0.0008
gear_stiffness = 3000.0
gear_damping = 2.0
backlash = 0.008

[joints.turn.motor]
torque_constant = 0.023

[joints.turn.friction]
coulomb = 0.3
viscous = 0.4
"#;

const MANIFEST: &str = r#"schema = "lostmotion/dataset/1"
file = "raw.csv"
[time]
column = "t"
[joints.turn]
position = { column = "angle", unit = "deg" }
torque = { column = "load" }
"#;

const SCENARIO: &str = r#"schema = "lostmotion/scenario/1"
name = "to_and_fro"
robot = "model.toml"
control_period = 0.001

[reference]
kind = "waypoints"

[reference.joints.turn]
positions_deg = [5, 0]
speed_deg = 20
acceleration_deg = 100

[controller]
law = "pi"

[controller.joints.turn]
proportional = 2.0
integral = 20.0
"#;

/// A folder with one good file of every kind.
struct Files(TempDir);

impl Files {
    fn new() -> Self {
        let files = Self(tempfile::tempdir().expect("a temporary folder"));
        files.put("robot.urdf", URDF);
        files.put("model.toml", MODEL);
        files.put("manifest.toml", MANIFEST);
        files.put("scenario.toml", SCENARIO);
        files.put("raw.csv", raw_csv());
        files.put("run.csv", run_csv());
        files
            .put("run.mat", mat(&[("time", &times()), ("turn.position", &positions()), ("turn.torque", &positions())]));
        files
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        fs::write(self.path(name), content).expect("a file in a temporary folder");
        self.path(name)
    }

    /// Replays `data`, which reads the model, its URDF and the data, and would write results.
    fn replay(&self, data: &str) -> Output {
        self.lostmotion(&["replay", "--quiet", "--out", "out", "--model", "model.toml", "--data", data])
    }

    fn lostmotion(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lostmotion"));
        command
            .args(arguments)
            .current_dir(self.0.path())
            .env_remove("LOSTMOTION_DATA")
            .output()
            .expect("the program runs")
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("the folder");
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

fn times() -> Vec<f64> {
    (0..200).map(|row| f64::from(row) * 0.001).collect()
}

fn positions() -> Vec<f64> {
    times().iter().map(|time| (20.0 * time).sin()).collect()
}

fn csv(header: &str) -> String {
    let rows =
        times().into_iter().zip(positions()).map(|(time, position)| format!("{time},{position},{}\n", -position));
    format!("{header}\n{}", rows.collect::<String>())
}

fn raw_csv() -> String {
    csv("t,angle,load")
}

fn run_csv() -> String {
    csv("time,turn.position,turn.torque")
}

/// A MATLAB 5 file of columns of doubles, not compressed.
fn mat(columns: &[(&str, &[f64])]) -> Vec<u8> {
    let mut bytes = vec![b' '; 116];
    bytes[..19].copy_from_slice(b"MATLAB 5.0 MAT-file");
    bytes.extend([0; 8]);
    bytes.extend([0x00, 0x01, b'I', b'M']);
    let element = |kind: u32, content: &[u8]| {
        let mut element = [kind.to_le_bytes(), (content.len() as u32).to_le_bytes()].concat();
        element.extend(content);
        element.resize(element.len().next_multiple_of(8), 0);
        element
    };
    for (name, values) in columns {
        let flags: Vec<u8> = [6_u32, 0].into_iter().flat_map(u32::to_le_bytes).collect();
        let size: Vec<u8> = [values.len() as i32, 1].into_iter().flat_map(i32::to_le_bytes).collect();
        let numbers: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let parts = [element(6, &flags), element(5, &size), element(1, name.as_bytes()), element(9, &numbers)];
        bytes.extend(element(14, &parts.concat()));
    }
    bytes
}

/// Asserts exit code 2, these parts in the one message, and nothing on standard output.
#[track_caller]
fn refused(output: &Output, parts: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.starts_with("error: ") && !message.contains("panicked"), "{message}");
    for part in parts {
        assert!(message.contains(part), "`{part}` not in: {message}");
    }
    assert!(output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stdout));
}

#[test]
fn property_good_files_pass() {
    let files = Files::new();
    for data in ["run.csv", "manifest.toml", "run.mat"] {
        let output = files.replay(data);
        assert!(output.status.success(), "{data}: {}", String::from_utf8_lossy(&output.stderr));
        assert!(files.path("out/report.json").is_file());
    }
    let output = files.lostmotion(&["run", "scenario.toml", "--quiet", "--out", "run"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(files.path("run/report.json").is_file());
    let output = files.lostmotion(&[
        "check",
        "model.toml",
        "scenario.toml",
        "robot.urdf",
        "manifest.toml",
        "run.csv",
        "run.mat",
    ]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn property_broken_text_is_refused_by_place_and_expectation() {
    // File, what is replaced by what, and what the message has to hold.
    let cases: &[(&str, &str, &str, &[&str])] = &[
        (
            "model.toml",
            "gear_ratio = 5.0",
            "gear_ratio = -5.0",
            &["model.toml:6", "joints.turn.gear_ratio", "-5", "> 0"],
        ),
        ("model.toml", "gear_ratio = 5.0", "gear_ratio = nan", &["model.toml:6", "joints.turn.gear_ratio", "nan"]),
        (
            "model.toml",
            "gear_ratio = 5.0",
            "gear_ratio = 'five'",
            &["model.toml:6", "joints.turn.gear_ratio", "five", "number"],
        ),
        ("model.toml", "gear_ratio = 5.0", "", &["model.toml", "joints.turn.gear_ratio", "missing"]),
        ("model.toml", "gear_ratio", "gear_ration", &["model.toml", "joints.turn.gear_ratio"]),
        ("model.toml", "viscous", "viscious", &["model.toml", "joints.turn.friction.viscious", "viscous"]),
        ("model.toml", "torque_constant = 0.023", "torque_constant = 0", &["model.toml:13", "torque_constant", "> 0"]),
        ("model.toml", "joints.turn", "joints.spin", &["model.toml", "spin", "turn"]),
        ("model.toml", "model/1", "model/9", &["model.toml:1", "schema", "lostmotion/model/1"]),
        ("model.toml", "robot.urdf", "gone.urdf", &["model.toml:3", "urdf", "gone.urdf"]),
        ("model.toml", "name = \"turntable\"", "name = \"turntable", &["model.toml:2", "TOML"]),
        ("robot.urdf", "mass value=\"2\"", "mass value=\"-2\"", &["robot.urdf", "-2"]),
        ("robot.urdf", "izz=\"0.03\"", "izz=\"0.3\"", &["robot.urdf", "table"]),
        ("robot.urdf", "child link=\"table\"", "child link=\"chair\"", &["robot.urdf", "chair"]),
        ("robot.urdf", "</robot>", "", &["robot.urdf"]),
        (
            "manifest.toml",
            "\"angle\"",
            "\"angel\"",
            &["manifest.toml:6", "joints.turn.position.column", "angel", "angle"],
        ),
        (
            "manifest.toml",
            "unit = \"deg\"",
            "unit = \"rpm\"",
            &["manifest.toml:6", "joints.turn.position.unit", "rpm", "deg"],
        ),
        ("manifest.toml", "joints.turn", "joints.spin", &["manifest.toml:5", "spin", "turn"]),
        ("manifest.toml", "raw.csv", "gone.csv", &["manifest.toml:2", "file", "gone.csv", "LOSTMOTION_DATA"]),
        ("manifest.toml", "[time]\ncolumn = \"t\"", "", &["manifest.toml", "time"]),
        ("raw.csv", "t,angle,load", "t,angle", &["raw.csv", "row 1", "fields", "3"]),
        ("raw.csv", "\n0.003,", "\n0.002,", &["raw.csv", "row 4", "t = 0.002", "repeated"]),
        ("raw.csv", "\n0.003,", "\n0.003,x", &["raw.csv", "row 4", "angle = x", "number"]),
        ("raw.csv", "\n0.003,", "\n-inf,", &["raw.csv", "row 4", "t = -inf", "finite"]),
    ];
    for (name, from, to, parts) in cases {
        let files = Files::new();
        let text = fs::read_to_string(files.path(name)).expect("text");
        let broken = text.replace(from, to);
        assert_ne!(text, broken, "{from} is not in {name}");
        files.put(name, broken);
        let before = files.names();
        refused(&files.replay("manifest.toml"), parts);
        assert_eq!(files.names(), before, "nothing is left behind by {name}: {from} → {to}");
    }
}

#[test]
fn property_a_diverging_simulation_is_refused_and_leaves_nothing() {
    let files = Files::new();
    let before = files.names();
    // 2 J / period = 40 N·m·s/rad is the stiffest controller that the rotor bears.
    let gain = "controller.joints.turn.proportional=2000";
    let output = files.lostmotion(&["run", "scenario.toml", "--quiet", "--out", "out", "--csv", "--set", gain]);
    refused(&output, &["diverged", "t = ", "velocity of turn"]);
    assert_eq!(files.names(), before);
}

#[test]
fn property_missing_and_foreign_files_are_refused() {
    let files = Files::new();
    files.put("data.xlsx", "not a format of ours");
    refused(&files.replay("gone.csv"), &["gone.csv"]);
    refused(&files.replay("data.xlsx"), &["data.xlsx", "format = xlsx", ".csv", ".mat"]);
    refused(&files.replay("."), &["."]);
    refused(&files.lostmotion(&["data", "gone.mat"]), &["gone.mat"]);
    refused(&files.lostmotion(&["check", "gone.toml"]), &["gone.toml"]);
    refused(&files.replay("model.toml"), &["model.toml:1", "schema", "lostmotion/dataset/1"]);
    let swapped = ["replay", "--quiet", "--out", "out", "--model", "manifest.toml", "--data", "run.csv"];
    refused(&files.lostmotion(&swapped), &["manifest.toml:1", "schema", "lostmotion/model/1"]);
}

/// One to four random edits: a byte changed, a piece cut out, a piece repeated, or the end cut off.
fn mutate(rng: &mut ChaCha8Rng, good: &[u8]) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..rng.random_range(1..5) {
        if bytes.is_empty() {
            break;
        }
        let at = rng.random_range(0..bytes.len());
        let to = (at + rng.random_range(1..40)).min(bytes.len());
        match rng.random_range(0..4) {
            0 => bytes[at] = rng.random(),
            1 => drop(bytes.drain(at..to)),
            2 => {
                let piece = bytes[at..to].to_vec();
                bytes.splice(at..at, piece);
            }
            _ => bytes.truncate(at),
        }
    }
    bytes
}

/// Reads many broken versions of a file: a panic fails the test. Returns how many were refused.
fn survive(name: &str, seed: u64, rounds: usize, read: impl Fn(&Path) -> bool) -> usize {
    let files = Files::new();
    let good = fs::read(files.path(name)).expect("bytes");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..rounds).filter(|_| !read(&files.put(name, mutate(&mut rng, &good)))).count()
}

#[test]
fn property_no_mutated_file_makes_a_reader_panic() {
    const ROUNDS: usize = 600;
    let joints = [("turn".to_owned(), lostmotion::units::JointKind::Revolute)];
    let data = |path: &Path| {
        let loaded = dataset::load(path, &joints);
        if let Ok(session) = &loaded {
            let series = &session.series;
            assert!(series.time.windows(2).all(|pair| pair[1] > pair[0]));
            assert!(series.joints[0].channels.values().all(|values| values.len() == series.len()));
            assert!(series.joints[0].channels.values().flatten().all(|value| value.is_finite()));
        }
        dataset::load_alone(path).ok();
        dataset::read_table(path).map(|table| dataset::survey(&table) + &dataset::first_manifest(&table)).ok();
        loaded.is_ok()
    };
    let model = |path: &Path| Model::load(&path.with_file_name("model.toml")).is_ok();
    for (name, seed, refused) in [
        ("run.csv", 1, survive("run.csv", 1, ROUNDS, data)),
        ("run.mat", 2, survive("run.mat", 2, ROUNDS, data)),
        ("manifest.toml", 3, survive("manifest.toml", 3, ROUNDS, data)),
        ("model.toml", 4, survive("model.toml", 4, ROUNDS, model)),
        ("robot.urdf", 5, survive("robot.urdf", 5, ROUNDS, model)),
        ("scenario.toml", 6, survive("scenario.toml", 6, ROUNDS, |path| Scenario::load(path, &[]).is_ok())),
    ] {
        // Most of these edits break something; that nearly none is refused would mean that nothing is checked.
        assert!(refused > ROUNDS / 10, "{name}, seed {seed}: {refused} of {ROUNDS} refused");
    }
}

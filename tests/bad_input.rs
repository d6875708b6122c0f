//! Broken input of every kind: the program says what is wrong where, ends with exit code 2, leaves nothing behind, and never panics.

#[path = "support/files/mod.rs"]
mod support;

use std::fs;
use std::ops::Deref;
use std::process::Output;

use support::recordings::{csv, run_csv, run_mat};
use support::{Folder, refused};

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
struct Files(Folder);

impl Deref for Files {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

impl Files {
    fn new() -> Self {
        let files = Self(Folder::plain());
        files.put("manifest.toml", MANIFEST);
        files.put("scenario.toml", SCENARIO);
        files.put("raw.csv", csv("t,angle,load"));
        files.put("run.csv", run_csv());
        files.put("run.mat", run_mat());
        files
    }

    /// Replays `data`, which reads the model, its URDF and the data, and would write results.
    fn replay(&self, data: &str) -> Output {
        self.lostmotion(&["replay", "--quiet", "--out", "out", "--model", "model.toml", "--data", data])
    }
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
            &["model.toml:6", "joints.turn.gear_ratio", "-5", "from 1e-4"],
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
        (
            "model.toml",
            "torque_constant = 0.023",
            "torque_constant = 0",
            &["model.toml:13", "torque_constant", "from 1e-9"],
        ),
        ("model.toml", "joints.turn", "joints.spin", &["model.toml", "spin", "turn"]),
        ("model.toml", "model/1", "model/9", &["model.toml:1", "schema", "lostmotion/model/1"]),
        ("model.toml", "robot.urdf", "gone.urdf", &["model.toml:3", "urdf", "gone.urdf"]),
        ("model.toml", "name = \"turntable\"", "name = \"turntable", &["model.toml:2", "TOML"]),
        ("robot.urdf", "mass value=\"2\"", "mass value=\"-2\"", &["robot.urdf", "-2"]),
        ("robot.urdf", "izz=\"0.03\"", "izz=\"0,03\"", &["robot.urdf", "table"]),
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
    refused(&files.replay("data.xlsx"), &["data.xlsx:1: header = not a format of ours", "column names"]);
    refused(&files.replay("."), &["."]);
    refused(&files.lostmotion(&["data", "gone.mat"]), &["gone.mat"]);
    refused(&files.lostmotion(&["check", "gone.toml"]), &["gone.toml"]);
    refused(&files.replay("model.toml"), &["model.toml:1", "schema", "lostmotion/dataset/1"]);
    let swapped = ["replay", "--quiet", "--out", "out", "--model", "manifest.toml", "--data", "run.csv"];
    refused(&files.lostmotion(&swapped), &["manifest.toml:1", "schema", "lostmotion/model/1"]);
}

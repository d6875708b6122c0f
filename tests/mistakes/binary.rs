//! Mistakes as a user meets them: exit code, report, text.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use lostmotion::dataset::write_csv;
use lostmotion::units::JointKind;

use super::hidden::Order;
use super::machines;
use super::planted;

fn lostmotion(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lostmotion")).args(arguments).output().expect("the binary runs")
}

/// Files of a planar arm whose first current is recorded with the wrong sign.
fn turned(folder: &Path) -> (String, String) {
    with_mistake(folder, "current turned")
}

/// Files of a planar arm with a mistake in its first joint.
fn with_mistake(folder: &Path, mistake: &str) -> (String, String) {
    let set = machines::planar(&Order::nothing(super::SEED + 40));
    let (model, sessions) = planted::plant(mistake, &set.model, &set.sessions, 0).expect("a mistake");
    fs::write(folder.join("robot.urdf"), &model.urdf_text).expect("the robot");
    let file = folder.join("model.toml");
    fs::write(&file, model.to_toml(Path::new("robot.urdf"))).expect("the model");
    let data = folder.join("fast.csv");
    write_csv(&data, &sessions[0], &[JointKind::Revolute; 2]).expect("a recording");
    (file.to_string_lossy().into_owned(), data.to_string_lossy().into_owned())
}

pub fn a_turned_current_ends_a_diagnosis_with_3_and_no_effect() {
    let folder = tempfile::tempdir().expect("a folder");
    let (model, data) = turned(folder.path());
    let out = folder.path().join("out");
    let out = out.to_str().expect("a path");
    let output = lostmotion(&["diagnose", "--model", &model, "--data", &data, "--out", out]);
    let (text, warnings) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(3), "{text}\n{warnings}");
    for part in ["sign_of_current", "joint1", "scale = -1", "no effect is named"] {
        assert!(text.contains(part), "{part} is missing in\n{text}");
    }
    assert!(warnings.contains("warning: sign_of_current"), "{warnings}");
    let report = fs::read_to_string(Path::new(out).join("report.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["verdict"], "mistake_suspected");
    assert_eq!(report["effects"], serde_json::json!([]));
    let mistake = &report["mistakes"][0];
    assert_eq!(mistake["mistake"], "sign_of_current");
    assert_eq!(mistake["joints"], serde_json::json!(["joint1"]));
    assert!(mistake["remedy"].as_str().is_some_and(|remedy| remedy.contains("scale = -1")), "{mistake}");
    let page = fs::read_to_string(Path::new(out).join("report.html")).expect("a page");
    assert!(page.contains("sign_of_current") && page.contains("What looks mistaken"));
}

/// The other joint is judged, and nothing is said of the one whose current is dead.
pub fn a_dead_current_is_said_and_ends_a_diagnosis_with_3() {
    for mistake in ["current of noise alone", "current of white noise"] {
        let folder = tempfile::tempdir().expect("a folder");
        let (model, data) = with_mistake(folder.path(), mistake);
        let out = folder.path().join("out");
        let out = out.to_str().expect("a path");
        let output = lostmotion(&["diagnose", "--model", &model, "--data", &data, "--out", out]);
        let (text, warnings) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert_eq!(output.status.code(), Some(3), "{mistake}: {text}\n{warnings}");
        assert!(!text.contains("the nominal model explains the data") && text.contains("Not judged: joint1"), "{text}");
        assert!(warnings.contains("warning: dead_channel suspected on joint1"), "{mistake}: {warnings}");
        let report = fs::read_to_string(Path::new(out).join("report.json")).expect("a report");
        let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
        assert_eq!(report["dead_channels"][0]["joints"], serde_json::json!(["joint1"]), "{mistake}");
        assert!(report["baseline"].get("joint1").is_none() && report["baseline"].get("joint2").is_some(), "{mistake}");
    }
}

/// A gear too stiff to be simulated: the diagnosis is complete and written, the replay is a warning.
pub fn a_replay_that_fails_leaves_the_diagnosis() {
    let folder = tempfile::tempdir().expect("a folder");
    let (model, data) = turned(folder.path());
    let text = fs::read_to_string(&model).expect("the model");
    let stiff = |line: &str| {
        if line.starts_with("gear_stiffness") { "gear_stiffness = 3e9".to_owned() } else { line.to_owned() }
    };
    fs::write(&model, text.lines().map(stiff).collect::<Vec<_>>().join("\n")).expect("the model");
    let set = machines::planar(&Order::nothing(super::SEED + 40));
    write_csv(Path::new(&data), &set.sessions[0], &[JointKind::Revolute; 2]).expect("a recording");
    let out = folder.path().join("out");
    let out = out.to_str().expect("a path");
    let output = lostmotion(&["diagnose", "--model", &model, "--data", &data, "--out", out]);
    let warnings = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{warnings}");
    assert!(warnings.contains("replay"), "{warnings}");
    let report = fs::read_to_string(Path::new(out).join("report.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert!(report["fit"].as_array().is_some_and(|fit| !fit.is_empty()), "{report}");
}

pub fn a_replay_warns_of_a_turned_current_and_ends_with_3() {
    let folder = tempfile::tempdir().expect("a folder");
    let (model, data) = turned(folder.path());
    let out = folder.path().join("out");
    let output = lostmotion(&["replay", "--model", &model, "--data", &data, "--out", out.to_str().expect("a path")]);
    let warnings = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{warnings}");
    assert!(warnings.contains("warning: sign_of_current"), "{warnings}");
}

//! The truth of a simulated machine reaches neither a procedure nor what a procedure writes; what a scenario expects is held to figures.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use lostmotion::scenario::Scenario;
use serde_json::Value;

/// Truths that no estimate hits to nine digits: keys of the model file of `02_name_the_cause`, and values. The tilt pulls at either joint
/// with less than its friction: under a greater one no friction law fits, and nothing is identified.
const ABSURD: [(&str, f64); 14] = [
    ("joints.joint1.backlash", 0.008_117_113_7),
    ("joints.joint1.friction.coulomb", 0.277_713_171),
    ("joints.joint1.friction.breakaway", 0.456_663_171),
    ("joints.joint1.friction.stribeck_velocity", 0.025_911_173_1),
    ("joints.joint1.friction.viscous", 0.512_223_171),
    ("joints.joint1.friction.link_share", 0.311_173_171),
    ("joints.joint2.backlash", 0.006_117_313_7),
    ("joints.joint2.friction.coulomb", 0.147_713_171),
    ("joints.joint2.friction.breakaway", 0.306_663_171),
    ("joints.joint2.friction.stribeck_velocity", 0.030_911_173_1),
    ("joints.joint2.friction.viscous", 1.912_223_171),
    ("joints.joint2.friction.link_share", 0.321_173_171),
    ("effects[1].tilt", 0.002_117_313_7),
    ("effects[1].azimuth", 0.911_173_171),
];

fn demonstration() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/02_name_the_cause/scenario.toml")
}

/// The demonstration's text without what it expects.
fn text() -> String {
    let text = std::fs::read_to_string(demonstration()).expect("the scenario");
    text.split("[expect]").next().expect("a beginning").to_owned()
}

fn run(scenario: &Path, out: &Path, assignments: &[String]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lostmotion"));
    command.args(["run", "--quiet", "--out"]).arg(out).arg(scenario);
    for assignment in assignments {
        command.args(["--set", assignment]);
    }
    command.output().expect("the program starts")
}

/// All numbers of a report but those under the key `true`.
fn of_json(value: &Value, found: &mut Vec<f64>) {
    match value {
        Value::Number(number) => found.extend(number.as_f64()),
        Value::Array(values) => values.iter().for_each(|value| of_json(value, found)),
        Value::Object(entries) => {
            entries.iter().filter(|(key, _)| *key != "true").for_each(|(_, value)| of_json(value, found));
        }
        _ => {}
    }
}

/// All numbers of a text.
fn of_text(text: &str) -> Vec<f64> {
    let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || ".-+".contains(c)));
    words.filter_map(|word| word.parse().ok()).collect()
}

/// The planted truths among numbers.
fn planted(numbers: &[f64]) -> Vec<&'static str> {
    let key = |number: &f64| ABSURD.iter().find(|(_, truth)| (number / truth - 1.0).abs() < 1e-9).map(|(key, _)| *key);
    numbers.iter().filter_map(key).collect()
}

/// The truths that a folder of results holds, each with its file. Only `report.json` may hold them, under the key `true`.
fn leaks(folder: &Path) -> Vec<(String, &'static str)> {
    let mut leaks = Vec::new();
    for (name, fewest) in [("report.json", 50), ("model.toml", 20), ("report.html", 50), ("scara.urdf", 20)] {
        let text = std::fs::read_to_string(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let numbers = if name == "report.json" {
            let mut found = Vec::new();
            of_json(&serde_json::from_str(&text).expect("JSON"), &mut found);
            found
        } else {
            of_text(&text)
        };
        assert!(numbers.len() > fewest, "{name}: {} numbers", numbers.len());
        leaks.extend(planted(&numbers).into_iter().map(|key| (name.to_owned(), key)));
    }
    leaks
}

#[test]
fn regress_no_truth_reaches_what_a_run_writes() {
    let folder = tempfile::tempdir().expect("a folder");
    // One joint moves through ten speeds, so that the other is not identified: what is written of it must not be the truth either.
    let scenario = folder.path().join("scenario.toml");
    let robot = demonstration().with_file_name("model.toml");
    let text = text().replace("\"model.toml\"", &format!("{robot:?}"));
    let text = text.replace("first_deg = 0.5", "first_deg = 1.0").replace("increment_deg = 0.5", "increment_deg = 1.0");
    let (head, controller) = text.split_once("[controller]").expect("a controller");
    let [head, _, second, sweep, _] = head.split("[[session]]").collect::<Vec<_>>()[..] else {
        panic!("four sessions: {text}")
    };
    let text = format!("{head}[[session]]{second}[[session]]{sweep}[controller]{controller}");
    std::fs::write(&scenario, text).expect("written");
    let truths: Vec<String> = ABSURD.iter().map(|(key, value)| format!("model.{key}={value}")).collect();
    for procedure in ["identify", "diagnose"] {
        let out = folder.path().join(procedure);
        let assignments = [truths.clone(), vec![format!("procedure={procedure}")]].concat();
        let output = run(&scenario, &out, &assignments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 3)), "{procedure}: {stderr}");
        assert_eq!(leaks(&out), [], "{procedure}");

        // Each truth is found where it does leak: in place of a number of the model or of the report.
        let [model, report] = ["model.toml", "report.json"].map(|name| out.join(name));
        let good = [&model, &report].map(|file| std::fs::read_to_string(file).expect("text"));
        for (key, truth) in ABSURD {
            std::fs::write(&model, good[0].replacen("0.00083", &format!("{truth}"), 1)).expect("written");
            std::fs::write(&report, good[1].replacen('{', &format!("{{\"leak\": {truth},"), 1)).expect("written");
            let found = ["report.json", "model.toml"].map(|name| (name.to_owned(), key));
            assert_eq!(leaks(&out), found, "{procedure}");
        }
    }
}

#[test]
fn regress_procedures_are_given_a_model_without_friction_gap_and_effects() {
    let scenario = Scenario::load(&demonstration(), &[]).expect("the scenario");
    assert!(scenario.model.effects.is_empty());
    assert!(scenario.model.joints.iter().all(|joint| joint.friction.is_none() && joint.backlash.is_none()));
    // The truth is there, and says nothing of itself but to be compared with.
    assert_eq!(scenario.truth.backlash("joint1"), Some(0.008_203_05));
    assert!(scenario.truth.friction("joint2").is_some() && scenario.truth.friction("joint3").is_none());
    assert_eq!(format!("{:?}", scenario.truth), "Truth of scara_on_a_slope");
}

#[test]
fn regress_another_tilt_fails_what_the_demonstration_expects() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = run(&demonstration(), &folder.path().join("out"), &["model.effects[1].tilt=0.0115".to_owned()]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("expectation failed: base_tilt: tilt is 0.011"), "{stderr}");
    let report = std::fs::read_to_string(folder.path().join("out/report.json")).expect("written all the same");
    assert!(report.contains("base_tilt: tilt is 0.011"));
}

#[test]
fn property_expectations_that_make_no_sense_are_refused_by_place() {
    let line = text().lines().count() + 1;
    for (expect, parts) in [
        ("effects = [\"base_tild\"]", ["expect.effects", "base_tilt"]),
        ("effects = \"base_tilt\"", ["expect.effects", "a list of texts"]),
        ("[[expect.effect]]\ntilt = [0.0, 1.0]", ["expect.effect[1].effect", "missing"]),
        ("[[expect.effect]]\neffect = \"base_tilt\"\ntild = [0.0, 1.0]", ["expect.effect[1].tild", "tilt"]),
        ("[[expect.effect]]\neffect = \"base_tilt\"\ntilt = 0.01", ["expect.effect[1].tilt", "a list of 2"]),
        ("[[expect.effect]]\neffect = \"base_tilt\"\ntilt = [1.0, 0.5]", ["expect.effect[1].tilt", "in this order"]),
        ("[[expect.effect]]\neffect = \"cogging\"\njoint = \"joint9\"", ["expect.effect[1].joint", "joint1, joint2"]),
        ("[expect.joint9]\ncoulomb_percent = 1.0", ["expect", "joint9"]),
    ] {
        let head = if expect.starts_with('[') { "" } else { "[expect]\n" };
        let error = Scenario::from_text(&format!("{}{head}{expect}\n", text()), &demonstration(), &[]);
        let said = error.expect_err(expect).to_string();
        assert!(parts.iter().all(|part| said.contains(part)), "{expect}: {said}");
        let at: usize =
            said.split("scenario.toml:").nth(1).and_then(|rest| rest.split(':').next()?.parse().ok()).unwrap_or(0);
        assert!(at >= line, "{expect}: no line of it in: {said}");
    }
    // What nothing diagnoses cannot be expected.
    let identifies = text().replace("\"diagnose\"", "\"identify\"") + "[expect]\neffects = []\n";
    let said = Scenario::from_text(&identifies, &demonstration(), &[]).expect_err("refused").to_string();
    assert!(said.contains("expect.effects") && said.contains("diagnose"), "{said}");
}

#[test]
fn property_an_assignment_reaches_into_a_list_of_tables() {
    let load = |assignment: &str| Scenario::load(&demonstration(), &[assignment.to_owned()]);
    assert!(load("session[4].name=last").is_ok_and(|scenario| scenario.sessions[3].name == "last"));
    for (assignment, expected) in [
        ("session[5].name=last", "from 1 to 4"),
        ("session[0].name=last", "from 1 to 4"),
        ("controller[1].law=pi", "a list"),
        ("nothing[1].law=pi", "a list"),
    ] {
        let said = load(assignment).expect_err(assignment).to_string();
        assert!(said.contains(expected), "{assignment}: {said}");
    }
}

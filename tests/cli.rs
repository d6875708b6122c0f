//! The command line as a user meets it: exit codes, errors, results, files.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn lostmotion(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lostmotion")).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

fn entries(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// The robot of the catalogue that the tests use.
const ELBOW: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/elbow");

#[test]
fn property_every_effect_listed_is_explained() {
    let list = lostmotion(&["list", "effects"]);
    assert_eq!(list.status.code(), Some(0));
    let names: Vec<&str> = text(&list.stdout).lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.len() >= 12, "{names:?}");
    for name in names {
        let explained = lostmotion(&["explain", name]);
        assert_eq!(explained.status.code(), Some(0), "{name}");
        let explained = text(&explained.stdout);
        for part in ["signature", "look-alikes", "told apart by", "reference"] {
            assert!(explained.contains(part), "{name} lacks {part}:\n{explained}");
        }
    }
}

#[test]
fn property_bad_usage_and_bad_input_end_with_2_on_standard_error() {
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("model.toml");
    let model = fs::read_to_string(Path::new(ELBOW).join("model.toml")).unwrap();
    fs::write(&broken, model.replacen("gear_ratio", "gear_rato", 1)).unwrap();
    fs::copy(Path::new(ELBOW).join("elbow.urdf"), folder.path().join("elbow.urdf")).unwrap();
    let truncated = folder.path().join("run.csv");
    fs::write(&truncated, "time,shoulder.position,shoulder.current\n0.0,0.1,0.2\n0.1,nan,0.2\n").unwrap();
    let (broken, truncated) = (broken.to_str().unwrap(), truncated.to_str().unwrap());
    let cases: [(&[&str], &[&str]); 7] = [
        (&["no_such_verb"], &["no_such_verb"]),
        (&["explain", "coging"], &["coging", "cogging"]),
        (&["check", "no_such_file.toml"], &["no_such_file.toml"]),
        (&["check", broken], &["model.toml:", "gear_rat"]),
        (&["check", truncated], &["run.csv", "shoulder.position"]),
        (&["identify", "--model", "no_such_robot", "--data", truncated], &["no_such_robot", "elbow"]),
        (&["identify", "--model", broken, "--data", truncated], &["model.toml:", "gear_rat"]),
    ];
    for (arguments, expected) in cases {
        let output = lostmotion(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty(), "{arguments:?} wrote to standard output");
        let error = text(&output.stderr);
        for part in expected {
            assert!(error.contains(part), "{arguments:?}: {part} is missing in {error}");
        }
    }
}

#[test]
fn property_a_failed_run_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("still.csv");
    let rows: String = (0..200).map(|k| format!("{},0.1,0.1,0.0,0.0\n", 0.01 * f64::from(k))).collect();
    fs::write(&data, format!("time,shoulder.position,elbow.position,shoulder.current,elbow.current\n{rows}")).unwrap();
    let out = folder.path().join("results");
    let arguments = ["identify", "--model", ELBOW, "--data", data.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let output = lostmotion(&arguments);
    assert_eq!(output.status.code(), Some(2), "an arm at rest tells nothing about friction");
    let error = text(&output.stderr);
    assert!(error.contains("0 steady windows") && error.contains("`diagnose`") && !error.contains("NaN"), "{error}");
    assert_eq!(entries(folder.path()), ["still.csv"]);
}

#[test]
fn property_other_peoples_files_are_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("thesis.tex"), "").unwrap();
    let out = folder.path().to_str().unwrap();
    let output = lostmotion(&["replay", "--model", ELBOW, "--data", "unread.csv", "--out", out]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(entries(folder.path()), ["thesis.tex"]);
}

#[test]
fn property_a_new_model_is_accepted_and_never_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = folder.path().join("elbow.urdf");
    fs::copy(Path::new(ELBOW).join("elbow.urdf"), &urdf).unwrap();
    let arguments = ["new", urdf.to_str().unwrap()];
    assert_eq!(lostmotion(&arguments).status.code(), Some(0));
    let model = folder.path().join("model.toml");
    assert_eq!(lostmotion(&["check", model.to_str().unwrap()]).status.code(), Some(0));
    assert_eq!(lostmotion(&arguments).status.code(), Some(2), "the first model would be lost");
}

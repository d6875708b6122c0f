//! `lostmotion data` as a user meets it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use super::corpus;

fn data(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lostmotion"));
    command.arg("data").args(arguments).current_dir(folder).output().expect("the program runs")
}

fn printed(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn folder_with(files: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for file in files {
        fs::copy(corpus(file), folder.path().join(file)).expect("a copy");
    }
    folder
}

#[test]
fn property_what_was_taken_for_what_is_printed_with_its_quality() {
    let folder = folder_with(&["plain.csv", "ur_rtde.csv", "lerobot.parquet"]);
    let text = printed(&data(folder.path(), &["plain.csv"]));
    for part in [
        "time [s]",
        "joint1.position [rad]",
        "joint1.current [A]",
        "canonical columns: no manifest needed",
        "120 samples, 0 s to 0.119 s, median step 1.0000e-3 s (1000.0 Hz), jitter 0.00 % of it, no pause",
        "resolution 1.000e-4",
    ] {
        assert!(text.contains(part), "`{part}` not in {text}");
    }
    assert!(!text.contains("A manifest to begin with"), "{text}");
    let text = printed(&data(folder.path(), &["ur_rtde.csv"]));
    for part in ["its names are clear", "joint_0.position [rad]", "A manifest to begin with", "column = \"actual_q_0\""]
    {
        assert!(text.contains(part), "`{part}` not in {text}");
    }
}

#[test]
fn property_data_that_cannot_be_understood_are_an_error() {
    let folder = folder_with(&[]);
    for (content, part) in [
        ("time,joint1.position\n", "rows = 0"),
        ("time,joint1.position\n0,1\n", "rows = 1"),
        ("name,state\na,idle\nb,run\nc,run\n", "columns of numbers; these hold none"),
        ("a,b\n1,4\n0,3\n1,2\n", "a column of time"),
        ("just some words\nand no table\n", "a header of column names"),
        ("{}", "columns = none"),
        ("[1, 2]", "an object of columns"),
    ] {
        fs::write(folder.path().join("run.log"), content).expect("a file");
        let output = data(folder.path(), &["run.log"]);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{content}: {}", String::from_utf8_lossy(&output.stdout));
        assert!(error.contains("run.log") && error.contains(part) && output.stdout.is_empty(), "{content}: {error}");
    }
}

#[test]
fn property_a_manifest_is_written_where_it_is_asked_for_and_never_over_a_file() {
    let folder = folder_with(&["no_header.csv", "plain.csv"]);
    fs::create_dir(folder.path().join("there")).expect("a folder");
    for target in ["first.toml", "there/first.toml"] {
        let text = printed(&data(folder.path(), &["no_header.csv", "--manifest", target]));
        assert!(text.contains(&format!("written: {target}")), "{text}");
        let session = lostmotion::dataset::load_alone(&folder.path().join(target)).expect("a manifest that loads");
        assert_eq!(session.series.len(), 120);
        let again = data(folder.path(), &["no_header.csv", "--manifest", target]);
        assert_eq!(again.status.code(), Some(2), "the first manifest would be lost");
    }
    let two = data(folder.path(), &["no_header.csv", "plain.csv", "--manifest", "both.toml"]);
    assert_eq!(two.status.code(), Some(2));
    assert!(!folder.path().join("both.toml").exists());
}

#[test]
fn property_a_first_manifest_names_the_joints_of_a_model() {
    let folder = folder_with(&["numbered.csv"]);
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/elbow");
    let text = printed(&data(folder.path(), &["numbered.csv", "--model", model]));
    assert!(text.contains("[joints.shoulder]\nposition = { column = \"position_0\""), "{text}");
    assert!(text.contains("[joints.elbow]\nposition = { column = \"position_1\""), "{text}");
}

//! Which files in a folder of results are replaced, and which stay.

use std::fs;

use super::fixture::{Files, RESULTS, done, refused};

#[test]
fn regress_a_folder_with_a_report_of_another_program_is_not_removed() {
    let files = Files::new();
    files.put("project/report.json", "{}");
    files.put("project/src/main.rs", "fn main() {}");
    files.put("project/thesis.tex", "\\documentclass{book}");
    let before = files.snapshot("project");
    refused(&files.replay("project"), &["project/report.json", "lostmotion wrote none there", "--out"]);
    assert_eq!(files.snapshot("project"), before);
    assert_eq!(files.names("project"), ["report.json", "src", "thesis.tex"], "nothing of its own is left either");
}

#[test]
fn regress_results_stand_beside_foreign_files_and_leave_them() {
    let files = Files::new();
    files.put("project/src/main.rs", "fn main() {}");
    files.put("project/.lostmotionrc", "mine");
    let before = files.snapshot("project");
    for _ in 0..2 {
        done(&files.replay("project"));
        let mut after = files.snapshot("project");
        for name in ["report.json", "report.html", "trace.rrd"] {
            assert_eq!(
                after.remove(&files.path("project").join(name)).is_some(),
                name != "trace.rrd" || cfg!(feature = "rerun")
            );
        }
        assert_eq!(after, before);
    }
}

#[test]
fn regress_the_folder_of_the_inputs_keeps_them() {
    let files = Files::new();
    fs::create_dir(files.path("in")).unwrap();
    fs::rename(files.path("run.csv"), files.path("in/run.csv")).unwrap();
    let recording = files.text("in/run.csv");
    for _ in 0..2 {
        done(&files.lostmotion(&["replay", "--quiet", "--model", "model.toml", "--data", "in/run.csv", "--out", "in"]));
        assert_eq!(files.text("in/run.csv"), recording);
    }
    assert!(files.path("in/report.json").is_file());
}

#[test]
fn regress_results_below_the_folder_stay() {
    let files = Files::new();
    done(&files.lostmotion(&["run", "scenario.toml", "--quiet", "--csv"]));
    let before = files.snapshot("out/to_and_fro");
    assert!(before.len() >= RESULTS.len());
    for _ in 0..2 {
        done(&files.replay("out"));
        assert_eq!(files.snapshot("out/to_and_fro"), before);
    }
}

#[test]
fn regress_recordings_beside_a_scenario_and_the_scenario_itself_stay() {
    let files = Files::new();
    for name in ["scenario.toml", "model.toml", "robot.urdf"] {
        files.put(&format!("out/to_and_fro/{name}"), files.text(name));
    }
    files.put("out/to_and_fro/day_1.csv", "recorded for a day");
    files.put("out/to_and_fro/report.json", "{\"of\": \"another\"}");
    let before = files.snapshot("out/to_and_fro");
    for _ in 0..2 {
        done(&files.lostmotion(&["run", "out/to_and_fro/scenario.toml", "--quiet"]));
        assert_eq!(files.snapshot("out/to_and_fro"), before);
        assert!(files.path("out/to_and_fro_run/report.json").is_file());
    }
}

#[test]
fn regress_a_designed_scenario_runs_as_the_readme_prints_it() {
    let files = Files::new();
    done(&files.lostmotion(&[
        "design",
        "--quiet",
        "--model",
        "model.toml",
        "--question",
        "current_offset",
        "--budget",
        "45",
    ]));
    files.put("out/design/recorded.csv", "on the machine");
    let before = files.snapshot("out/design");
    // Its motion is not what this test is about.
    let run = ["run", "out/design/scenario.toml", "--quiet", "--set", "procedure=none"];
    done(&files.lostmotion(&run));
    assert_eq!(files.snapshot("out/design"), before);
    assert!(files.path("out/design_run/report.json").is_file());
}

#[test]
fn regress_a_file_that_was_changed_is_the_users() {
    let files = Files::new();
    done(&files.replay("results"));
    let written = files.text("results/report.html");
    files.put("results/report.html", "with my notes");
    let before = files.snapshot("results");
    refused(&files.replay("results"), &["results/report.html", "changed since", "Rename it"]);
    assert_eq!(files.snapshot("results"), before);
    fs::rename(files.path("results/report.html"), files.path("results/notes.html")).unwrap();
    done(&files.replay("results"));
    assert_eq!(files.text("results/report.html"), written);
    assert_eq!(files.text("results/notes.html"), "with my notes");
}

#[test]
fn regress_an_input_is_not_written_over_though_lostmotion_wrote_it() {
    let files = Files::new();
    done(&files.lostmotion(&["run", "01_identify_scara", "--quiet", "--csv"]));
    let (model, data) = ("out/01_identify_scara/model.toml", "out/01_identify_scara/joint1.csv");
    assert!(files.path(model).is_file() && files.names("out/01_identify_scara").contains(&"joint1.csv".to_owned()));
    let before = files.snapshot("out");
    let into =
        |out: &[&str]| files.lostmotion(&[&["identify", "--quiet", "--model", model, "--data", data], out].concat());
    refused(&into(&["--out", "out/01_identify_scara"]), &["out/01_identify_scara/model.toml", "this command reads"]);
    assert_eq!(files.snapshot("out"), before);
}

#[test]
fn property_an_earlier_result_of_the_same_verb_is_replaced_whole_and_of_another_verb_kept() {
    let files = Files::new();
    done(&files.run("results", "1"));
    done(&files.replay("results"));
    for name in RESULTS {
        assert!(files.path("results").join(name).is_file(), "{name} of `run` stays beside the result of `replay`");
    }
    files.put("results/second.csv", "changed");
    refused(&files.run("results", "1"), &["results/second.csv", "changed since"]);
    done(&files.lostmotion(&["run", "scenario.toml", "--quiet", "--out", "results"]));
    let names = files.names("results");
    assert!(!names.contains(&"first.csv".to_owned()), "{names:?}");
    assert_eq!(files.text("results/second.csv"), "changed");
}

#[test]
fn property_a_list_that_was_tampered_with_leads_nowhere() {
    let files = Files::new();
    files.put("victim.csv", "mine");
    done(&files.run("results", "1"));
    let list = files.text("results/.lostmotion/files.json");
    let sum = "6a3d9bd9a4a5e4f9b3ba0d5c64e5a7d4d9f2a3c1b0e8f7d6c5b4a39281706f5e";
    let outside = format!("\"files\": {{ \"../victim.csv\": {{ \"by\": \"run\", \"sha256\": [\"{sum}\"] }},");
    for broken in [list.replacen("\"files\": {", &outside, 1), "{".to_owned(), list.replace("files/1", "files/9")] {
        files.put("results/.lostmotion/files.json", broken);
        let before = files.snapshot("");
        refused(&files.run("results", "2"), &["results/.lostmotion/files.json", "a list of files"]);
        assert_eq!(files.snapshot(""), before);
    }
}

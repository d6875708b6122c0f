//! Recordings that are one, and what does not fit the machine.

use std::fs;

use super::Folder;
use super::support::recordings::{changed, csv, run_csv, run_mat, timed};

fn diagnose(folder: &Folder, rest: &[&str], parts: &[&str]) {
    let arguments = ["diagnose", "--quiet", "--out", "out", "--model", "model.toml", "--data", "run.csv"];
    folder.refuses(&[&arguments[..], rest].concat(), parts);
}

/// Two recordings that differ, in a folder of each.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.put("run.csv", run_csv());
    fs::create_dir(folder.path("other")).expect("a folder");
    let other = timed(|row| format!("{:.3}", row as f64 * 0.001)).replace(",-0.", ",-0.1");
    folder.put("other/run.csv", &other);
    folder.put("second.csv", &other);
    folder
}

#[test]
fn regress_a_recording_that_is_given_twice_is_refused() {
    let folder = folder();
    fs::hard_link(folder.path("run.csv"), folder.path("link.csv")).expect("a link");
    folder.put("copy.csv", run_csv());
    folder.put("run.mat", run_mat());
    let position_only = csv("time,turn.position,note").replace(",-", ",");
    folder.put("renamed.csv", position_only);
    let same = "the same file";
    diagnose(&folder, &["--hold-out", "run.csv"], &["run.csv: --hold-out = the same file", "not in --data"]);
    diagnose(&folder, &["--hold-out", "./other/../run.csv"], &["--hold-out = the same file", "says nothing"]);
    diagnose(&folder, &["--reference", "run.csv"], &["run.csv: --reference = the same file", "healthy machine"]);
    diagnose(&folder, &["second.csv", "run.csv"], &["run.csv: --data = the same file", "each recording once"]);
    diagnose(&folder, &["--hold-out", "second.csv", "second.csv"], &["second.csv: --hold-out", same]);
    let samples = "samples of turn that are in run.csv too";
    diagnose(&folder, &["--hold-out", "copy.csv"], &["copy.csv: --hold-out", samples, "says nothing"]);
    diagnose(&folder, &["--hold-out", "link.csv"], &["link.csv: --hold-out", samples]);
    diagnose(&folder, &["--reference", "copy.csv"], &["copy.csv: --reference", samples, "no change"]);
    diagnose(&folder, &["copy.csv"], &["copy.csv: --data", samples, "each recording once"]);
    folder.put("same.mat", run_mat());
    let flags = ["identify", "--quiet", "--out", "out", "--model", "model.toml", "--data"];
    folder.refuses(&[&flags[..], &["run.csv", "run.csv"]].concat(), &["run.csv: --data = the same file"]);
    folder.refuses(&[&flags[..], &["run.mat", "same.mat"]].concat(), &["same.mat: --data", "samples of turn"]);
    let flags = ["replay", "--quiet", "--out", "out", "--model", "model.toml", "--data"];
    folder.refuses(&[&flags[..], &["run.csv", "copy.csv"]].concat(), &["copy.csv: --data", "samples of turn"]);
}

#[test]
fn regress_a_part_of_the_data_is_not_held_out() {
    let folder = Folder::new();
    folder.put("run.csv", run_csv());
    let tail: Vec<String> = run_csv().lines().map(str::to_owned).collect();
    folder.put("tail.csv", format!("{}\n{}\n", tail[0], tail[120..].join("\n")));
    diagnose(&folder, &["--hold-out", "tail.csv"], &["tail.csv: --hold-out = samples of turn that are in run.csv too"]);
}

#[test]
fn regress_two_sessions_of_one_name_are_refused() {
    let folder = folder();
    let parts = ["other/run.csv: --hold-out = run", "a name of its own", "run.csv has this one", "rename"];
    diagnose(&folder, &["--hold-out", "other/run.csv"], &parts);
    diagnose(&folder, &["other/run.csv"], &["other/run.csv: --data = run", "a name of its own"]);
}

#[test]
fn regress_positions_outside_of_the_limits_are_noted() {
    let folder = Folder::new();
    let rows = |factor: f64| {
        let rows = (0..200).map(|row| {
            let position = factor * (0.03 * f64::from(row)).sin();
            format!("{:.3},{position:.6},{:.6}\n", 0.001 * f64::from(row), -position)
        });
        format!("time,turn.position,turn.torque\n{}", rows.collect::<String>())
    };
    // The limits are ±3 rad, with a margin of 0.12 rad.
    for (factor, said) in [(3.1, false), (3.2, true), (60.0, true)] {
        folder.put("run.csv", rows(factor));
        let output = folder.replay("run.csv");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_ne!(output.status.code(), Some(2), "{message}");
        assert_eq!(
            message.contains("lies outside the limits of turn in the model, -3.0000 to 3.0000 rad"),
            said,
            "{message}"
        );
        if said {
            assert_eq!(output.status.code(), Some(3), "{message}");
            assert!(message.contains("run.csv: row ") && message.contains("turn.position"), "{message}");
        }
    }
    folder.put("run.csv", changed("\n0.003,", "\n0.003,9,0\n0.0035,"));
    let message = String::from_utf8_lossy(&folder.replay("run.csv").stderr).into_owned();
    assert!(message.contains("run.csv: row 4: turn.position: 9.0000 rad lies outside"), "{message}");
    assert!(message.contains("as 1 of 201 rows do"), "{message}");
}

//! What stands at `--out` and is no folder, or one that nobody can write.

use std::fs;
use std::os::unix::fs::{FileTypeExt as _, symlink};
use std::os::unix::net::UnixListener;
use std::process::Command;

use super::fixture::{Files, done, refused};

/// A gain with which the simulation diverges: a refusal that says nothing of divergence came before the work.
const DIVERGES: &str = "controller.joints.turn.proportional=2000";

/// Asks for results in a place that must be refused before the simulation.
#[track_caller]
fn refused_before_the_work(files: &Files, out: &str, parts: &[&str]) {
    let output = files.lostmotion(&["run", "scenario.toml", "--set", DIVERGES, "--out", out]);
    refused(&output, parts);
    assert!(!String::from_utf8_lossy(&output.stderr).contains("diverged"), "{out} is refused after the work");
}

#[test]
fn regress_what_is_no_folder_is_refused_and_stays() {
    let files = Files::new();
    files.put("file", "mine");
    assert!(Command::new("mkfifo").arg(files.path("fifo")).status().expect("mkfifo").success());
    let _socket = UnixListener::bind(files.path("socket")).expect("a socket");
    symlink("nowhere", files.path("dangling")).unwrap();
    symlink("file", files.path("to_file")).unwrap();
    let names = files.names("");
    for (out, found) in [
        ("file", "a file"),
        ("to_file", "a file"),
        ("fifo", "a FIFO"),
        ("socket", "a socket"),
        ("/dev/null", "a device"),
        ("dangling", "a link that leads to nothing"),
    ] {
        refused_before_the_work(&files, out, &["--out", out, found]);
    }
    assert_eq!(files.names(""), names);
    assert_eq!(files.text("file"), "mine");
    assert!(fs::metadata(files.path("fifo")).unwrap().file_type().is_fifo());
    assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    assert_eq!(fs::read_link(files.path("dangling")).unwrap().to_str(), Some("nowhere"));
}

#[test]
fn regress_an_unwritable_place_is_refused_before_the_work() {
    let files = Files::new();
    files.put("file", "mine");
    let names = files.names("");
    refused_before_the_work(&files, "file/below", &["file/below", "cannot create folder"]);
    refused_before_the_work(&files, &"long/".repeat(2000), &["cannot create folder"]);
    refused_before_the_work(&files, &"x".repeat(300), &["cannot create folder"]);
    if cfg!(target_os = "linux") {
        // Not even root can make files there.
        refused_before_the_work(
            &files,
            "/proc/lostmotion/results",
            &["/proc/lostmotion/results", "cannot create folder"],
        );
        refused_before_the_work(&files, "/proc", &["/proc", "cannot write"]);
    }
    assert_eq!(files.names(""), names);
}

#[test]
fn regress_a_link_to_a_folder_stays_a_link_and_its_folder_takes_the_results() {
    let files = Files::new();
    files.put("real/mine.txt", "mine");
    symlink("real", files.path("link")).unwrap();
    for _ in 0..2 {
        done(&files.replay("link"));
        assert_eq!(fs::read_link(files.path("link")).unwrap().to_str(), Some("real"));
        assert!(files.path("real/report.json").is_file());
        assert_eq!(files.text("real/mine.txt"), "mine");
    }
}

#[test]
fn regress_links_and_folders_in_place_of_results_stay() {
    let files = Files::new();
    files.put("victim", "mine");
    done(&files.replay("results"));
    let content = files.text("results/report.json");
    // What it leads to has the content that lostmotion wrote; the link is still not its file.
    files.put("elsewhere.json", content);
    fs::remove_file(files.path("results/report.json")).unwrap();
    symlink("../elsewhere.json", files.path("results/report.json")).unwrap();
    refused(&files.replay("results"), &["results/report.json", "lostmotion wrote none there"]);
    assert!(files.path("results/report.json").is_symlink());
    fs::create_dir_all(files.path("folders/report.html/mine")).unwrap();
    refused(&files.replay("folders"), &["folders/report.html"]);
    assert!(files.path("folders/report.html/mine").is_dir());
    symlink("../victim", files.path("folders/.lostmotion")).unwrap();
    refused(&files.replay("folders"), &["folders/.lostmotion", "not a file or a link"]);
    assert_eq!(files.text("victim"), "mine");
}

#[test]
fn property_a_failed_run_removes_the_folders_that_were_made_for_it() {
    let files = Files::new();
    fs::create_dir(files.path("empty")).unwrap();
    let names = files.names("");
    for out in ["a/b/c", "empty", "empty/d", "."] {
        let output = files.lostmotion(&["run", "scenario.toml", "--quiet", "--set", DIVERGES, "--out", out]);
        refused(&output, &["diverged"]);
        assert_eq!(files.names(""), names, "{out}");
        assert!(files.names("empty").is_empty(), "{out}");
    }
}

//! Processes that are killed, interrupted, or that write to one folder at the same time.

use std::collections::BTreeMap;
use std::fs;
use std::process::{Child, Command, Output};
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::fixture::{Files, RESULTS, done, refused, wait_for};

/// A run that takes minutes, if nothing ends it.
const LONG: [&str; 7] = ["run", "scenario.toml", "--set", "control_period=0.0001", "--quiet", "--out", "results"];

fn send(signal: &str, child: &Child) {
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill");
    assert!(sent.success());
}

fn ended(child: Child) -> Output {
    child.wait_with_output().expect("its output")
}

/// Starts the long run and waits until it works.
fn working(files: &Files) -> Child {
    let child = files.start(&LONG);
    wait_for("the lock", || files.path("results/.lostmotion/lock").exists());
    // From the lock to the simulation it is a matter of a check and a probe; a run without it would be in the simulation too.
    std::thread::sleep(Duration::from_millis(300));
    child
}

/// The long scenario: its middle session lasts for ten minutes.
fn long(files: &Files) {
    let text = files.text("scenario.toml");
    files.put("scenario.toml", text.replacen("duration = 0.2", "duration = 600", 1));
}

#[test]
fn regress_a_kill_at_any_moment_leaves_every_file_whole_and_old_or_new() {
    const KILLS: usize = 120;
    let files = Files::new();
    let results = |folder: &str| -> BTreeMap<&str, String> {
        RESULTS.iter().map(|&name| (name, files.text(&format!("{folder}/{name}")))).collect()
    };
    done(&files.run("old", "1"));
    done(&files.run("new", "2"));
    let contents = [results("old"), results("new")];
    // `report.html` of a run without a procedure does not show its seed.
    assert!(RESULTS.iter().filter(|&&name| contents[0][name] != contents[1][name]).count() >= 4);
    done(&files.run("results", "1"));
    let mut rng = ChaCha8Rng::seed_from_u64(20);
    let (staged, list) = (files.path("results/.lostmotion/new"), files.path("results/.lostmotion/files.json"));
    let (mut during, mut mixed) = (0, 0);
    for kill in 0..KILLS {
        let old = files.text("results/first.csv") == contents[0]["first.csv"];
        let seed = if old { "2" } else { "1" };
        // What the last kill left there would be taken for the beginning of this one's writing.
        fs::remove_dir_all(&staged).ok();
        let before = fs::read(&list).unwrap();
        let mut child = files.start(&["run", "scenario.toml", "--quiet", "--csv", "--seed", seed, "--out", "results"]);
        // Half of the kills fall into the writing beside the earlier files, half between the two changes of the list, in which
        // the files are renamed: that takes some tenths of a millisecond.
        let renaming = kill % 2 == 0;
        wait_for("the writing", || {
            let writes = if renaming { fs::read(&list).unwrap() != before } else { staged.exists() };
            writes || child.try_wait().expect("its state").is_some()
        });
        let longest = if renaming { 300 } else { 8_000 };
        let until = Instant::now() + Duration::from_micros(rng.random_range(0..longest));
        while Instant::now() < until {
            std::hint::spin_loop();
        }
        during += usize::from(child.try_wait().expect("its state").is_none());
        child.kill().expect("killed, or ended");
        child.wait().expect("its end");
        let now = results("results");
        for (name, content) in &now {
            let known = contents.iter().any(|of| of[name] == *content);
            assert!(known, "kill {kill}: {name} is neither the old nor the new one, {} bytes", content.len());
        }
        mixed += usize::from(contents.iter().all(|of| *of != now));
    }
    // Kills after the end test nothing.
    assert!(during > KILLS / 4, "{during} of {KILLS} kills met a running process");
    eprintln!("{during} of {KILLS} kills met a running process, {mixed} of them left old beside new files");
    done(&files.run("results", "2"));
    assert_eq!(results("results"), contents[1]);
    let mut own = files.names("results/.lostmotion");
    own.retain(|name| name != "lock");
    assert_eq!(own, ["files.json"], "what killed runs left is removed");
}

#[test]
fn regress_leftovers_of_a_killed_run_are_removed_by_the_next() {
    let files = Files::new();
    done(&files.replay("results"));
    files.put("results/.lostmotion/new/report.json", "half of a re");
    files.put("results/.lostmotion/files.json.part", "{");
    done(&files.replay("results"));
    assert!(
        !files.path("results/.lostmotion/new").exists() && !files.path("results/.lostmotion/files.json.part").exists()
    );
    // Killed before its first result: the next is not refused.
    long(&files);
    fs::remove_dir_all(files.path("results")).unwrap();
    let child = working(&files);
    send("-KILL", &child);
    assert_eq!(ended(child).status.code(), None);
    assert!(files.path("results").is_dir());
    done(&files.replay("results"));
}

#[test]
fn regress_two_processes_on_one_folder_do_not_meet() {
    let files = Files::new();
    long(&files);
    let first = working(&files);
    fs::create_dir(files.path("beside")).unwrap();
    std::os::unix::fs::symlink("results", files.path("link")).unwrap();
    for out in ["results", "link", "beside/../results"] {
        refused(&files.replay(out), &[out, "no other lostmotion is writing"]);
    }
    assert!(!files.path("results/report.json").exists());
    send("-KILL", &first);
    ended(first);
    done(&files.replay("results"));
}

#[test]
fn property_of_many_processes_at_once_each_is_done_or_refused_and_the_files_are_whole() {
    let files = Files::new();
    done(&files.run("one", "1"));
    for _ in 0..5 {
        let children: Vec<Child> = (0..6)
            .map(|_| files.start(&["run", "scenario.toml", "--quiet", "--csv", "--seed", "1", "--out", "all"]))
            .collect();
        let outputs: Vec<Output> = children.into_iter().map(ended).collect();
        let (good, bad): (Vec<&Output>, Vec<&Output>) = outputs.iter().partition(|output| output.status.success());
        assert!(!good.is_empty());
        bad.into_iter().for_each(|output| refused(output, &["all", "no other lostmotion is writing"]));
        for name in RESULTS {
            assert_eq!(files.text(&format!("all/{name}")), files.text(&format!("one/{name}")));
        }
        fs::remove_dir_all(files.path("all")).unwrap();
    }
}

#[test]
fn regress_an_interrupted_run_leaves_nothing() {
    for signal in ["-INT", "-TERM"] {
        let files = Files::new();
        long(&files);
        let names = files.names("");
        let child = working(&files);
        send(signal, &child);
        assert!(!ended(child).status.success());
        assert_eq!(files.names(""), names, "{signal}");
    }
}

#[test]
fn regress_an_interrupted_judgement_leaves_the_diagnosis() {
    let files = Files::new();
    done(&files.lostmotion(&["run", "02_name_the_cause", "--quiet", "--csv", "--out", "recorded"]));
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/02_name_the_cause/model.toml");
    let data = ["staircase_1", "staircase_2", "sweep_1", "sweep_2"].map(|name| format!("recorded/{name}.csv"));
    let mut arguments = vec!["diagnose", "--judge", "--quiet", "--model", model, "--out", "results", "--data"];
    arguments.extend(data.iter().map(String::as_str));
    for signal in ["-INT", "-KILL"] {
        let mut child = files.start(&arguments);
        wait_for("the diagnosis", || {
            files.path("results/report.json").exists() || child.try_wait().expect("its state").is_some()
        });
        // Far longer than the rest of the writing, far shorter than a judgement.
        std::thread::sleep(Duration::from_secs(1));
        send(signal, &child);
        assert!(!ended(child).status.success());
        let report = files.text("results/report.json");
        // The tilt is in the model file, so that nothing is left to be found.
        for part in ["\"verdict\": \"nothing_found\"", "It had not ended when this was written."] {
            assert!(report.contains(part), "{part}: {report}");
        }
        done(&files.lostmotion(&["check", "results/model.toml"]));
        fs::remove_dir_all(files.path("results")).unwrap();
    }
}

#[test]
fn regress_an_interrupted_run_leaves_no_catalogue_behind() {
    let files = Files::new();
    fs::create_dir(files.path("tmp")).unwrap();
    for signal in ["-INT", "-KILL"] {
        let arguments = ["run", "01_identify_scara", "--quiet", "--set", "control_period=0.0002", "--out", "results"];
        let mut command = files.command(&arguments);
        let child = command.env("TMPDIR", files.path("tmp")).spawn().expect("the program runs");
        wait_for("the lock", || files.path("results/.lostmotion/lock").exists());
        assert!(files.names("tmp").is_empty());
        send(signal, &child);
        ended(child);
        assert!(files.names("tmp").is_empty(), "{:?} after {signal}", files.names("tmp"));
    }
}

#[test]
fn regress_messages_and_models_name_no_temporary_file() {
    let files = Files::new();
    let temporary = files.path("tmp");
    fs::create_dir(&temporary).unwrap();
    let run =
        |arguments: &[&str]| files.command(arguments).env("TMPDIR", &temporary).output().expect("the program runs");
    let broken = run(&["run", "01_identify_scara", "--set", "model.joints.joint1.gear_ratio=0"]);
    refused(&broken, &["error: catalogue:/", "robots/scara/model.toml: joints.joint1.gear_ratio = 0"]);
    let unknown = run(&["run", "01_identify_scara", "--set", "controler=0"]);
    refused(&unknown, &["error: catalogue:/scenarios/01_identify_scara/scenario.toml: controler = 0"]);
    let refused_data = run(&["replay", "--model", "scara", "--data", "run.csv"]);
    assert_eq!(refused_data.status.code(), Some(2));
    done(&run(&["run", "01_identify_scara", "--out", "results"]));
    for name in ["model.toml", "report.json", "report.html"] {
        let text = files.text(&format!("results/{name}"));
        assert!(!text.contains(temporary.to_str().unwrap()) && !text.contains("catalogue:"), "{name}");
    }
    for output in [broken, unknown, refused_data] {
        assert!(!String::from_utf8_lossy(&output.stderr).contains(temporary.to_str().unwrap()));
    }
    done(&files.lostmotion(&["check", "results/model.toml"]));
}

#[test]
fn property_a_finished_result_is_written_beside_a_folder_that_changed_meanwhile() {
    let files = Files::new();
    let text = files.text("scenario.toml");
    files.put("scenario.toml", text.replacen("duration = 0.2", "duration = 100", 1));
    let child = working(&files);
    files.put("results/report.html", "put there meanwhile");
    let output = ended(child);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(message.contains("the results are in results-2") && message.contains("results/report.html"), "{message}");
    assert_eq!(files.text("results/report.html"), "put there meanwhile");
    assert!(files.path("results-2/report.json").is_file() && !files.path("results/report.json").exists());
}

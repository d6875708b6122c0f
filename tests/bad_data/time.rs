//! The time column: its unit, its origin, its steps.

use lostmotion::dataset;

use super::support::recordings::timed;
use super::{Folder, each_is_refused};

const MANIFEST: &str = "schema = 'lostmotion/dataset/1'\nfile = 'run.csv'\n[time]\ncolumn = 'time'\n\
                        [joints.turn]\nposition = { column = 'turn.position' }\ntorque = { column = 'turn.torque' }\n";

const EPOCH: i64 = 1_700_000_000;

#[test]
fn regress_time_in_ms_us_or_ns_is_recognised() {
    let us = "`[time] unit = \"us\"`";
    each_is_refused(
        "run.csv",
        &[
            (
                timed(|row| (row * 1000).to_string()),
                &["time = steps of 1.0000e3 s", "likely in us", us, "lostmotion data"][..],
            ),
            (timed(|row| (row * 1_000_000).to_string()), &["steps of 1.0000e6 s", "likely in ns", "unit = \"ns\""]),
            (timed(|row| row.to_string()), &["steps of 1.0000e0 s", "likely in ms", "unit = \"ms\"", "unit = \"s\""]),
            (timed(|row| format!("{}.5", row * 4)), &["steps of 4.0000e0 s", "likely in ms"]),
            (timed(|row| (row * 10).to_string()), &["steps of 1.0000e1 s", "likely in ms"]),
            (timed(|row| format!("{}e3", row)), &["steps of 1.0000e3 s", "likely in us"]),
            // 80 may be 80 ms or 80 µs: the steps of both are those of some log.
            (timed(|row| (row * 80).to_string()), &["steps of 8.0000e1 s", "unit = \"ms\"` or `[time] unit = \"us\""]),
            // Since 1970 by its size, and by its steps in another unit.
            (timed(|row| (EPOCH * 1000 + row as i64 * 1000).to_string()), &["likely in us", us]),
            (timed(|row| format!("{}.{:09}", 739_000, row * 12)), &["likely in d", "unit = \"d\""]),
            (timed(|row| format!("{}e-9", row)), &["steps of 1.0000e-9 s", "5e-5 s to 0.1 s"]),
            (timed(|row| format!("{}e15", row)), &["steps of 1.0000e15 s", "if these are seconds"]),
        ],
    );
}

/// A time since 1970 says its unit by its size; its steps have to agree.
#[test]
fn regress_time_since_1970_is_read_in_its_unit() {
    let folder = Folder::new();
    for (unit, step) in [("ms", 1_i64), ("us", 1000), ("ns", 1_000_000)] {
        let path = folder.put("run.csv", timed(|row| (EPOCH * 1000 * step + row as i64 * step).to_string()));
        let session = dataset::load_alone(&path).expect("read");
        // Whole numbers until the first is subtracted.
        for (row, time) in session.series.time.iter().enumerate() {
            assert!((time - row as f64 * 0.001).abs() < 1e-15, "{unit}, row {row}: {time}");
        }
        assert!(session.notes[0].text.contains(&format!("taken as the time: time in {unit}")), "{:?}", session.notes);
    }
}

#[test]
fn regress_slow_time_is_asked_about_and_a_manifest_answers() {
    let folder = Folder::new();
    folder.put("run.csv", timed(|row| format!("{:.1}", row as f64 * 0.2)));
    folder.refuses_data("run.csv", &["run.csv: time = steps of 2.0000e-1 s", "unit = \"s\""]);
    folder.put("turn.toml", MANIFEST);
    folder.refuses_data("turn.toml", &["run.csv: time = steps of 2.0000e-1 s", "in the manifest with `[time] unit = "]);
    folder.put("turn.toml", MANIFEST.replace("'time'\n", "'time'\nunit = 's'\n"));
    folder.reads("turn.toml", &["200 samples", "note: run.csv: time: steps of 2.0000e-1 s; a robot's log has steps"]);
}

#[test]
fn regress_a_unit_that_makes_no_log_is_refused() {
    let folder = Folder::new();
    let with = |unit: &str| MANIFEST.replace("'time'\n", &format!("'time'\nunit = '{unit}'\n"));
    let rows: [(&str, String, &[&str]); 6] = [
        (
            "us",
            timed(|row| format!("{:.3}", row as f64 * 0.001)),
            &["steps of 1.0000e-9 s", "is `[time] unit = \"us\"` right?"],
        ),
        ("s", timed(|row| (row * 1000).to_string()), &["steps of 1.0000e3 s", "unit = \"s\"` right?"]),
        ("d", timed(|row| row.to_string()), &["steps of 8.6400e4 s", "right?"]),
        ("h", timed(|row| row.to_string()), &["turn.toml:5: time.unit = 'h'", "s, ms, us, ns, d"]),
        ("m", timed(|row| row.to_string()), &["turn.toml:5: time.unit = 'm'", "a unit of time"]),
        ("", timed(|row| row.to_string()), &["turn.toml:5: time.unit", "a unit of time"]),
    ];
    for (unit, content, parts) in rows {
        folder.put("run.csv", content);
        folder.put("turn.toml", with(unit));
        folder.refuses_data("turn.toml", parts);
    }
    // 15,000 steps of 8 s: more than a day.
    let long: String = (0..15_000).map(|row| format!("{},{},1\n", row * 8, row % 7)).collect();
    folder.put("run.csv", format!("time,turn.position,turn.torque\n{long}"));
    folder.put("turn.toml", with("s"));
    folder.refuses_data("turn.toml", &["time = a span of 1.1999e5 s", "at most 86400 s"]);
}

#[test]
fn regress_a_unit_that_is_given_is_taken() {
    let folder = Folder::new();
    for (unit, step) in [("ms", 1_i64), ("us", 1000), ("µs", 1000), ("ns", 1_000_000)] {
        folder.put("run.csv", timed(|row| (EPOCH * 1000 * step + row as i64 * step).to_string()));
        let path = folder.put("turn.toml", MANIFEST.replace("'time'\n", &format!("'time'\nunit = '{unit}'\n")));
        let session = dataset::load_alone(&path).expect("read");
        // Whole numbers until the first is subtracted: what is left is exact but for the factor.
        for (row, time) in session.series.time.iter().enumerate() {
            assert!((time - row as f64 * 0.001).abs() < 1e-15, "{unit}, row {row}: {time}");
        }
        assert!(session.notes.is_empty(), "{:?}", session.notes);
    }
}

#[test]
fn regress_epoch_seconds_keep_their_digits() {
    let folder = Folder::new();
    let path = folder.put("run.csv", timed(|row| format!("{EPOCH}.{:09}", 123_456_789 + row * 1_000_000)));
    let time = dataset::load_alone(&path).expect("read").series.time;
    assert_eq!(time[0], 0.0);
    for (row, time) in time.iter().enumerate() {
        // An f64 of this size would leave 2.4e-7.
        assert!((time - row as f64 * 0.001).abs() < 1e-15, "row {row}: {time}");
    }
    // Across a full second too.
    let path = folder.put("run.csv", timed(|row| format!("{}.{:06}", EPOCH + row as i64 / 100, row % 100 * 10_000)));
    let time = dataset::load_alone(&path).expect("read").series.time;
    assert!((time[150] - 1.5).abs() < 1e-15, "{}", time[150]);
}

#[test]
fn regress_a_first_manifest_says_the_unit_of_the_time() {
    let folder = Folder::new();
    for (step, unit, said) in [(1000, "us", "us"), (1_000_000, "ns", "ns"), (80, "ms", "ms or us")] {
        let path = folder.put("run.csv", timed(|row| (row * step).to_string()));
        let output = folder.run(&["data", "run.csv"]);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && text.contains("A manifest to begin with"), "{text}");
        let line =
            format!("[time]\ncolumn = \"time\"\nunit = \"{unit}\"  # guess: by its steps in {said}, and not in s?\n");
        assert!(text.contains(&line), "{text}");
        let table = dataset::read_table(&path).expect("read");
        let manifest = folder.put("turn.toml", dataset::first_manifest(&table, "run.csv", None));
        assert_eq!(dataset::load_alone(&manifest).expect("read").series.len(), 200);
    }
}

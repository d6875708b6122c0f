//! Comma-separated values.

use std::time::Instant;

use super::support::recordings::{changed, csv, run_csv};
use super::{Folder, each_is_refused};

fn utf16(text: &str, mark: bool, little_endian: bool) -> Vec<u8> {
    let units = mark.then_some(0xfeff).into_iter().chain(text.encode_utf16());
    units.flat_map(|unit| if little_endian { unit.to_le_bytes() } else { unit.to_be_bytes() }).collect()
}

#[test]
fn regress_text_of_another_encoding_is_recognised() {
    let good = run_csv();
    let mut latin = good.clone().into_bytes();
    let at = good.find("\n0.003,").expect("a row") + 7;
    latin[at] = 0xb5;
    each_is_refused(
        "run.csv",
        &[
            (good.replacen("\n0.003,", "\n0.003,\0", 1).into_bytes(), &["run.csv:5: character = a NUL byte"][..]),
            (good.replacen("time", "ti\0me", 1).into_bytes(), &["run.csv:1: character = a NUL byte"]),
            ((good.clone() + "\0").into_bytes(), &["run.csv:202: character = a NUL byte"]),
            (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec(), &["character = a NUL byte", "binary"]),
            (latin, &["row 4", "turn.position = \u{fffd}", "a number with a decimal point"]),
        ],
    );
    let folder = Folder::new();
    folder.put("run.csv", [b"\xef\xbb\xbf", good.as_bytes()].concat());
    folder.reads("run.csv", &["200 samples", "joints turn"]);
    for (mark, little_endian) in [(true, true), (true, false), (false, true), (false, false)] {
        folder.put("run.csv", utf16(&good, mark, little_endian));
        folder.reads("run.csv", &["200 samples", "joints turn"]);
    }
    // Half a character at the end belongs to the row that is cut off.
    let cut = utf16(&good, true, true);
    folder.put("run.csv", &cut[..cut.len() - 3]);
    folder.reads("run.csv", &["199 samples", "row 200", "cut off"]);
}

#[test]
fn regress_line_ends_of_every_kind_are_read() {
    let folder = Folder::new();
    for end in ["\r\n", "\r", "\n\n", "\r\r\n"] {
        folder.put("run.csv", run_csv().replace('\n', end));
        folder.reads("run.csv", &["200 samples", "joints turn"]);
    }
    folder.put("run.csv", changed("\n0.003,", "\r\n0.003,").replacen("\n0.005,", "\r0.005,", 1));
    folder.reads("run.csv", &["200 samples", "joints turn"]);
}

#[test]
fn regress_a_header_that_is_none_is_refused() {
    let rows = run_csv().split_once('\n').expect("a header").1.to_owned();
    let long = "x".repeat(10_000);
    each_is_refused(
        "run.csv",
        &[
            (String::new(), &["size = 0 bytes", "not empty"]),
            ("\n\n\n".into(), &["run.csv:1: header"]),
            ("time,turn.position\n".into(), &["rows = 0", "at least 2 rows"]),
            ("time,turn.position\n0,1\n".into(), &["rows = 1", "at least 2 rows"]),
            (rows, &["columns = 1, 2, 3", "no names for its columns", "manifest"]),
            ("{\"time\": [0.0]}\n".into(), &["rows = 1", "at least 2 rows"]),
            ("<!DOCTYPE html>\n<html></html>\n".into(), &["run.csv:1: header = <!DOCTYPE html>"]),
            (csv("time,turn.position,time"), &["run.csv:1: column = time", "once"]),
            (csv("time,turn.position,turn.position"), &["run.csv:1: column = turn.position", "once"]),
            (csv("time,turn.torque,turn.effort"), &["run.csv:1: column = turn.effort", "once"]),
            (csv("time,turn.position,turn.force"), &["run.csv:1: column = turn.force", "torque"]),
            (csv("time,turn.position,turn.angle"), &["run.csv:1: column = turn.angle", "position"]),
            (csv("x,turn.position,turn.torque"), &["time = (missing)", "turn.position"]),
            (csv("time,arm.position,arm.torque"), &["columns = time, arm.position", "joints turn", "manifest"]),
            (csv("time,turn.position,\u{1b}[2Jx"), &["run.csv:1: column = \\u{1b}[2Jx", "without control characters"]),
            (csv(&format!("time,{long},{long}")), &["run.csv:1: column = xxxx", "once"]),
        ],
    );
}

/// Rows of numbers with every delimiter; a decimal comma where the delimiter leaves it.
#[test]
fn regress_every_delimiter_is_read_and_units_below_the_header_count() {
    let folder = Folder::new();
    for delimiter in [";", "\t", "|", "  ", " \t "] {
        folder.put("run.csv", run_csv().replace(',', delimiter));
        folder.reads("run.csv", &["200 samples", "joints turn"]);
        folder.put("run.csv", run_csv().replace(',', delimiter).replace('.', ",").replacen("turn,", "turn.", 2));
        folder.reads("run.csv", &["200 samples", "joints turn"]);
    }
    folder.put("run.csv", changed("turn.torque\n", "turn.torque\n[ms],[deg],[mNm]\n").replace("\n0.", "\n"));
    let session = lostmotion::dataset::load_alone(&folder.path("run.csv")).expect("read");
    assert!((session.series.time[150] - 0.150).abs() < 1e-15, "{}", session.series.time[150]);
    let expected = lostmotion::units::DEG * (20.0_f64 * 0.15).sin();
    let position = session.series.joints[0].get(lostmotion::timeseries::Channel::Position).expect("a position");
    assert!((position[150] - expected).abs() < 1e-15, "{}", position[150]);
    let unknown = changed("turn.torque\n", "turn.torque\ns,counts,Nm\n");
    each_is_refused("run.csv", &[(unknown, &["run.csv:1: column = turn.position", "not counts"])]);
}

#[test]
fn regress_a_row_that_does_not_fit_is_refused_by_its_number() {
    each_is_refused(
        "run.csv",
        &[
            (changed("\n0.003,", "\n0.003,1,"), &["row 4", "fields = 4", "3 fields"]),
            (changed("\n0.003,", "\n"), &["row 4", "fields = 2", "3 fields"]),
            (changed("\n0.003,", "\n0.003;"), &["row 4", "fields = 2", "3 fields"]),
            (changed("\n0.003,", "\n0.003,\""), &["run.csv:5: quote", "never closed"]),
            (changed("\n0.199,", "\n0.199,\""), &["run.csv:201: quote", "never closed"]),
            (changed("time,", "\"time,"), &["run.csv:1"]),
            (changed("\n0.003,", "\n\"0,003\","), &["row 4", "time = 0,003", "decimal point"]),
            (changed("\n0.003,", "\n0.003,two"), &["row 4", "turn.position = two", "number"]),
            (changed("\n0.003,", "\n0.003,0x"), &["row 4", "turn.position = 0x", "number"]),
            (changed("\n0.003,", "\n3.0D-03,"), &["row 4", "time = 3.0D-03", "number"]),
            (changed("\n0.003,", "\n1 000,"), &["row 4", "time = 1 000", "number"]),
            (changed("\n0.003,", "\n,"), &["row 4", "time = (empty)", "number"]),
            (changed("\n0.003,", "\nNaN,"), &["row 4", "time = NaN", "finite"]),
            (changed("\n0.003,", "\n-inf,"), &["row 4", "time = -inf", "finite"]),
            (changed("\n0.003,", "\n1e400,"), &["row 4", "time = inf", "finite"]),
            (changed("\n0.003,", "\n0.002,"), &["row 4", "time = 0.002", "repeated"]),
            (changed("\n0.003,", "\n0.001,"), &["row 4", "time = 0.001", "backwards"]),
        ],
    );
    let short: String =
        run_csv()
            .lines()
            .enumerate()
            .map(|(line, text)| {
                if line > 150 {
                    format!("{},0,\n", text.split_once(',').expect("a time").0)
                } else {
                    format!("{text}\n")
                }
            })
            .collect();
    each_is_refused("run.csv", &[(short, &["row 151", "turn.torque = 150 samples", "shorter than the rest"])]);
}

#[test]
fn regress_a_pause_is_reported_with_its_row() {
    let folder = Folder::new();
    folder.put("run.csv", changed("\n0.199,", "\n9.199,"));
    folder.reads("run.csv", &["row 200", "time: a pause of 9.0010e0 s"]);
}

#[test]
fn regress_a_position_that_jumps_out_of_reach_is_refused_by_row_and_column() {
    // A row between two good ones.
    let jumps = changed("\n0.003,", "\n0.003,1e5,0\n0.0039,");
    each_is_refused("run.csv", &[(jumps, &["row 4", "turn.position = 1e5", "no machine is as fast"])]);
}

#[test]
fn regress_numbers_beyond_physical_sense_are_refused_by_row_and_column() {
    let with = |channel: &str, value: &str| {
        changed("\n0.003,", &format!("\n0.003,{value}")).replacen("turn.position", &format!("turn.{channel}"), 1)
    };
    // The digits of the good value follow those that are put before it.
    let cases = [
        ("position", "1e30", "1e8 [rad]"),
        ("velocity", "-1e20", "1e7 [rad/s]"),
        ("reference_position", "1e20", "[rad]"),
        ("reference_velocity", "1e20", "[rad/s]"),
        ("link_position", "1e20", "[rad]"),
        ("current", "1e15", "1e7 [A]"),
        ("command_current", "1e15", "[A]"),
        ("temperature", "-30", "[°C]"),
    ];
    let folder = Folder::new();
    for (channel, value, unit) in cases {
        let value = format!("{value}0,1\n0.0035,");
        folder.put("run.csv", with(channel, &value).replace("0.0035,", "0.0039,"));
        folder.refuses_data("run.csv", &["run.csv: row 4", &format!("turn.{channel} = "), unit, "no machine"]);
    }
    folder.put("run.csv", changed("\n0.003,", "\n0.003,0,1e300\n0.0039,"));
    folder.refuses_data("run.csv", &["run.csv: row 4", "turn.torque = 1e300", "1e10 [N·m]"]);
}

#[test]
fn regress_a_line_without_end_is_refused() {
    const LONG: usize = 17 << 20;
    each_is_refused(
        "run.csv",
        &[
            ("x".repeat(LONG), &["run.csv:1: length of the row = above 16 MiB"][..]),
            (",".repeat(LONG), &["run.csv:1: length of the row = above 16 MiB"]),
            (run_csv() + &",".repeat(LONG), &["run.csv:202: length of the row = above 16 MiB", "quote"]),
            (run_csv() + "0.2,\"" + &"1\n".repeat(LONG / 2), &["length of the row = above 16 MiB", "never closed"]),
            ("time".to_owned() + &",".repeat(150_000) + "\n", &["run.csv:1: columns = 150001", "at most 100000"]),
        ],
    );
}

#[test]
fn regress_many_columns_and_many_joints_take_linear_time() {
    let folder = Folder::new();
    let table = |names: Vec<String>| {
        let row = |time: &str| format!("{time}{}\n", ",0.5".repeat(names.len()));
        format!("time,{}\n{}{}{}", names.join(","), row("0"), row("0.001"), row("0.002"))
    };
    let joints: Vec<String> =
        (0..3000).flat_map(|joint| [format!("j{joint}.position"), format!("j{joint}.torque")]).collect();
    let foreign: Vec<String> = (0..60_000).map(|column| format!("column_{column}")).collect();
    for (names, said) in [(joints, "3 samples, joints j0, j1"), (foreign.clone(), "")] {
        folder.put("run.csv", table(names));
        let start = Instant::now();
        if said.is_empty() {
            folder.refuses(&["check", "run.csv"], &["run.csv: columns = time, column_0", "and 59989 more"]);
            folder.refuses_data("run.csv", &["run.csv: columns = time, column_0", "joints turn"]);
        } else {
            // The answer is longer than a pipe holds: only whether it comes is asked here.
            let start = Instant::now();
            let session = lostmotion::dataset::load_alone(&folder.path("run.csv")).expect("read");
            assert_eq!(session.series.joints.len(), 3000);
            let table = lostmotion::dataset::read_table(&folder.path("run.csv")).expect("read");
            let survey =
                lostmotion::dataset::survey(&table) + &lostmotion::dataset::first_manifest(&table, "run.csv", None);
            assert!(survey.contains("[joints.j2999]"));
            assert!(start.elapsed().as_secs_f64() < 5.0, "{:?}", start.elapsed());
        }
        // Measured: 0.1 s; what is quadratic takes minutes.
        assert!(start.elapsed().as_secs_f64() < 5.0, "{:?}", start.elapsed());
    }
    let table = lostmotion::dataset::parse_table("run.csv".as_ref(), table(foreign).as_bytes()).expect("read");
    let start = Instant::now();
    assert!(lostmotion::dataset::first_manifest(&table, "run.csv", None).contains("and 59988 more"));
    assert!(start.elapsed().as_secs_f64() < 5.0, "{:?}", start.elapsed());
}

//! Text as it is saved: UTF-16 and byte order marks are read; devices, pipes, folders and files without end are not.

use std::process::Command;

use super::files::{Files, MODEL, SCENARIO, URDF};

fn wide(text: &str, order: fn(u16) -> [u8; 2]) -> Vec<u8> {
    std::iter::once(0xFEFF).chain(text.encode_utf16()).flat_map(order).collect()
}

#[test]
fn regress_utf16_of_both_byte_orders_is_read() {
    let declared = URDF.replacen("version=\"1.0\"", "version=\"1.0\" encoding=\"UTF-16\"", 1);
    for order in [u16::to_le_bytes, u16::to_be_bytes] {
        let files = Files::new();
        files.put("model.toml", wide(&MODEL.replace('\n', "\r\n"), order));
        files.put("robot.urdf", wide(&declared, order));
        files.put("scenario.toml", wide(SCENARIO, order));
        let output = files.lostmotion(&["check", "model.toml", "scenario.toml", "robot.urdf"]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        // What is wrong in it is found on its line.
        files.put("model.toml", wide(&MODEL.replace("gear_ratio = 5.0", "gear_ratio = 0"), order));
        let place = "model.toml:7: joints.turn.gear_ratio = 0";
        files.refused(&["check", "model.toml"], place, &["from 1e-4"]).unwrap_or_else(|fault| panic!("{fault}"));
    }
    let files = Files::new();
    files.put("model.toml", format!("\u{FEFF}{MODEL}"));
    files.put("robot.urdf", format!("\u{FEFF}{URDF}"));
    assert_eq!(files.lostmotion(&["check", "model.toml", "robot.urdf"]).status.code(), Some(0));
}

#[test]
fn regress_text_in_other_encodings_is_refused_in_plain_words() {
    let without_mark: Vec<u8> = MODEL.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let latin = [b"# Gelenk f\xFCr\n", MODEL.as_bytes()].concat();
    let mut odd = wide(MODEL, u16::to_le_bytes);
    odd.pop();
    let lone = [wide("a = 1\n", u16::to_le_bytes), vec![0x00, 0xD8, 0x41, 0x00]].concat();
    let cases: [(&[u8], &str, &str); 5] = [
        (&without_mark, "model.toml:1: expected UTF-8 text", "byte order mark"),
        (&latin, "model.toml:1: expected UTF-8 text", ""),
        (&odd, "model.toml:58: expected UTF-16 text", "byte order mark"),
        (&lone, "model.toml:2: expected UTF-16 text", "byte order mark"),
        (b"\0", "model.toml:1: expected UTF-8 text", "zero bytes"),
    ];
    for (bytes, place, part) in cases {
        let files = Files::new();
        files.put("model.toml", bytes);
        files.refused(&["check", "model.toml"], place, &[part]).unwrap_or_else(|fault| panic!("{fault}"));
    }
}

#[cfg(unix)]
#[test]
fn regress_devices_pipes_and_folders_are_refused_at_once() {
    let files = Files::new();
    for (name, target) in [("zero.toml", "/dev/zero"), ("zero.urdf", "/dev/zero")] {
        std::os::unix::fs::symlink(target, files.path(name)).expect("a link");
    }
    assert!(Command::new("mkfifo").arg(files.path("pipe.toml")).status().expect("mkfifo").success());
    std::fs::create_dir(files.path("folder.toml")).expect("a folder");
    for name in ["zero.toml", "zero.urdf", "pipe.toml", "folder.toml"] {
        files.refused(&["check", name], name, &["a regular file"]).unwrap_or_else(|fault| panic!("{fault}"));
    }
    for name in ["zero.toml", "pipe.toml"] {
        let run = ["run", name, "--out", "out"];
        files.refused(&run, name, &["a regular file"]).unwrap_or_else(|fault| panic!("{fault}"));
    }
    files.change("model.toml", &("robot.urdf", "zero.urdf", "", &[]));
    files.refused(&["check", "model.toml"], "zero.urdf", &["a regular file"]).unwrap_or_else(|fault| panic!("{fault}"));
}

/// Files of very many values, names without end and deep nesting: an answer in time.
#[test]
fn regress_large_files_are_refused_in_time() {
    let files = Files::new();
    let many: String = (0..60_000).map(|k| format!("[joints.a{k}]\ngear_ratio = 1\n")).collect();
    let cases: [(String, &str, &str); 5] = [
        (MODEL.to_owned() + &many, "model.toml", "at most 128 joints"),
        (format!("{MODEL}\n[x]\n{}", "a = 1\n".repeat(500_000)), "model.toml", "at most 2 MiB"),
        (format!("{} = 1\n{MODEL}", "n".repeat(1_000_000)), "model.toml", "unknown key"),
        (format!("x = {}1{}\n{MODEL}", "[".repeat(100_000), "]".repeat(100_000)), "model.toml:1", "TOML"),
        (format!("name2 = \"{}\"\n{MODEL}", "n".repeat(1_000_000)), "model.toml:1: name2", "unknown key"),
    ];
    for (text, place, part) in cases {
        files.put("model.toml", text);
        files
            .refused(&["check", "model.toml"], place, &[part])
            .unwrap_or_else(|fault| panic!("{}", &fault[..fault.len().min(500)]));
    }
    // What relates links to each other grows with their square.
    let links: String = (0..20_000).map(|k| format!("<link name=\"l{k}\"/>\n")).collect();
    files.put("robot.urdf", format!("<robot name=\"a\">\n{links}</robot>\n"));
    files
        .refused(&["new", "robot.urdf", "--out", "new.toml"], "robot.urdf:2002", &["at most 2000 elements <link>"])
        .unwrap_or_else(|fault| panic!("{fault}"));
    let files = Files::new();
    let places = vec!["1,0"; 60_000].join(",");
    files.change("scenario.toml", &("positions_deg = [5, 0]", "positions_deg = [PLACES]", "", &[]));
    let text = std::fs::read_to_string(files.path("scenario.toml")).expect("text").replace("PLACES", &places);
    files.put("scenario.toml", text);
    let place = "scenario.toml:17: session[1].joints.turn.positions_deg";
    files
        .refused(&["check", "scenario.toml"], place, &["at most 100000 positions"])
        .unwrap_or_else(|fault| panic!("{fault}"));
}

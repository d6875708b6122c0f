//! Manifests.

use super::Folder;
use super::support::recordings::csv;

const MANIFEST: &str = r#"schema = "lostmotion/dataset/1"
file = "raw.csv"
[time]
column = "t"
[joints.turn]
position = { column = "angle", unit = "deg" }
torque = { column = "load", scale = 2.0 }
"#;

#[test]
fn regress_broken_manifests_are_refused_by_line_and_key() {
    // What is replaced by what, and what the message has to say.
    let cases: &[(&str, &str, &[&str])] = &[
        ("\"angle\"", "\"angel\"", &["turn.toml:6: joints.turn.position.column = angel", "angle"]),
        ("unit = \"deg\"", "unit = \"rpm\"", &["turn.toml:6: joints.turn.position.unit = \"rpm\"", "rad, deg"]),
        ("unit = \"deg\"", "unit = \"\"", &["turn.toml:6: joints.turn.position.unit", "rad, deg"]),
        ("unit = \"deg\"", "unit = 3", &["turn.toml:6: joints.turn.position.unit = 3", "text in quotes"]),
        ("scale = 2.0", "scale = 0", &["turn.toml:7: joints.turn.torque.scale = 0", "other than zero"]),
        ("scale = 2.0", "scale = 1e300", &["turn.toml:7: joints.turn.torque.scale = 1e300", "1e-16 to 1e16"]),
        ("scale = 2.0", "scale = -1e-300", &["turn.toml:7: joints.turn.torque.scale = -1e-300", "1e-16 to 1e16"]),
        ("scale = 2.0", "scale = nan", &["turn.toml:7: joints.turn.torque.scale = nan", "finite"]),
        ("scale = 2.0", "scale = \"2\"", &["turn.toml:7: joints.turn.torque.scale = \"2\"", "number"]),
        ("scale = 2.0", "scael = 2.0", &["turn.toml:7: joints.turn.torque.scael", "`scale`"]),
        ("joints.turn", "joints.spin", &["turn.toml:5: joints = spin", "turn"]),
        ("torque =", "force =", &["turn.toml:7: joints.turn.force", "torque"]),
        ("torque =", "tork =", &["turn.toml:7: joints.turn.tork", "`torque`"]),
        ("torque =", "effort =", &[]),
        ("file = \"raw.csv\"", "file = \"gone.csv\"", &["turn.toml:2: file = \"gone.csv\"", "LOSTMOTION_DATA"]),
        ("file = \"raw.csv\"", "file = \"\"", &["turn.toml:2: file", "LOSTMOTION_DATA"]),
        ("file = \"raw.csv\"", "file = \".\"", &["turn.toml:2: file = \".\""]),
        ("file = \"raw.csv\"", "file = \"/dev/zero\"", &["turn.toml:2: file = \"/dev/zero\""]),
        ("file = \"raw.csv\"", "file = \"turn.toml\"", &["turn.toml:1: header"]),
        ("file = \"raw.csv\"", "", &["turn.toml:1: file", "missing"]),
        ("[time]\ncolumn = \"t\"", "", &["turn.toml:1: time", "missing"]),
        ("column = \"t\"", "", &["turn.toml:3: time.column", "missing"]),
        ("column = \"t\"", "column = \"tt\"", &["turn.toml:4: time.column = tt", "t, angle, load"]),
        ("column = \"t\"", "column = \"t\"\nunit = \"mm\"", &["turn.toml:5: time.unit = \"mm\"", "s, ms, us, ns, d"]),
        ("dataset/1", "dataset/2", &["turn.toml:1: schema", "lostmotion/dataset/1"]),
        ("schema = \"lostmotion/dataset/1\"", "", &["turn.toml:1: schema", "missing"]),
        ("[time]", "[tim]", &["turn.toml:1: time", "missing"]),
        ("[time]", "[time", &["turn.toml:3: expected TOML"]),
        ("\"load\"", "\"angle\"", &[]),
        ("[joints.turn]", "[joints.turn]\nvelocity = 3", &["turn.toml:6: joints.turn.velocity = 3", "table"]),
        ("[joints.turn]", "[joints.turn.controller]\nposition_gain = 1\n[joints.turn]", &["joints.turn.controller"]),
        ("\"raw.csv\"", "\"\\u001b[2J.csv\"", &["turn.toml:2: file"]),
    ];
    let folder = Folder::new();
    folder.put("raw.csv", csv("t,angle,load"));
    folder.put("turn.toml", MANIFEST);
    folder.reads("turn.toml", &["200 samples", "joints turn"]);
    for (from, to, parts) in cases {
        let broken = MANIFEST.replacen(from, to, 1);
        assert_ne!(MANIFEST, broken, "{from}");
        folder.put("turn.toml", &broken);
        if parts.is_empty() {
            assert!(folder.replay("turn.toml").status.code() != Some(2), "{from} → {to} is allowed");
            std::fs::remove_dir_all(folder.path("out")).expect("its results");
        } else {
            folder.refuses_data("turn.toml", parts);
        }
    }
    folder.put("turn.toml", [MANIFEST.as_bytes(), b"# \xff\n"].concat());
    folder.refuses_data("turn.toml", &["turn.toml:8", "UTF-8"]);
}

#[test]
fn regress_numbers_of_a_scale_that_is_off_name_the_row() {
    let folder = Folder::new();
    folder.put("raw.csv", csv("t,angle,load"));
    folder.put("turn.toml", MANIFEST.replace("scale = 2.0", "scale = 1e15"));
    folder.refuses_data("turn.toml", &["raw.csv: row 2", "load = -", "[N·m]", "no machine"]);
}

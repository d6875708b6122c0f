//! Names that files hold never become paths.

use std::fs;
use std::path::Path;

use lostmotion::files::{catalogue, embedded, is_file, is_fit_name};

use super::fixture::{Files, MODEL, SCENARIO, done, refused};

/// An obstacle of the scenario.
const OBSTACLE: &str = "\n[[obstacles]]\nname = \"post\"\nshape = \"sphere\"\nradius = 0.01\nxyz = [0.5, 0.0, 0.0]\n";

/// Names that no folder bears, or that lead out of it, as TOML spells them.
const UNFIT: [&str; 14] = [
    "../victim",
    "../../../victim",
    "/nowhere/victim",
    "a/b",
    "a\\\\b",
    ".",
    "..",
    "",
    ".hidden",
    "a\\nb",
    "a\\u0000b",
    "a\\u001b[2Jb",
    "a\\u202eb",
    " a",
];

fn scenario() -> String {
    SCENARIO.to_owned() + OBSTACLE
}

#[test]
fn regress_names_that_are_paths_are_refused_with_place_and_key() {
    let files = Files::new();
    files.put("victim/mine.txt", "mine");
    files.put("victim.csv", "mine");
    files.put("work/robot.urdf", files.text("robot.urdf"));
    files.put("work/model.toml", MODEL);
    files.put("work/scenario.toml", scenario());
    done(
        &files
            .command(&["run", "scenario.toml", "--quiet", "--csv", "--out", "../good"])
            .current_dir(files.path("work"))
            .output()
            .unwrap(),
    );
    let long = "x".repeat(201);
    let before = files.snapshot("");
    for unfit in UNFIT.iter().copied().chain([long.as_str()]) {
        for (file, good, place, key) in [
            ("model.toml", "name = \"turntable\"", "model.toml:2", "name = "),
            ("scenario.toml", "name = \"to_and_fro\"", "scenario.toml:2", "name = "),
            ("scenario.toml", "name = \"first\"", "scenario.toml:7", "session[1].name = "),
            ("scenario.toml", "name = \"post\"", "scenario.toml:33", "obstacles[1].name = "),
        ] {
            let text = files.text(&format!("work/{file}"));
            assert!(text.contains(good));
            files.put(&format!("work/{file}"), text.replacen(good, &format!("name = \"{unfit}\""), 1));
            let run = ["run", "scenario.toml", "--quiet", "--csv"];
            refused(
                &files.command(&run).current_dir(files.path("work")).output().unwrap(),
                &[place, key, "expected a name"],
            );
            refused(&files.command(&["check", file]).current_dir(files.path("work")).output().unwrap(), &[place, key]);
            files.put(&format!("work/{file}"), text);
        }
    }
    for verb in ["identify", "diagnose", "replay"] {
        files.put("model.toml", MODEL.replace("\"turntable\"", "\"../../../victim\""));
        let output = files.lostmotion(&[verb, "--quiet", "--model", "model.toml", "--data", "run.csv"]);
        refused(&output, &["model.toml:2", "name = \"../../../victim\""]);
        files.put("model.toml", MODEL);
    }
    let set = ["run", "scenario.toml", "--quiet", "--set", "name=../victim"];
    refused(&files.lostmotion(&set), &["scenario.toml", "name = ../victim"]);
    assert_eq!(files.snapshot(""), before);
}

#[test]
fn regress_a_scenario_on_recordings_has_a_fit_name() {
    let files = Files::new();
    let text = "schema = \"lostmotion/scenario/1\"\nname = \"../victim\"\nprocedure = \"diagnose\"\nrobot = \"model.toml\"\n\
                data = [\"run.csv\"]\n[expect]\neffects = []\n";
    files.put("recorded.toml", text);
    let before = files.names("");
    refused(&files.lostmotion(&["run", "recorded.toml", "--quiet"]), &["recorded.toml:2", "name = \"../victim\""]);
    assert_eq!(files.names(""), before);
}

#[test]
fn regress_two_sessions_of_one_name_are_refused() {
    let files = Files::new();
    for (second, taken) in [("first", "`first`"), ("First", "`First`")] {
        files.put("scenario.toml", SCENARIO.replace("\"second\"", &format!("\"{second}\"")));
        let output = files.run("results", "1");
        refused(&output, &["scenario.toml:16", "session[2].name", "no other session has", taken]);
        assert!(!files.path("results").exists());
    }
    // A session without a name is called by its number.
    files.put("scenario.toml", SCENARIO.replace("name = \"first\"\n", "").replace("\"second\"", "\"session1\""));
    refused(&files.run("results", "1"), &["session[2].name", "`session1`"]);
}

#[test]
fn regress_two_obstacles_of_one_name_are_refused() {
    let files = Files::new();
    files.put("scenario.toml", scenario() + OBSTACLE);
    refused(&files.run("results", "1"), &["scenario.toml:39", "obstacles[2].name", "no other obstacle"]);
}

/// The catalogue's robot `scara` with its URDF under another name, and the scenario that identifies it.
fn scara(files: &Files, urdf: &str) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    fs::copy(root.join("robots/scara/scara.urdf"), files.path(urdf)).unwrap();
    let model = fs::read_to_string(root.join("robots/scara/model.toml")).unwrap();
    assert!(model.contains("\"scara.urdf\""));
    files.put("model.toml", model.replace("\"scara.urdf\"", &format!("{urdf:?}")));
    let scenario = fs::read_to_string(root.join("scenarios/01_identify_scara/scenario.toml")).unwrap();
    files.put("scenario.toml", scenario.replace("../../robots/scara/model.toml", "model.toml"));
}

#[test]
fn regress_a_urdf_named_as_a_report_replaces_no_report() {
    for (urdf, copy) in
        [("report.json", "report.urdf"), ("model.toml.urdf", "model.toml.urdf"), (".hidden.urdf", "robot.urdf")]
    {
        let files = Files::new();
        scara(&files, urdf);
        done(&files.lostmotion(&["run", "scenario.toml", "--quiet", "--out", "results"]));
        assert!(files.text("results/report.json").starts_with("{\n  \"schema\": \"lostmotion/identification/1\""));
        assert_eq!(files.text(&format!("results/{copy}")), files.text(urdf));
        assert!(files.text("results/model.toml").contains(&format!("urdf = \"{copy}\"")));
        done(&files.lostmotion(&["check", "results/model.toml"]));
    }
}

#[test]
fn regress_a_first_model_of_a_robot_with_an_odd_name_is_accepted() {
    let files = Files::new();
    let urdf = files.text("robot.urdf");
    for odd in ["../../victim", "", ".", "abb/irb"] {
        files.put("first/arm.urdf", urdf.replace("name=\"turntable\"", &format!("name=\"{odd}\"")));
        done(&files.lostmotion(&["new", "first/arm.urdf"]));
        assert!(files.text("first/model.toml").contains("name = \"arm\""));
        done(&files.lostmotion(&["check", "first/model.toml"]));
        fs::remove_file(files.path("first/model.toml")).unwrap();
    }
}

#[test]
fn property_a_fit_name_is_one_part_of_a_path() {
    for name in ["scara", "KUKA KR300 R2500", "v1.2", "Übung-3_β", "a..b", &"x".repeat(200)] {
        assert!(is_fit_name(name), "{name}");
        assert_eq!(Path::new(name).components().count(), 1, "{name}");
    }
    let long = "x".repeat(201);
    for name in ["", ".", "..", ".git", "a/b", "/a", "a/", "..\\a", "a\nb", "a\0", "\u{202e}a", " a", "a ", &long] {
        assert!(!is_fit_name(name), "{name:?}");
    }
}

#[test]
fn property_paths_of_the_catalogue_lead_to_its_files_and_to_nothing_else() {
    let scenario = catalogue::path("scenarios/01_identify_scara/scenario.toml");
    let model = scenario.parent().unwrap().join("../../robots/scara/model.toml");
    let on_disk = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/scara/model.toml")).unwrap();
    assert_eq!(embedded(&model).unwrap().unwrap(), on_disk);
    assert!(is_file(&scenario) && !is_file(&catalogue::path("robots")));
    for nowhere in ["robots/gone/model.toml", "../../../../etc/passwd", ""] {
        assert_eq!(embedded(&catalogue::path(nowhere)).unwrap().unwrap_err().kind(), std::io::ErrorKind::NotFound);
        assert!(!is_file(&catalogue::path(nowhere)));
    }
}

//! Broken files: an error that names the place, or at least no panic.

use lostmotion::dynamics::Dynamics;
use lostmotion::error::Result;
use lostmotion::robot::Model;
use rand::RngExt;

use super::support::random;
use super::{MODEL, URDF, texts};

/// Every change of a table must be refused with its message, to the letter; all that differ are shown.
fn all_refused(text: &str, table: &[(&str, &str, &str)], read: impl Fn(&str) -> Result<Model>) {
    let mut wrong = Vec::new();
    for &(sound, broken, message) in table {
        assert!(text.contains(sound), "{sound}");
        let found = read(&text.replacen(sound, broken, 1)).expect_err(broken).to_string();
        if found != message {
            wrong.push(format!("{broken}\n  found    {found}\n  expected {message}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A model file with one change, and the message that it must be refused with.
const BROKEN_MODELS: &[(&str, &str, &str)] = &[
    (
        "lostmotion/model/1",
        "lostmotion/model/9",
        "elbow/model.toml:2: schema = \"lostmotion/model/9\": expected \"lostmotion/model/1\"",
    ),
    ("schema = \"lostmotion/model/1\"\n", "", "elbow/model.toml:1: schema: expected \"lostmotion/model/1\" (missing)"),
    (
        "gear_ratio = 100.0",
        "gear_ratio = -100.0",
        "elbow/model.toml:7: joints.shoulder.gear_ratio = -100.0: expected a number from 1e-4 to 1e6 [rad/rad]",
    ),
    (
        "gear_ratio = 100.0\n",
        "",
        "elbow/model.toml:6: joints.shoulder.gear_ratio: expected a number from 1e-4 to 1e6 [rad/rad] (missing)",
    ),
    (
        "gear_stiffness = 15000.0 ",
        "gear_stifness = 15000.0 ",
        "elbow/model.toml:9: joints.shoulder.gear_stifness = 15000.0: expected the key `gear_stiffness` (unknown key)",
    ),
    (
        "gear_damping = 25.0 ",
        "gear_dampin = 25.0 ",
        "elbow/model.toml:10: joints.shoulder.gear_dampin = 25.0: expected the key `gear_damping` (unknown key)",
    ),
    (
        "resistance = 0.9 ",
        "resistance = nan ",
        "elbow/model.toml:15: joints.shoulder.motor.resistance = nan: expected a number > 0 and ≤ 1e6 [Ω]",
    ),
    (
        "resistance = 0.9                    # [Ω]\n",
        "",
        "elbow/model.toml:15: joints.shoulder.motor.inductance = 0.0008: expected a `resistance` beside it",
    ),
    (
        "counts_per_turn = 2000 ",
        "counts_per_turn = \"2000\" ",
        "elbow/model.toml:23: joints.shoulder.encoder.counts_per_turn = \"2000\": expected a number from 1 to 1e11 [1/turn]",
    ),
    (
        "method = \"pulse_period\"",
        "method = \"pulses\"",
        "elbow/model.toml:26: joints.shoulder.velocity_sensor.method = \"pulses\": expected \"pulse_period\" or \"low_pass\"",
    ),
    (
        "coulomb = [2.0, 2.2]",
        "coulomb = [2.0, -2.2]",
        "elbow/model.toml:33: joints.shoulder.friction.coulomb = [2.0, -2.2]: expected a number from 0 to 1e9 [N·m], or two of them, [positive, negative]",
    ),
    (
        "stribeck_velocity = [0.030, 0.028]\n",
        "",
        "elbow/model.toml:32: joints.shoulder.friction.stribeck_velocity: expected a number from 1e-9 to 10000 [rad/s], or two of them, [positive, negative] (missing)",
    ),
    (
        "link_share = 0.1",
        "link_share = 1.1",
        "elbow/model.toml:37: joints.shoulder.friction.link_share = 1.1: expected a number from 0 to 1 [1]",
    ),
    (
        "[joints.elbow]",
        "[joints.elbw]",
        "elbow/model.toml:39: joints.elbw: expected a joint of elbow/elbow.urdf: a movable joint of it, such as elbow",
    ),
    (
        "[joints.elbow]",
        "[joints.tool_mount]",
        "elbow/model.toml:39: joints.tool_mount: expected a joint of elbow/elbow.urdf: one of its movable joints shoulder, elbow",
    ),
    ("urdf = \"elbow.urdf\"", "urdf = 3", "elbow/model.toml:4: urdf = 3: expected text in quotes"),
    (
        "urdf = \"elbow.urdf\"",
        "urdf = \"elbow.urdf\"\ngravity = [0, 0]",
        "elbow/model.toml:5: gravity = [0, 0]: expected a list of 3, each a number from -1000 to 1000 [m/s²]",
    ),
    (
        "urdf = \"elbow.urdf\"",
        "urdf = \"elbow.urdf\"\n[[effects]]\neffect = \"payload\"\njoint = \"elow\"",
        "elbow/model.toml:7: effects[1].joint = \"elow\": expected a joint of this model: elbow",
    ),
    (
        "urdf = \"elbow.urdf\"",
        "urdf = \"elbow.urdf\"\n[[loads]]\nsession = \"loaded\"\nmass = 0",
        "elbow/model.toml:7: loads[1].mass = 0: expected a number > 0 and ≤ 1e6 [kg]",
    ),
    (
        "urdf = \"elbow.urdf\"",
        "urdf = \"elbow.urdf\"\n[[effects]]\neffect = \"payload\"\nmass = \"1 kg\"",
        "elbow/model.toml:7: effects[1].mass = \"1 kg\": expected a finite number [SI]",
    ),
    (
        "coulomb = [2.0, 2.2]",
        "law = \"two_lines\"\na1 = 3\nb1 = 2\na2 = 2\nb2 = 3.0",
        "elbow/model.toml:38: joints.shoulder.friction.breakaway = [2.9, 3.1]: expected one of the keys \
         `a1`, `a2`, `b1`, `b2`, `law`, `link_share` (unknown key)",
    ),
    (
        "coulomb = [2.0, 2.2]",
        "law = \"two_lines\"\na1 = 3\nb1 = 2\na2 = 2\nb2 = 1.0",
        "elbow/model.toml:37: joints.shoulder.friction.b2 = 1.0: expected lines that meet at a speed > 0: (a1 − a2)/(b2 − b1) > 0",
    ),
];

#[test]
fn property_broken_model_files_are_refused_with_place_and_expectation() {
    all_refused(MODEL, BROKEN_MODELS, |text| texts(text, URDF));
}

/// A URDF with one change, and the message that it must be refused with.
const BROKEN_URDFS: &[(&str, &str, &str)] = &[
    (
        "<mass value=\"1.8\"/>",
        "<mass value=\"-1.8\"/>",
        "elbow/elbow.urdf:24: link forearm: mass = -1.8: expected a mass ≥ 0 [kg]",
    ),
    (
        "<mass value=\"1.8\"/>",
        "<mass value=\"1.8 kg\"/>",
        "elbow/elbow.urdf:24: link forearm: mass value = \"1.8 kg\": expected a number",
    ),
    ("<mass value=\"1.8\"/>", "<mass/>", "elbow/elbow.urdf:24: link forearm: mass value: expected a number (missing)"),
    (
        "<origin xyz=\"0 0 -0.40\"/>",
        "<origin xyz=\"0 0 x -0.40\"/>",
        "elbow/elbow.urdf:53: joint elbow: origin xyz = \"0 0 x -0.40\": expected 3 numbers",
    ),
    (
        "<axis xyz=\"0 -1 0\"/>",
        "<axis xyz=\"0 0 0\"/>",
        "elbow/elbow.urdf:47: joint shoulder: axis = 0 0 0: expected an axis that is not zero",
    ),
    (
        "<child link=\"tool\"/>",
        "<child link=\"tol\"/>",
        "elbow/elbow.urdf:59: joint tool_mount: child = tol: expected a link of this file, such as tool",
    ),
    (
        "<child link=\"tool\"/>",
        "<child link=\"forearm\"/>",
        "elbow/elbow.urdf:59: joint tool_mount: child = forearm: expected a link that no other joint moves",
    ),
    (
        "<child link=\"tool\"/>",
        "<child link=\"bracket\"/>",
        "elbow/elbow.urdf:4: link bracket: expected a link connected to the base, not a closed loop",
    ),
    (
        "<link name=\"tool\">",
        "<link name=\"forearm\">",
        "elbow/elbow.urdf:21: link forearm: expected a name that no other link has",
    ),
    ("<link name=\"tool\">", "<link>", "elbow/elbow.urdf:32: link ?: name: expected a name (missing)"),
    (
        "<sphere radius=\"0.035\"/>",
        "<sphere radius=\"-1\"/>",
        "elbow/elbow.urdf:38: link tool: collision = [-1.0]: expected sizes > 0 [m]",
    ),
    ("</robot>", "", "elbow/elbow.urdf:3: URDF: expected a closing </robot>"),
    (
        "<robot name=\"elbow\">",
        "<model name=\"elbow\">",
        "elbow/elbow.urdf:62: URDF: expected </model> for the tag of line 3, not </robot>",
    ),
    ("</joint>", "</joints>", "elbow/elbow.urdf:49: URDF: expected </joint> for the tag of line 43, not </joints>"),
    (
        "<axis xyz=\"0 -1 0\"/>",
        "<axis xyz=\"0 -1 0\"/><mimic joint=\"elbow\"/>",
        "elbow/elbow.urdf:47: joint shoulder: mimic: expected a joint of its own; one that mimics another cannot be listed in the model file",
    ),
    (
        "\"revolute\"",
        "\"hinge\"",
        "elbow/elbow.urdf:43: joint shoulder: type = hinge: expected revolute or continuous or prismatic or fixed or floating or planar or spherical",
    ),
    ("<limit lower", "<limits lower", "elbow/elbow.urdf:48: URDF: expected the element <limit>, not <limits>"),
    ("<parent link=\"bracket\"/>", "", "elbow/elbow.urdf:43: URDF: expected an element <parent> in joint shoulder"),
    ("<mass value=\"1.8\"/>", "", "elbow/elbow.urdf:22: URDF: expected an element <mass> in link forearm"),
    (
        "<mass value=\"1.8\"/>",
        "<mass value=\"1.8\"/>\n<mass value=\"1.8\"/>",
        "elbow/elbow.urdf:25: URDF: expected one element <mass> in link forearm",
    ),
    (
        "<sphere radius=\"0.035\"/>",
        "<cone radius=\"0.035\"/><sphere radius=\"0.035\"/>",
        "elbow/elbow.urdf:40: URDF: expected one box, cylinder, capsule, sphere or mesh in link tool",
    ),
];

#[test]
fn property_broken_urdfs_are_refused_with_place_and_expectation() {
    all_refused(URDF, BROKEN_URDFS, |text| texts(MODEL, text));
    for text in ["", "no tag", "<sdf version='1.9'/>"] {
        let error = texts(MODEL, text).unwrap_err().to_string();
        assert_eq!(error, "elbow/elbow.urdf:1: URDF: expected one outermost element <robot>");
    }
}

#[test]
fn property_missing_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("model.toml");
    let error = Model::load(&file).unwrap_err().to_string();
    assert_eq!(error, format!("{}: cannot read", file.display()));
    std::fs::write(&file, MODEL).unwrap();
    let error = Model::load(&file).unwrap_err().to_string();
    assert_eq!(error, format!("{}:4: urdf = \"elbow.urdf\": expected a file that exists", file.display()));
}

/// Cuts, bytes replaced, lines doubled and dropped: an answer or an error, never a panic.
fn damaged(text: &str, seed: u64) -> String {
    let mut rng = random(seed);
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..rng.random_range(1..4) {
        let (at, to) = (rng.random_range(0..bytes.len()), rng.random_range(0..bytes.len()));
        match rng.random_range(0..5) {
            0 => bytes.truncate(at.max(1)),
            1 => bytes[at] = b"<>/\"'=[]{}.,-+e0 9\n&#\\:"[rng.random_range(0..23)],
            2 => drop(bytes.drain(at.min(to)..at.max(to).min(at.min(to) + 40))),
            3 => {
                let piece = bytes[at.min(to)..at.max(to).min(at.min(to) + 60)].to_vec();
                bytes.splice(at..at, piece);
            }
            _ => bytes[at] = rng.random(),
        }
        if bytes.is_empty() {
            break;
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[test]
fn property_deep_nesting_is_refused_before_the_stack_ends() {
    let deep = format!("<robot>{}{}</robot>", "<a>".repeat(200_000), "</a>".repeat(200_000));
    let error = texts(MODEL, &deep).unwrap_err().to_string();
    assert_eq!(error, "elbow/elbow.urdf:1: URDF: expected at most 64 elements within each other");
    assert!(texts(&"[".repeat(200_000), URDF).is_err());
    assert!(texts(&format!("a = {}", "[".repeat(200_000)), URDF).is_err());
}

#[test]
fn property_damaged_files_never_panic() {
    let runs = std::env::var("LOSTMOTION_FUZZ").ok().and_then(|runs| runs.parse().ok()).unwrap_or(3000);
    for seed in 0..runs {
        let _ = texts(&damaged(MODEL, seed), URDF);
        if let Ok(model) = texts(MODEL, &damaged(URDF, seed)) {
            // Whatever is accepted has dynamics.
            let n = model.robot.dof();
            let mut h = nalgebra::DMatrix::zeros(n, n);
            Dynamics::new(&model.robot).mass_matrix(&vec![0.3; n], &mut h);
            assert!(h.iter().all(|x| x.is_finite()) && (0..n).all(|i| h[(i, i)] > 0.0), "seed {seed}: {h}");
        }
    }
}

//! MJCF beside URDF: the tree, masses and drives of our own models against MuJoCo's numbers (`mujoco.json`, written by `make.py`).

mod meshes;

use std::fs;
use std::path::{Path, PathBuf};

use lostmotion::dynamics::Dynamics;
use lostmotion::plant::first_model;
use lostmotion::robot::Model;
use lostmotion::scenario::trial;
use nalgebra::DMatrix;
use serde_json::Value;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mjcf")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

/// What MuJoCo says of a model.
fn of_mujoco(name: &str) -> Value {
    let text = fs::read_to_string(folder().join("mujoco.json")).unwrap();
    serde_json::from_str::<Value>(&text).unwrap()["models"][name].clone()
}

const MODELS: [&str; 2] = ["arm.xml", "frames.xml"];

#[test]
fn equivalent_mass_matrix_and_weight_are_those_of_mujoco() {
    for name in MODELS {
        let model = first_model(&folder().join(name)).unwrap().model;
        let expected = of_mujoco(name);
        let joints: Vec<&str> = model.joints.iter().map(|joint| joint.name.as_str()).collect();
        let known: Vec<&str> =
            expected["joints"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
        assert_eq!(joints, known, "{name}");
        let n = joints.len();
        let armature = numbers(&expected["armature"]);
        let mut dynamics = Dynamics::new(&model.robot);
        let (mut mass, mut weight) = (DMatrix::zeros(n, n), vec![0.0; n]);
        for posture in expected["postures"].as_array().unwrap() {
            let q = numbers(&posture["q"]);
            dynamics.mass_matrix(&q, &mut mass);
            dynamics.gravity(&q, &mut weight);
            let rows: Vec<Vec<f64>> = posture["mass"].as_array().unwrap().iter().map(numbers).collect();
            // Angles of a pose that is pitched by 90° are off by 1e-8 rad at most; all else is rounding of numbers of 10.
            let tolerance = 1e-7 * rows.iter().flatten().fold(1.0, |most: f64, value| most.max(value.abs()));
            for (i, row) in rows.iter().enumerate() {
                for (j, value) in row.iter().enumerate() {
                    let ours = mass[(i, j)] + if i == j { armature[i] } else { 0.0 };
                    assert!((ours - value).abs() < tolerance, "{name}: M[{i}][{j}] {ours} at {q:?}, MuJoCo {value}");
                }
            }
            for (i, (ours, value)) in weight.iter().zip(numbers(&posture["weight"])).enumerate() {
                assert!(
                    (ours - value).abs() < 1e-7 * value.abs().max(10.0),
                    "{name}: G[{i}] {ours} at {q:?}, MuJoCo {value}"
                );
            }
        }
    }
}

#[test]
fn equivalent_armature_damping_and_friction_are_those_of_mujoco() {
    for name in MODELS {
        let first = first_model(&folder().join(name)).unwrap();
        let expected = of_mujoco(name);
        let [armature, damping, friction] = ["armature", "damping", "friction"].map(|key| numbers(&expected[key]));
        for (i, (joint, body)) in first.model.joints.iter().zip(&first.model.robot.bodies).enumerate() {
            assert_eq!((body.joint.damping, body.joint.friction), (damping[i], friction[i]), "{name}, {}", joint.name);
            let guessed = first.placeholders.is_guess(&joint.name, "rotor_inertia");
            assert_eq!(guessed, armature[i] == 0.0, "{name}, {}", joint.name);
            // One division and one multiplication by N².
            assert!(guessed || (joint.reflected_inertia() - armature[i]).abs() < 1e-15, "{name}, {}", joint.name);
        }
    }
}

#[test]
fn property_limits_gears_and_gravity_are_taken() {
    let model = first_model(&folder().join("arm.xml")).unwrap().model;
    let limits = |name: &str| model.robot.bodies[model.robot.joint_index(name).unwrap()].joint.limits;
    assert_eq!((limits("base").lower, limits("base").effort), (f64::NEG_INFINITY, 100.0));
    assert!((limits("shoulder").upper - 120.0_f64.to_radians()).abs() < 1e-15);
    assert_eq!(limits("shoulder").effort, 80.0);
    // Of the range -1 … 1.5 the larger side counts, through the gear of 30.
    assert_eq!(limits("elbow").effort, 45.0);
    assert_eq!((limits("finger").upper, limits("finger").effort), (0.04, f64::INFINITY));
    let ratio = |name: &str| model.joints[model.robot.joint_index(name).unwrap()].gear_ratio;
    assert_eq!([ratio("base"), ratio("elbow")], [50.0, 30.0]);
    assert_eq!(model.robot.gravity.as_slice(), [0.3, 0.0, -9.7]);
}

#[test]
fn property_what_is_not_taken_is_remarked_with_its_line() {
    let remarks = |name: &str| -> Vec<String> {
        let model = first_model(&folder().join(name)).unwrap().model;
        model.remarks.iter().map(|remark| remark.to_string().rsplit('/').next().unwrap().to_owned()).collect()
    };
    let arm = remarks("arm.xml");
    let expected = [
        "arm.xml:50: keyframe: this section is not read",
        "arm.xml:35: joint thumb: it mimics finger; this is not simulated: it is held at its offset, 0.002 m",
    ];
    for remark in expected {
        assert!(arm.iter().any(|found| found.contains(remark)), "{remark} is missing in {arm:#?}");
    }
    let frames = remarks("frames.xml");
    for remark in [
        "frames.xml:19: joint socket: of type spherical: it is held fixed",
        "cube_joint: of type floating: it is held fixed",
    ] {
        assert!(frames.iter().any(|found| found.contains(remark)), "{remark} is missing in {frames:#?}");
    }
}

#[test]
fn property_a_first_model_simulates_and_reads_back() {
    for name in MODELS {
        let first = first_model(&folder().join(name)).unwrap();
        assert_eq!(trial(&first.model).unwrap().faults, Vec::<String>::new(), "{name}");
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("model.toml");
        first.save(&file).unwrap();
        let again = Model::load(&file).unwrap();
        assert_eq!(trial(&again).unwrap().faults, Vec::<String>::new(), "{name}, as written");
        assert_eq!(again.robot, first.model.robot, "{name}");
        // Guesses are comments in the file.
        let mut stated = first.model.joints.clone();
        for joint in &mut stated {
            (joint.gear_stiffness, joint.gear_damping, joint.encoder) = (None, None, None);
            joint.rotor_inertia.take_if(|_| first.placeholders.is_guess(&joint.name, "rotor_inertia"));
        }
        assert_eq!(again.joints, stated, "{name}");
    }
}

/// A change of `arm.xml`, and a part of the error that it makes.
type Refused = (&'static str, &'static str, &'static str);

const REFUSED: [Refused; 9] = [
    ("axis=\"0 1 0\"", "axis=\"0 0 0\"", "joint shoulder: axis = 0 0 0: expected an axis that is not zero"),
    ("size=\"0.04\"", "size=\"-0.04\"", "geom: size = -0.04: expected 2 numbers > 0 [m] of a capsule"),
    ("ref=\"15\"", "ref=\"15 deg\"", ":29: joint shoulder: ref = 15 deg: expected 1 numbers"),
    (
        "file=\"gripper.xml\"",
        "file=\"gone.xml\"",
        ":35: include: file = gone.xml: expected an XML file that exists and can be read",
    ),
    ("childclass=\"forearm\"", "childclass=\"foram\"", "expected a default class of this file"),
    ("angle=\"degree\"", "angle=\"degrees\"", "compiler: angle = degrees: expected one of degree, radian"),
    ("type=\"cylinder\"", "type=\"cylindre\"", "nearest is cylinder"),
    (
        "quat=\"0.9 0 0.3 0.1\"",
        "quat=\"0 0 0 0\"",
        "body lower_arm: quat = 0 0 0 0: expected a quaternion w x y z that is not zero",
    ),
    ("</worldbody>", "</worldbod>", "MJCF: expected </worldbody>"),
];

/// A name that reaches a terminal as it is could clear it, or show another text than it says.
const CONTROLS: [Refused; 3] = [
    ("body name=\"turntable\"", "body name=\"turn&#10;table\"", ":25: joint base: child link = turn\\ntable: expected"),
    (
        "joint name=\"shoulder\"",
        "joint name=\"&#x1b;[2J\"",
        ":29: joint \\u{1b}[2J: name = \\u{1b}[2J: expected a name without control characters",
    ),
    ("joint name=\"elbow\"", "joint name=\"el\tbow\"", "joint el\\tbow: name = el\\tbow: expected a name without"),
];

#[test]
fn property_what_has_no_meaning_is_refused_with_its_line() {
    all_refused(&REFUSED);
}

#[test]
fn regress_names_with_control_characters_are_refused_in_mjcf() {
    all_refused(&CONTROLS);
}

fn all_refused(cases: &[Refused]) {
    let text = fs::read_to_string(folder().join("arm.xml")).unwrap();
    for &(sound, changed, message) in cases {
        assert!(text.contains(sound), "{sound}");
        let place = tempfile::tempdir().unwrap();
        fs::copy(folder().join("gripper.xml"), place.path().join("gripper.xml")).unwrap();
        let file = place.path().join("arm.xml");
        fs::write(&file, text.replacen(sound, changed, 1)).unwrap();
        let error = first_model(&file).expect_err(changed).to_string();
        assert!(error.contains(message), "{changed}: {error}");
    }
}

#[test]
fn property_files_that_include_each_other_end_with_an_error() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("a.xml");
    fs::write(&file, "<mujoco><include file=\"b.xml\"/></mujoco>").unwrap();
    fs::write(place.path().join("b.xml"), "<mujoco><include file=\"b.xml\"/></mujoco>").unwrap();
    let error = first_model(&file).unwrap_err().to_string();
    assert!(error.contains("b.xml:1: include: file = b.xml: expected a file that is not included yet"), "{error}");
}

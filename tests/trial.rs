//! The second of motion with which `lostmotion check` tries a model: sound machines pass it, and what cannot follow is named.

use std::fs;
use std::path::Path;
use std::process::Command;

use lostmotion::plant::first_model;
use lostmotion::robot::Model;
use lostmotion::scenario::trial;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn robot(name: &str, file: &str) -> std::path::PathBuf {
    Path::new(ROOT).join("robots").join(name).join(file)
}

/// Among them a SCARA whose way is shorter than its gap, and whose friction holds it within a few milliradians.
#[test]
fn property_the_machines_of_the_project_follow() {
    for name in ["chain12", "elbow", "emps", "kr300", "scara", "sixaxis"] {
        let model = Model::load(&robot(name, "model.toml")).unwrap();
        assert_eq!(trial(&model).unwrap().faults, Vec::<String>::new(), "{name}");
    }
}

/// A drive of a thousandth of the current: the arm sinks under its weight.
#[test]
fn property_a_drive_that_is_too_weak_is_named() {
    let mut model = first_model(&robot("elbow", "elbow.urdf")).unwrap().model;
    assert_eq!(trial(&model).unwrap().faults, Vec::<String>::new());
    model.joints[0].amplifier.current_limit *= 1e-3;
    let faults = trial(&model).unwrap().faults;
    let name = &model.joints[0].name;
    assert!(faults.iter().any(|fault| fault.starts_with(&format!("joint {name}: "))), "{faults:?}");
}

/// The arm hangs where it begins, and cannot be lifted.
#[test]
fn property_an_effort_limit_that_lifts_nothing_ends_a_check_with_3() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("weak.urdf");
    let urdf = fs::read_to_string(robot("elbow", "elbow.urdf")).unwrap();
    assert!(urdf.contains("effort=\"48\""));
    fs::write(&file, urdf.replace("effort=\"48\"", "effort=\"0.1\"")).unwrap();
    let checked = Command::new(env!("CARGO_BIN_EXE_lostmotion")).arg("check").arg(&file).output().unwrap();
    let said = String::from_utf8_lossy(&checked.stdout);
    assert_eq!(checked.status.code(), Some(3), "{said}");
    assert!(said.contains("joint shoulder: ") && said.contains(" rad off after a move of "), "{said}");
}

/// The wheel of a mobile robot: the damping of a whole drive on 5e-5 kg·m² brings it to rest in 2 µs.
const WHEEL: &str = r#"<robot name="base"><link name="base"/>
<link name="wheel"><inertial><mass value="0.05"/><inertia ixx="5e-5" ixy="0" ixz="0" iyy="5e-5" iyz="0" izz="5e-5"/></inertial></link>
<joint name="roll" type="continuous"><parent link="base"/><child link="wheel"/><axis xyz="0 0 1"/>
<limit effort="100" velocity="10"/><dynamics damping="21.75" friction="10.48"/></joint></robot>"#;

/// A leg whose rotors are a hundredth of its links, so that their loops are slow, in dampers that need more torque than its weight.
const LEG: &str = r#"<mujoco><default><joint axis="0 1 0" armature="0.01" damping="30" range="-60 60"/></default><worldbody>
<body><joint name="hip"/><geom type="capsule" size="0.05" fromto="0 0 0 0 0 -0.4"/>
<body pos="0 0 -0.4"><joint name="knee"/><geom type="capsule" size="0.04" fromto="0 0 0 0 0 -0.4"/></body></body></worldbody></mujoco>"#;

/// Dampers of the file are known: a joint follows against them. The negative control is a drive that cannot.
#[test]
fn property_joints_follow_against_strong_dampers() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("wheel.urdf", WHEEL), ("leg.xml", LEG)] {
        let file = folder.path().join(name);
        fs::write(&file, text).unwrap();
        let model = first_model(&file).unwrap().model;
        assert_eq!(trial(&model).unwrap().faults, Vec::<String>::new(), "{name}");
    }
    let mut model = first_model(&folder.path().join("leg.xml")).unwrap().model;
    model.joints[0].amplifier.current_limit = 1e-6;
    assert!(!trial(&model).unwrap().faults.is_empty());
}

//! What is accepted, but not taken as written in the file: `check` says so.

use super::files::{Case, Files};

#[track_caller]
fn said(file: &str, case: &Case, note: &str) {
    let files = Files::new();
    files.change(file, case);
    let output = files.lostmotion(&["check", "model.toml"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.lines().any(|line| line.trim() == format!("note: {note}")), "{text}");
}

#[test]
fn regress_limits_of_zero_are_said_to_be_taken_as_not_given() {
    let effort = "robot.urdf:19: joint turn: limit effort of 0 is taken as not given";
    said("robot.urdf", &("effort=\"5\"", "effort=\"0\"", "", &[]), effort);
    let both = "robot.urdf:19: joint turn: limit lower and upper and velocity of 0 is taken as not given";
    let zero =
        ("lower=\"-3\" upper=\"3\" effort=\"5\" velocity=\"4\"", "lower=\"0\" upper=\"0\" effort=\"5\" velocity=\"0\"");
    said("robot.urdf", &(zero.0, zero.1, "", &[]), both);
}

#[test]
fn regress_a_breakaway_below_coulomb_is_said() {
    let note = "joint turn: breakaway is below coulomb, friction rises as it begins to slip";
    said("model.toml", &("breakaway = [0.4, 0.42]", "breakaway = [0.4, 0.1]", "", &[]), note);
}

#[test]
fn regress_a_voltage_limit_without_resistance_is_said() {
    let note = "joint turn: voltage_limit is without effect, the motor has no resistance";
    said("model.toml", &("resistance = 0.5\ninductance = 0.0005\n", "", "", &[]), note);
}

#[test]
fn regress_an_unread_mesh_is_said() {
    let note = "link table: its collision shape gone.stl was not read, expected a file that can be read (No such file or directory (os error 2))";
    said("robot.urdf", &("<box size=\"0.2 0.1 0.1\"/>", "<mesh filename=\"gone.stl\"/>", "", &[]), note);
}

#[test]
fn regress_what_a_urdf_means_otherwise_than_it_says_is_said_with_its_line() {
    let tensor = "robot.urdf:8: link table: no rigid body has the inertia, [ixx 2.0000e-2, ixy 0.0000e0, ixz 0.0000e0, iyy 2.0000e-2, \
                  iyz 0.0000e0, izz 3.0000e-1] about the centre of mass: principal moments 2.0000e-2, 2.0000e-2, 3.0000e-1 kg·m²; expected \
                  none above the sum of the others. The nearest one that a body of this mass has is used: [ixx 1.5000e-1, ixy 0.0000e0, \
                  ixz 0.0000e0, iyy 1.5000e-1, iyz 0.0000e0, izz 3.0000e-1] kg·m²";
    said("robot.urdf", &("izz=\"0.03\"", "izz=\"0.3\"", "", &[]), tensor);
    let shape =
        "link table: its collision shape <blob> was not read, expected one box, cylinder, capsule, sphere or mesh";
    said("robot.urdf", &("<box size=\"0.2 0.1 0.1\"/>", "<blob/>", "", &[]), shape);
    let space = "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" name=\"turntable\"><!-- <xacro:include/> -->";
    let world = "robot.urdf:15: joint turn: parent world is no link of this file and is taken as the base";
    let files = Files::new();
    files.change("robot.urdf", &("<robot name=\"turntable\">", space, "", &[]));
    files.change("robot.urdf", &("<link name=\"base\"/>", "", "", &[]));
    files.change("robot.urdf", &("<parent link=\"base\"/>", "<parent link=\"world\"/>", "", &[]));
    let output = files.lostmotion(&["new", "robot.urdf", "--out", "first.toml"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.lines().any(|line| line.trim() == format!("note: {world}")), "{text}");
}

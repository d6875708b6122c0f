//! What is accepted, but taken otherwise than it stands in the file: `check` says so.

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
    let effort = "joint turn: limit effort of 0 is taken as not given";
    said("robot.urdf", &("effort=\"5\"", "effort=\"0\"", "", &[]), effort);
    let both = "joint turn: limit lower and upper and velocity of 0 is taken as not given";
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
    let note = "link table: its collision mesh gone.stl was not read, expected a file that can be read (No such file or directory (os error 2))";
    said("robot.urdf", &("<box size=\"0.2 0.1 0.1\"/>", "<mesh filename=\"gone.stl\"/>", "", &[]), note);
}

//! Model files.

use super::all_refused;
use super::files::{Case, Files};

const CASES: &[Case] = &[
    ("model/1", "model/9", "model.toml:1: schema", &["lostmotion/model/1"]),
    ("name = \"turntable\"", "name = 3", "model.toml:2: name = 3", &["text in quotes"]),
    ("name = \"turntable\"\n", "", "model.toml:1: name", &["(missing)"]),
    ("name = \"turntable\"", "name = \"turntable", "model.toml:2: expected TOML", &[]),
    ("robot.urdf", "gone.urdf", "model.toml:3: urdf = \"gone.urdf\"", &["a file that exists"]),
    ("robot.urdf", ".", "", &["a regular file"]),
    ("gravity = [0.0, 0.0, -9.81]", "gravity = [0.0, -9.81]", "model.toml:4: gravity", &["a list of 3"]),
    (
        "gravity = [0.0, 0.0, -9.81]",
        "gravity = [0.0, 0.0, -1e300]",
        "model.toml:4: gravity",
        &["from -1000 to 1000 [m/s²]"],
    ),
    ("gear_ratio = 5.0", "gear_ratio = 0", "model.toml:7: joints.turn.gear_ratio = 0", &["from 1e-4"]),
    ("gear_ratio = 5.0", "gear_ratio = -5.0", "model.toml:7: joints.turn.gear_ratio = -5.0", &["from 1e-4"]),
    ("gear_ratio = 5.0", "gear_ratio = 1e-300", "model.toml:7: joints.turn.gear_ratio = 1e-300", &["from 1e-4"]),
    (
        "torque_constant = 0.023",
        "torque_constant = 1e-300",
        "model.toml:15: joints.turn.motor.torque_constant = 1e-300",
        &["from 1e-9"],
    ),
    ("gear_ratio = 5.0", "gear_ratio = 1e300", "model.toml:7: joints.turn.gear_ratio = 1e300", &["to 1e6 [rad/rad]"]),
    ("gear_ratio = 5.0", "gear_ratio = nan", "model.toml:7: joints.turn.gear_ratio = nan", &["a number"]),
    ("gear_ratio = 5.0", "gear_ratio = inf", "model.toml:7: joints.turn.gear_ratio = inf", &["a number"]),
    ("gear_ratio = 5.0", "gear_ratio = 1979-05-27", "model.toml:7: joints.turn.gear_ratio = 1979-05-27", &["a number"]),
    (
        "gear_ratio = 5.0",
        "gear_ratio = 99999999999999999999999",
        "model.toml:7: joints.turn.gear_ratio = 99999999999999999999999",
        &["a number"],
    ),
    ("gear_ratio = 5.0\n", "", "model.toml:6: joints.turn.gear_ratio", &["(missing)"]),
    ("gear_ratio = 5.0", "gear_ratio = 5.0\ngear_ratio = 6.0", "model.toml:8", &["TOML", "duplicate key"]),
    (
        "gear_ratio = 5.0",
        "gear_ratoi = 5.0\ngear_ratio = 5.0",
        "model.toml:7: joints.turn.gear_ratoi",
        &["`gear_ratio`"],
    ),
    (
        "rotor_inertia = 0.0008",
        "rotor_inertia = 0",
        "model.toml:8: joints.turn.rotor_inertia = 0",
        &["from 1e-14 to 1e7"],
    ),
    (
        "rotor_inertia = 0.0008",
        "rotor_inertia = 1e300",
        "model.toml:8: joints.turn.rotor_inertia = 1e300",
        &["from 1e-14 to 1e7 [kg·m²]"],
    ),
    (
        "rotor_inertia = 0.0008",
        "rotor_inertia = 1e-300",
        "model.toml:8: joints.turn.rotor_inertia = 1e-300",
        &["from 1e-14 to 1e7 [kg·m²]"],
    ),
    ("gear_stiffness = 3000.0", "gear_stiffness = 0", "model.toml:9: joints.turn.gear_stiffness = 0", &["from 1e-6"]),
    (
        "gear_stiffness = 3000.0",
        "gear_stiffness = 1e300",
        "model.toml:9: joints.turn.gear_stiffness = 1e300",
        &["to 1e11"],
    ),
    (
        "gear_stiffness = 3000.0",
        "gear_stiffness = 1e10",
        "model.toml:9: joints.turn.gear_stiffness = 1e10",
        &["100000 rad/s"],
    ),
    ("gear_damping = 2.0", "gear_damping = -2.0", "model.toml:10: joints.turn.gear_damping = -2.0", &["from 0 to 1e9"]),
    (
        "gear_damping = 2.0",
        "gear_damping = 1e300",
        "model.toml:10: joints.turn.gear_damping = 1e300",
        &["from 0 to 1e9"],
    ),
    (
        "gear_stiffness = 3000.0\ngear_damping = 2.0",
        "gear_damping = 1e8",
        "model.toml:9: joints.turn.gear_damping = 1e8",
        &["100000 rad/s"],
    ),
    ("backlash = 0.008", "backlash = -0.1", "model.toml:11: joints.turn.backlash = -0.1", &["from 0 to", "[rad]"]),
    ("backlash = 0.008", "backlash = 1e300", "model.toml:11: joints.turn.backlash = 1e300", &["from 0 to", "[rad]"]),
    (
        "end_stop_stiffness = 1000.0",
        "end_stop_stiffness = 0",
        "model.toml:12: joints.turn.end_stop_stiffness = 0",
        &["from 1e-6"],
    ),
    (
        "torque_constant = 0.023",
        "torque_constant = 0",
        "model.toml:15: joints.turn.motor.torque_constant = 0",
        &["from 1e-9"],
    ),
    (
        "torque_constant = 0.023",
        "torque_constant = 1e300",
        "model.toml:15: joints.turn.motor.torque_constant = 1e300",
        &["to 1e5 [N·m/A]"],
    ),
    ("resistance = 0.5", "resistance = 0", "model.toml:16: joints.turn.motor.resistance = 0", &["[Ω]"]),
    ("resistance = 0.5\n", "", "model.toml:16: joints.turn.motor.inductance", &["a `resistance` beside it"]),
    ("inductance = 0.0005", "inductance = 1e300", "model.toml:17: joints.turn.motor.inductance = 1e300", &["[H]"]),
    (
        "voltage_limit = 24.0",
        "voltage_limit = 0",
        "model.toml:20: joints.turn.drive.voltage_limit = 0",
        &["> 0", "[V]"],
    ),
    (
        "current_limit = 18.0",
        "current_limit = -1",
        "model.toml:21: joints.turn.drive.current_limit = -1",
        &["> 0", "[A]"],
    ),
    (
        "current_time_constant = 0.0004",
        "current_time_constant = 0",
        "model.toml:22: joints.turn.drive.current_time_constant = 0",
        &["from 1e-7 to 10 [s]"],
    ),
    (
        "current_time_constant = 0.0004",
        "current_time_constant = 1e300",
        "model.toml:22: joints.turn.drive.current_time_constant = 1e300",
        &["from 1e-7 to 10 [s]"],
    ),
    (
        "counts_per_turn = 2000",
        "counts_per_turn = 0",
        "model.toml:25: joints.turn.encoder.counts_per_turn = 0",
        &["from 1 to"],
    ),
    (
        "counts_per_turn = 2000",
        "counts_per_turn = 1e300",
        "model.toml:25: joints.turn.encoder.counts_per_turn",
        &["1e11"],
    ),
    (
        "resolution = 1e-5",
        "resolution = 0",
        "model.toml:28: joints.turn.link_encoder.resolution = 0",
        &["1e-13", "[rad]"],
    ),
    (
        "low_pass_time_constant = 0.02",
        "low_pass_time_constant = 0",
        "model.toml:31: joints.turn.velocity_sensor.low_pass_time_constant = 0",
        &["from 1e-7 to 100 [s]"],
    ),
    (
        "low_pass_time_constant = 0.02",
        "method = \"magic\"",
        "model.toml:31: joints.turn.velocity_sensor.method = \"magic\"",
        &["pulse_period"],
    ),
    ("noise = 0.03", "noise = -0.03", "model.toml:34: joints.turn.current_sensor.noise = -0.03", &["from 0", "[A]"]),
    ("noise = 0.03", "noise = true", "model.toml:34: joints.turn.current_sensor.noise = true", &["a number"]),
    (
        "resolution = 0.01",
        "resolution = 1e300",
        "model.toml:35: joints.turn.current_sensor.resolution = 1e300",
        &["[A]"],
    ),
    (
        "coulomb = [0.3, 0.32]",
        "coulomb = [0.3, -0.32]",
        "model.toml:38: joints.turn.friction.coulomb",
        &["from 0 to 1e9"],
    ),
    (
        "coulomb = [0.3, 0.32]",
        "coulomb = [0.3, 0.3, 0.3]",
        "model.toml:38: joints.turn.friction.coulomb",
        &["two of them"],
    ),
    ("coulomb = [0.3, 0.32]", "coulomb = [[0.3]]", "model.toml:38: joints.turn.friction.coulomb", &["two of them"]),
    ("breakaway = [0.4, 0.42]", "breakaway = 1e300", "model.toml:39: joints.turn.friction.breakaway = 1e300", &["1e9"]),
    (
        "stribeck_velocity = 0.03",
        "stribeck_velocity = 0",
        "model.toml:40: joints.turn.friction.stribeck_velocity",
        &["1e-9"],
    ),
    (
        "stribeck_velocity = 0.03",
        "stribeck_velocity = 1e300",
        "model.toml:40: joints.turn.friction.stribeck",
        &["[rad/s]"],
    ),
    ("viscous = 0.4", "viscous = -1e300", "model.toml:41: joints.turn.friction.viscous = -1e300", &["-1e10 to 1e10"]),
    ("link_share = 0.1", "link_share = 1.1", "model.toml:42: joints.turn.friction.link_share = 1.1", &["from 0 to 1"]),
    ("[joints.turn]", "[joints.spin]", "model.toml:6: joints.spin", &["movable joint", "turn"]),
    ("[joints.turn.friction]", "[joints.turn.fricton]", "model.toml:37: joints.turn.fricton", &["`friction`"]),
    (
        "effect = \"cogging\"",
        "effect = \"coging\"",
        "model.toml:45: effects[1].effect = \"coging\"",
        &["such as cogging"],
    ),
    ("effect = \"cogging\"\n", "", "model.toml:44: effects[1].effect", &["(missing)"]),
    ("joint = \"turn\"\n", "", "model.toml:44: effects[1].joint", &["the joint it acts on: turn"]),
    (
        "joint = \"turn\"",
        "joint = \"tun\"",
        "model.toml:46: effects[1].joint = \"tun\"",
        &["a joint of this model", "turn"],
    ),
    ("amplitude = 0.05", "amplitude = -1", "model.toml:47: effects[1].amplitude = -1", &["from 0 to", "[N·m]"]),
    ("amplitude = 0.05", "amplitude = 1e300", "model.toml:47: effects[1].amplitude = 1e300", &["from 0 to", "[N·m]"]),
    ("amplitude = 0.05\n", "", "model.toml:44: effects[1].amplitude", &["(missing)", "[N·m]"]),
    (
        "amplitude = 0.05",
        "amplitde = 0.05",
        "model.toml:47: effects[1].amplitde = 0.05",
        &["`amplitude` (unknown key)"],
    ),
    ("amplitude = 0.05", "amplitude = \"large\"", "model.toml:47: effects[1].amplitude = \"large\"", &["number"]),
    ("order = 12.0", "order = 1e300", "model.toml:48: effects[1].order = 1e300", &["from 0 to 10000"]),
    ("tilt = 0.05", "tilt = 9", "model.toml:52: effects[2].tilt = 9", &["from 0 to 1.6 [rad]"]),
    (
        "tilt = 0.05",
        "joint = \"turn\"\ntilt = 0.05",
        "model.toml:52: effects[2].joint = \"turn\"",
        &["the whole machine"],
    ),
    (
        "effect = \"base_tilt\"\ntilt = 0.05\nazimuth = 1.2",
        "effect = \"presliding\"\njoint = \"turn\"\nstiffness = 500.0\ndamping = 0.5\n[[effects]]\neffect = \"dwell_stiction\"\n\
         joint = \"turn\"\ngrowth = 0.1\ntime_constant = 5.0",
        "model.toml:56: effects[3].effect = \"dwell_stiction\"",
        &["one of presliding and dwell_stiction on turn"],
    ),
    (
        "effect = \"base_tilt\"\ntilt = 0.05\nazimuth = 1.2",
        "effect = \"external_contact\"\njoint = \"turn\"\nangle = 0.5\nstiffness = 1e3\nside = 0.5",
        "model.toml:55: effects[2].side = 0.5",
        &["+1 or −1"],
    ),
    (
        "[[effects]]\neffect = \"base_tilt\"\ntilt = 0.05\nazimuth = 1.2",
        "[effects2]\n",
        "model.toml:50: effects2",
        &["unknown key"],
    ),
    ("[[loads]]", "[loads]", "model.toml:55: loads", &["a list of tables"]),
    ("mass = 0.5", "mass = 0", "model.toml:57: loads[1].mass = 0", &["> 0", "[kg]"]),
    ("mass = 0.5", "mass = 1e300", "model.toml:57: loads[1].mass = 1e300", &["[kg]"]),
    ("x = 0.1", "x = 1e300", "model.toml:58: loads[1].x = 1e300", &["from -1000 to 1000 [m]"]),
    ("x = 0.1", "w = 0.1", "model.toml:58: loads[1].w = 0.1", &["unknown key"]),
];

#[test]
fn regress_bad_models_are_refused_by_check_with_place_and_expectation() {
    all_refused("model.toml", &["check", "model.toml"], CASES);
}

/// What `check` finds in a model, `run` finds too, before it simulates; and where the scenario only names the model.
#[test]
fn regress_run_and_check_of_a_scenario_refuse_what_check_of_its_model_refuses() {
    for arguments in [&["run", "scenario.toml", "--out", "out"][..], &["check", "scenario.toml"]] {
        let wanted =
            |case: &&Case| case.0.starts_with("tilt") || case.0.starts_with("order") || case.0.starts_with("gear_st");
        let cases: Vec<Case> = CASES.iter().filter(wanted).copied().collect();
        assert!(cases.len() >= 6);
        all_refused("model.toml", arguments, &cases);
    }
}

/// A model is refused as well by the commands that only read it.
#[test]
fn regress_friction_that_an_effect_alters_and_the_model_lacks_is_named_with_the_entry() {
    let files = Files::new();
    let friction = "[joints.turn.friction]\ncoulomb = [0.3, 0.32]\nbreakaway = [0.4, 0.42]\nstribeck_velocity = 0.03\n\
                    viscous = 0.4\nlink_share = 0.1\n";
    files.change("model.toml", &(friction, "", "", &[]));
    files.change(
        "model.toml",
        &(
            "effect = \"cogging\"\njoint = \"turn\"\namplitude = 0.05\norder = 12.0",
            "effect = \"stribeck\"\njoint = \"turn\"\nbreakaway = 0.5\nstribeck_velocity = 0.1",
            "",
            &[],
        ),
    );
    files
        .refused(&["check", "model.toml"], "model.toml:6: joints.turn.friction", &["`stribeck` alters", "(effects[1])"])
        .unwrap_or_else(|fault| panic!("{fault}"));
}

//! Scenario files.

use super::all_refused;
use super::files::{Case, Files};

/// The head of the session that moves by places, up to the joint's first key.
const PLACES: &str = "kind = \"waypoints\"\nrest = 0.1\nstart.turn_deg = 0.0\n[session.joints.turn]\n";

const CASES: &[Case] = &[
    ("scenario/1", "scenario/7", "scenario.toml:1: schema", &["lostmotion/scenario/1"]),
    ("robot = \"model.toml\"", "robot = \"gone.toml\"", "scenario.toml:3: robot = \"gone.toml\"", &["exists"]),
    ("control_period = 0.001", "control_period = 0", "scenario.toml:4: control_period = 0", &["from 1e-6 to 1 [s]"]),
    (
        "control_period = 0.001",
        "control_period = 1e-12",
        "scenario.toml:4: control_period = 1e-12",
        &["from 1e-6 to 1 [s]"],
    ),
    (
        "control_period = 0.001",
        "control_period = 1e300",
        "scenario.toml:4: control_period = 1e300",
        &["from 1e-6 to 1 [s]"],
    ),
    ("control_period", "control_periode", "scenario.toml:4: control_periode", &["`control_period`"]),
    ("seed = 3", "seed = -3", "scenario.toml:5: seed = -3", &["a whole number"]),
    ("seed = 3", "seed = 1.5", "scenario.toml:5: seed = 1.5", &["a whole number"]),
    ("step = 0.001", "step = 1e-12", "scenario.toml:8: plant.step = 1e-12", &["from 1e-6 to 0.1 [s]"]),
    ("step = 0.001", "step = 1e300", "scenario.toml:8: plant.step = 1e300", &["from 1e-6 to 0.1 [s]"]),
    ("substeps = 2", "substeps = 1000000000", "scenario.toml:9: plant.substeps = 1000000000", &["from 1 to 10000"]),
    (
        "name = \"stairs\"",
        "name = \"places\"",
        "scenario.toml:23: session[2].name = \"places\"",
        &["no other session has"],
    ),
    (
        "kind = \"waypoints\"",
        "kind = \"waypoint\"",
        "scenario.toml:13: session[1].kind = \"waypoint\"",
        &["\"waypoints\""],
    ),
    (
        "kind = \"waypoints\"",
        "kind = \"torque\"",
        "scenario.toml:16: session[1].joints.turn.shape",
        &["square or triangle"],
    ),
    (
        PLACES,
        "kind = \"torque\"\nrest = 0.1\nstart.turn_deg = 0.0\n[session.joints.turn]\nshape = \"square\"\namplitude = -1.0\n",
        "scenario.toml:18: session[1].joints.turn.amplitude = -1.0",
        &["[N·m]"],
    ),
    (
        PLACES,
        "kind = \"torque\"\nrest = 0.1\nstart.turn_deg = 0.0\n[session.joints.turn]\nshape = \"square\"\namplitude = 1.0\nperiod = 0\n",
        "scenario.toml:19: session[1].joints.turn.period = 0",
        &["from 1e-5 to 1e6 [s]"],
    ),
    ("rest = 0.1", "rest = 1e12", "scenario.toml:14: session[1].rest = 1e12", &["from 0 to 1e7 [s]"]),
    ("start.turn_deg = 0.0", "start.turn_deg = 1e300", "scenario.toml:15: session[1].start.turn_deg", &["degrees"]),
    ("start.turn_deg = 0.0", "start.spin = 0.0", "scenario.toml:15: session[1].start.spin", &["unknown key"]),
    ("[session.joints.turn]", "[session.joints.spin]", "scenario.toml:16: session[1].joints.spin", &["turn"]),
    (
        "positions_deg = [5, 0]",
        "positions_deg = [1e18]",
        "scenario.toml:17: session[1].joints.turn.positions_deg",
        &["1.8e8 [°]"],
    ),
    (
        "positions_deg = [5, 0]",
        "positions_deg = [nan]",
        "scenario.toml:17: session[1].joints.turn.positions_deg",
        &["[°]"],
    ),
    (
        "positions_deg = [5, 0]",
        "positions_deg = 5",
        "scenario.toml:17: session[1].joints.turn.positions_deg = 5",
        &["a list"],
    ),
    (
        "speed_deg = 60",
        "speed_deg = 1e-9",
        "scenario.toml:18: session[1].joints.turn.speed_deg = 1e-9",
        &["1e-6", "[rad/s]"],
    ),
    (
        "speed_deg = 60",
        "speed_deg = 1e300",
        "scenario.toml:18: session[1].joints.turn.speed_deg = 1e300",
        &["10000 [rad/s]"],
    ),
    ("speed_deg = 60", "speed_deg = -60", "scenario.toml:18: session[1].joints.turn.speed_deg = -60", &["[rad/s]"]),
    (
        "acceleration_deg = 500",
        "acceleration_deg = 1e-15",
        "scenario.toml:19: session[1].joints.turn.acceleration_deg",
        &["rad/s²"],
    ),
    ("rest = 0.0", "rest = 1e300", "scenario.toml:20: session[1].joints.turn.rest = 1e300", &["from 0 to 1e7 [s]"]),
    ("first = 0.2", "first = 0", "scenario.toml:27: session[2].joints.turn.first = 0", &["1e-6"]),
    ("last = 0.4", "last = 0.1", "scenario.toml:28: session[2].joints.turn.last = 0.1", &["not below `first`"]),
    ("increment = 0.2", "increment = 1e-15", "scenario.toml:29: session[2].joints.turn.increment = 1e-15", &["1e-6"]),
    (
        "increment = 0.2",
        "increment = 1e-6",
        "scenario.toml:29: session[2].joints.turn.increment = 1e-6",
        &["at most 10000 steps"],
    ),
    (
        "deceleration = 10.0",
        "deceleration = 0",
        "scenario.toml:31: session[2].joints.turn.deceleration = 0",
        &["rad/s²"],
    ),
    (
        "steady_time = 0.1",
        "steady_time = 1e12",
        "scenario.toml:32: session[2].joints.turn.steady_time = 1e12",
        &["1e7 [s]"],
    ),
    ("steady_time = 0.1", "steady_time = 1e7", "scenario.toml:24: session[2]", &["at most 1e7 s"]),
    (
        "settling_way = 0.01",
        "settling_way = -1",
        "scenario.toml:33: session[2].joints.turn.settling_way = -1",
        &["from 0"],
    ),
    ("advance = 0.001", "advance = 1e300", "scenario.toml:34: session[2].joints.turn.advance = 1e300", &["1e6 [rad]"]),
    ("gentle_deceleration = 5.0\n", "", "scenario.toml:26: session[2].joints.turn.gentle_deceleration", &["(missing)"]),
    ("duration = 0.4", "duration = 1e300", "scenario.toml:41: session[3].duration = 1e300", &["≤ 1e7 [s]"]),
    ("duration = 0.4", "duration = 0", "scenario.toml:41: session[3].duration = 0", &["> 0"]),
    ("duration = 0.4\n", "", "scenario.toml:38: session[3].duration", &["(missing)"]),
    (
        "duration = 0.4",
        "duration = 1e7",
        "scenario.toml:41: session[3].duration = 1e7",
        &["at most 86400 moves of turn"],
    ),
    ("lowest = -0.5", "lowest = 0.5", "scenario.toml:45: session[3].joints.turn.highest = 0.5", &["above `lowest`"]),
    (
        "duration = 0.4\nlongest_rest = 0.1\n[session.joints.turn]\nlowest = -0.5",
        "duration = 9.0\nlongest_rest = 0\n[session.joints.turn]\nlowest = 0.4999999999999999",
        "scenario.toml:41: session[3].duration",
        &["moves of turn", "too close"],
    ),
    ("speed = 2.0", "speed = 1e-9", "scenario.toml:46: session[3].joints.turn.speed = 1e-9", &["1e-6"]),
    (
        "acceleration = 20.0",
        "acceleration = 1e300",
        "scenario.toml:47: session[3].joints.turn.acceleration = 1e300",
        &["1e7"],
    ),
    ("duration = 0.2", "duration = 1e12", "scenario.toml:52: session[4].duration = 1e12", &["≤ 1e7 [s]"]),
    ("mass = 0.2", "mass = -0.2", "scenario.toml:54: session[4].added_mass.mass = -0.2", &["> 0", "[kg]"]),
    ("law = \"sliding_mode\"", "law = \"pid\"", "scenario.toml:58: controller.law = \"pid\"", &["\"pi\""]),
    (
        "law = \"sliding_mode\"",
        "law = \"pi\"",
        "scenario.toml:60: controller.joints.turn.proportional",
        &["> 0", "(missing)"],
    ),
    (
        "lambda = 6.0",
        "lambda = 6.0\nintegral = 3",
        "scenario.toml:62: controller.joints.turn.integral = 3",
        &["unknown key"],
    ),
    ("lambda = 6.0", "lambda = 0", "scenario.toml:61: controller.joints.turn.lambda = 0", &["> 0", "[1/s]"]),
    ("switching = 0.5", "switching = 1e300", "scenario.toml:62: controller.joints.turn.switching = 1e300", &["1e12"]),
    ("boundary = 0.2", "boundary = -1", "scenario.toml:63: controller.joints.turn.boundary = -1", &["> 0"]),
    ("disturbance_noise = 1.0\n", "", "scenario.toml:60: controller.joints.turn.disturbance_noise", &["(missing)"]),
    ("edge_noise = 0.05", "edge_noise = 0", "scenario.toml:66: controller.joints.turn.edge_noise = 0", &["[counts]"]),
    (
        "velocity_error_limit = 0.5",
        "velocity_error_limit = 0",
        "scenario.toml:67: controller.joints.turn.velocity_error_limit",
        &["> 0"],
    ),
    ("shape = \"cylinder\"", "shape = \"cone\"", "scenario.toml:71: obstacles[1].shape = \"cone\"", &["cylinder"]),
    ("radius = 0.02", "radius = 0", "scenario.toml:72: obstacles[1].radius = 0", &["[m]"]),
    ("length = 0.3", "length = 1e300", "scenario.toml:73: obstacles[1].length = 1e300", &["1000 [m]"]),
    ("xyz = [0.6, 0.6, 0.5]", "xyz = [0.6, 0.6, 1e300]", "scenario.toml:74: obstacles[1].xyz", &["10000 [m]"]),
    ("rpy = [0.0, 0.0, 0.0]", "rpy = [0.0, 0.0]", "scenario.toml:75: obstacles[1].rpy", &["a list of 3"]),
    ("stiffness = 1e5", "stiffness = 1e300", "scenario.toml:76: obstacles[1].stiffness = 1e300", &["1e9 [N/m]"]),
    (
        "edge_radius = 0.005",
        "edge_radius = 0.02",
        "scenario.toml:78: obstacles[1].edge_radius = 0.02",
        &["half the smallest side"],
    ),
    ("xyz = [0.6, 0.6, 0.5]", "xyz = [0.1, 0.0, 0.5]", "scenario.toml: obstacles.post", &["a place clear of table"]),
    (
        "positions_deg = [5, 0]",
        "positions_deg = [500, 0]",
        "planned motion refused",
        &["turn at 3.0", "leaves its range"],
    ),
    (
        "seed = 3",
        "seed = 3\nmodel = [\"joints.turn.gear_ratio = 0\"]",
        "model.toml: joints.turn.gear_ratio = 0",
        &["from 1e-4"],
    ),
    ("seed = 3", "seed = 3\nmodel = \"joints.turn.gear_ratio = 6\"", "scenario.toml:6: model", &["a list of texts"]),
    ("seed = 3", "seed = 3\n[compensation]\ncrossing_time = 0.1", "scenario.toml:6: compensation", &["\"compensate\""]),
    ("seed = 3", "seed = 3\nprocedure = \"compensate\"", "scenario.toml:1: compensation", &["(missing)"]),
    (
        "seed = 3",
        "seed = 3\nprocedure = \"compensate\"\n[compensation]\ncrossing_time = 0",
        "scenario.toml:8: compensation.crossing_time = 0",
        &["> 0", "[s]"],
    ),
    (
        "seed = 3",
        "seed = 3\nprocedure = \"compensate\"\n[compensation]\ncrossing_time = 0.1\n[compensation.motion]\nkind = \"rest\"",
        "scenario.toml:10: compensation.motion.kind",
        &["moves at least one joint"],
    ),
    (
        "seed = 3",
        "seed = 3\nprocedure = \"compensate\"\n[compensation]\ncrossing_time = 0.1\n[compensation.motion]\nkind = \"waypoints\"\n\
         duration = 1\n[compensation.motion.joints.turn]\npositions = [0.1]\nspeed = 1.0\nacceleration = 5.0",
        "scenario.toml:11: compensation.motion.duration = 1",
        &["2 s of rest after the motion"],
    ),
    (
        "seed = 3",
        "seed = 3\n[expect.turn]\nleast_reduction_percent = 3",
        "scenario.toml:7: expect.turn.least_reduction_percent",
        &[],
    ),
    (
        "seed = 3",
        "seed = 3\n[expect.spin]\nviscous_percent = 3",
        "scenario.toml:6: expect",
        &["`spin` is not one of them"],
    ),
    (
        "seed = 3",
        "seed = 3\n[expect.turn]\nviscous_percent = -3",
        "scenario.toml:7: expect.turn.viscous_percent = -3",
        &["from 0"],
    ),
    (
        "seed = 3",
        "seed = 3\n[expect.obstacles.post]\npeak_force = [3, 2]",
        "scenario.toml:7: expect.obstacles.post.peak_force = [3, 2]",
        &["least value before the greatest"],
    ),
];

#[test]
fn regress_bad_scenarios_are_refused_by_check_with_place_and_expectation() {
    all_refused("scenario.toml", &["check", "scenario.toml"], CASES);
}

#[test]
fn regress_bad_scenarios_are_refused_by_run_with_place_and_expectation() {
    // Every third is enough: both go through the same door.
    let cases: Vec<Case> = CASES.iter().step_by(3).copied().collect();
    all_refused("scenario.toml", &["run", "scenario.toml", "--quiet", "--out", "out"], &cases);
}

#[test]
fn property_the_good_files_pass() {
    let files = Files::new();
    for arguments in [
        &["check", "model.toml", "scenario.toml", "robot.urdf"][..],
        &["run", "scenario.toml", "--quiet", "--out", "out"],
    ] {
        let output = files.lostmotion(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
    assert!(files.path("out/report.json").is_file());
}

/// An assignment of the command line has no line; its key, value and range are told.
#[test]
fn regress_bad_assignments_are_refused_by_key_and_expectation() {
    let cases: [(&str, &str, &[&str]); 6] = [
        ("control_period=-1", "scenario.toml: control_period = -1", &["from 1e-6 to 1 [s]"]),
        ("plant.step=1e-12", "scenario.toml: plant.step = 1e-12", &["from 1e-6 to 0.1 [s]"]),
        ("control_period", "scenario.toml: control_period", &["KEY=VALUE"]),
        ("model.joints.turn.gear_ratio=0", "model.toml: joints.turn.gear_ratio = 0", &["from 1e-4"]),
        (
            "model.joints.turn.rotor_inertia=1e-14",
            "model.toml:9: joints.turn.gear_stiffness = 3000.0",
            &["inertia on both sides"],
        ),
        ("robot=nowhere.toml", "scenario.toml: robot = nowhere.toml", &["exists"]),
    ];
    let files = Files::new();
    for (assignment, place, parts) in cases {
        let arguments = ["run", "scenario.toml", "--out", "out", "--set", assignment];
        files.refused(&arguments, place, parts).unwrap_or_else(|fault| panic!("{assignment}\n{fault}"));
    }
}

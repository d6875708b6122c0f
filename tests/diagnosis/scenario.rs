//! Scenarios: every one of the catalogue runs and meets its expectations; motions that cannot be are refused; the staircase
//! is steady where it is measured.

use std::path::{Path, PathBuf};

use lostmotion::error::{Error, MotionFault};
use lostmotion::identify::{self, Options};
use lostmotion::scenario::{Procedure, Run, Scenario, simulate};
use lostmotion::timeseries::{Channel, TimeSeries};
use lostmotion::units::DEG;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// A scenario on one of the project's robots: everything at rest, to be changed by the test.
fn scenario(robot: &str, rest: &str) -> Scenario {
    let gains = |joint: &str, lambda: f64, switching: f64, boundary: f64, limit: f64, noise: f64| {
        format!(
            "[controller.joints.{joint}]\nlambda = {lambda}\nswitching = {switching}\nboundary = {boundary}\n\
             velocity_error_limit = {limit}\ndisturbance_noise = {noise}\n"
        )
    };
    let controller = match robot {
        "scara" => {
            gains("joint1", 3.5, 0.6, 0.06, 0.02, 0.1)
                + &gains("joint2", 4.0, 0.65, 0.108, 0.016, 0.055)
                + &gains("joint3", 5.0, 20.0, 0.2, 1.0, 5.0)
                + &gains("joint4", 5.0, 0.3, 1.0, 1.0, 0.05)
        }
        _ => gains("shoulder", 5.0, 4.5, 0.15, 0.1, 0.15) + &gains("elbow", 5.0, 1.8, 0.15, 0.1, 0.04),
    };
    let text = format!(
        "schema = \"lostmotion/scenario/1\"\nname = \"test\"\nrobot = \"../../robots/{robot}/model.toml\"\n{rest}\n\
         [controller]\nvelocity = \"observer\"\n{controller}"
    );
    Scenario::from_text(&text, &root().join("scenarios/01_identify_scara/scenario.toml"), &[]).unwrap()
}

/// A few steps of joint 1's staircase.
const STAIRS: &str = "[reference]
kind = \"staircase\"
start.joint2_deg = 90.0
[reference.joints.joint1]
first_deg = 0.5
last_deg = 2.0
increment_deg = 1.5
acceleration_deg = 6.0
deceleration_deg = 2.0
steady_time = 2.0
settling_way_deg = 3.0";

fn run(scenario: &Scenario, seed: u64) -> Run {
    simulate(scenario, seed, &|_, _| {}).unwrap()
}

fn channel<'a>(series: &'a TimeSeries, joint: &str, channel: Channel) -> &'a [f64] {
    series.joint(joint).and_then(|joint| joint.get(channel)).unwrap()
}

#[test]
fn scenario_all_of_the_catalogue_meet_their_expectations() {
    let mut files: Vec<PathBuf> = std::fs::read_dir(root().join("scenarios"))
        .unwrap()
        .map(|entry| entry.unwrap().path().join("scenario.toml"))
        .filter(|file| file.is_file())
        .collect();
    files.sort();
    assert!(files.len() >= 3, "{files:?}");
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        if text.contains("\ndata = ") {
            assert!(file.with_file_name("README.md").is_file(), "{} has no README.md", file.display());
            // Carried out by tests/readme.
            continue;
        }
        let scenario = Scenario::load(&file, &[]).unwrap_or_else(|error| panic!("{error}"));
        assert!(file.with_file_name("README.md").is_file(), "{} has no README.md", file.display());
        let run = run(&scenario, scenario.seed);
        assert_eq!(run.sessions.len(), scenario.sessions.len());
        if scenario.procedure == Procedure::Identify {
            let mut found = identify::identify(&scenario.model, &run.measured(), &Options::default()).unwrap();
            scenario.truth.compare(&mut found);
            let unmet: Vec<String> = (scenario.expectations.iter())
                .filter_map(|expectation| Some(expectation.check(&found)?.to_string()))
                .collect();
            assert!(unmet.is_empty(), "{}: {unmet:#?}", file.display());
        }
    }
}

#[test]
fn property_the_staircase_is_steady_where_it_is_measured() {
    let run = run(&scenario("scara", STAIRS), 3);
    let session = &run.sessions[0];
    let [wanted, motor, contact] = [Channel::ReferenceVelocity, Channel::TrueMotorVelocity, Channel::Contact]
        .map(|name| channel(session, "joint1", name));
    let mut windows = 0;
    let mut start = 0;
    while start < wanted.len() {
        let same = wanted[start..].iter().take_while(|&&v| (v - wanted[start]).abs() < 1e-12).count();
        let (velocity, end) = (wanted[start], start + same);
        // The last two fifths of a step: reversal and transient are over.
        let steady = start + same * 3 / 5..end;
        start = end;
        if velocity == 0.0 || same < 1000 || end == wanted.len() {
            continue;
        }
        windows += 1;
        let samples = steady.len() as f64;
        let mean = motor[steady.clone()].iter().sum::<f64>() / samples;
        let ripple = (motor[steady.clone()].iter().map(|v| (v - mean).powi(2)).sum::<f64>() / samples).sqrt();
        // One count of 0.034 deg comes every 67 ms at the slowest step; the velocity stays within 2 % between them.
        assert!(ripple < 0.02 * velocity.abs(), "{} deg/s: ripple {} deg/s", velocity / DEG, ripple / DEG);
        assert!((mean / velocity - 1.0).abs() < 0.01, "{} deg/s: {} deg/s", velocity / DEG, mean / DEG);
        assert!(contact[steady].iter().all(|&flank| flank == velocity.signum()), "{} deg/s", velocity / DEG);
    }
    assert_eq!(windows, 4);
}

/// The first time that the motor turns after its reference has, the rotor lies on the flank that drove the link: the gap is still
/// whole. On its way through the gap, where it is alone, it may turn several times more.
#[test]
fn property_the_gap_is_whole_when_the_motor_first_turns() {
    for seed in 3..11 {
        let run = run(&scenario("scara", STAIRS), seed);
        let [wanted, motor, contact] = [Channel::ReferenceVelocity, Channel::TrueMotorVelocity, Channel::Contact]
            .map(|name| channel(&run.sessions[0], "joint1", name));
        let (mut towards, mut turns, mut due) = (0.0, 0, false);
        for k in 1..motor.len() {
            if wanted[k] != 0.0 && wanted[k].signum() != towards {
                due = towards != 0.0;
                towards = wanted[k].signum();
            }
            if due && motor[k].signum() == towards && motor[k] != 0.0 {
                // A sample earlier it rested, or still moved the other way.
                assert!(
                    contact[k - 1] == -towards,
                    "seed {seed}, sample {k}: flank {} before {towards}",
                    contact[k - 1]
                );
                (turns, due) = (turns + 1, false);
            }
        }
        assert_eq!(turns, 3, "seed {seed}");
    }
}

#[test]
fn property_a_seed_decides_everything_and_seeds_differ() {
    let scenario = scenario(
        "scara",
        "[reference]\nkind = \"waypoints\"\n[reference.joints.joint1]\npositions_deg = [3, 0]\nspeed_deg = 10\nacceleration_deg = 20",
    );
    let first = run(&scenario, 7);
    assert_eq!(first, run(&scenario, 7));
    assert_ne!(first, run(&scenario, 8));
}

#[test]
fn property_ideal_sensors_say_the_truth_and_measured_hides_it() {
    let scenario = scenario(
        "scara",
        "sensors = \"ideal\"\n[reference]\nkind = \"waypoints\"\n[reference.joints.joint2]\npositions_deg = [3, 0]\nspeed_deg = 10\nacceleration_deg = 20",
    );
    let run = run(&scenario, 1);
    let joint = |name| channel(&run.sessions[0], "joint2", name);
    assert_eq!(joint(Channel::Position), joint(Channel::TrueMotorPosition));
    assert_eq!(joint(Channel::Velocity), joint(Channel::TrueMotorVelocity));
    assert_eq!(joint(Channel::Current), joint(Channel::TrueCurrent));
    let hidden = run.measured();
    assert!(hidden[0].joint("joint2").unwrap().get(Channel::TrueLinkPosition).is_none());
    assert_eq!(channel(&hidden[0], "joint2", Channel::Position), joint(Channel::Position));
}

#[test]
fn property_sessions_start_anew_each_with_its_own_noise() {
    let session = |name: &str| format!("[[session]]\nname = \"{name}\"\nkind = \"rest\"\nduration = 0.2\n");
    let run = run(&scenario("elbow", &(session("a") + &session("b"))), 1);
    assert_eq!(run.sessions.iter().map(|session| session.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    assert_eq!(run.sessions[0].time[0], 0.0);
    assert_eq!(run.sessions[0].len(), 201);
    let current = |k: usize| channel(&run.sessions[k], "elbow", Channel::Current);
    assert_ne!(current(0), current(1));
}

#[test]
fn property_motions_beyond_the_limits_are_refused_with_joint_and_time() {
    let scenario = scenario(
        "scara",
        "[reference]\nkind = \"waypoints\"\n[reference.joints.joint2]\npositions_deg = [140]\nspeed_deg = 20\nacceleration_deg = 40",
    );
    let Err(Error::Motion(refusal)) = simulate(&scenario, 1, &|_, _| {}) else { panic!("not refused") };
    // Half a second of rest, half a second to 20 deg/s over 5 degrees, then 130 degrees at 20 deg/s.
    assert!((refusal.time - 7.5).abs() < 0.02, "{} s", refusal.time);
    let MotionFault::Limit { joint, .. } = &refusal.cause else { panic!("{refusal}") };
    assert_eq!(joint, "joint2");
}

#[test]
fn property_motions_that_collide_are_refused_with_both_links() {
    // The forearm folded up beside the upper arm meets nothing; a bracket that is moved into its way does.
    let folder = tempfile::tempdir().unwrap();
    for (name, from, to) in
        [("elbow.urdf", "<origin xyz=\"0 0.13 0.10\"/>", "<origin xyz=\"0.3 0 0.1\"/>"), ("model.toml", "", "")]
    {
        let text = std::fs::read_to_string(root().join("robots/elbow").join(name)).unwrap();
        assert!(text.contains(from));
        std::fs::write(folder.path().join(name), text.replacen(from, to, 1)).unwrap();
    }
    let text = std::fs::read_to_string(root().join("scenarios/03_identify_elbow/scenario.toml")).unwrap();
    let text = text.replace("../../robots/elbow/", "");
    let blocked = Scenario::from_text(&text, &folder.path().join("scenario.toml"), &[]).unwrap();
    let Err(Error::Motion(refusal)) = simulate(&blocked, 1, &|_, _| {}) else { panic!("not refused") };
    let MotionFault::Collision { first, second } = &refusal.cause else { panic!("{refusal}") };
    assert!([first, second].iter().any(|link| link.as_str() == "bracket"), "{first} and {second}");
}

#[test]
fn property_assignments_change_scenario_and_model() {
    let file = root().join("scenarios/01_identify_scara/scenario.toml");
    let set = |assignments: &[&str]| {
        Scenario::load(&file, &assignments.iter().map(|&text| text.to_owned()).collect::<Vec<_>>())
    };
    let changed = set(&["seed=9", "model.joints.joint1.backlash=0.001", "sensors=ideal"]).unwrap();
    assert_eq!(changed.seed, 9);
    assert_eq!(changed.truth.backlash("joint1"), Some(0.001));
    assert!(changed.options.ideal_sensors);
    for (assignment, part) in [
        ("seed", "KEY=VALUE"),
        ("control_period=fast", "1e-6"),
        ("model.joints.joint9.backlash=0.1", "joint9"),
        ("robot=nowhere.toml", "model file that exists"),
    ] {
        let error = set(&[assignment]).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains(part), "{assignment}: {error}");
    }
}

#[test]
fn property_an_expectation_that_nothing_measured_fails() {
    let scenario = Scenario::load(Path::new(&root().join("scenarios/01_identify_scara/scenario.toml")), &[]).unwrap();
    let nothing = identify::Identification { joints: Vec::new(), left_out: Vec::new() };
    assert!(!scenario.expectations.is_empty());
    for expectation in &scenario.expectations {
        let unmet = expectation.check(&nothing).expect("not met by nothing");
        assert!(unmet.to_string().contains("not identified"), "{unmet}");
    }
}

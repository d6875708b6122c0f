//! Model files that leave out what is unknown: they are read, written, simulated and diagnosed without it.

use std::path::{Path, PathBuf};

use crate::rigid_arm::{INTERVAL, arm, fast_sessions, record, with};
use lostmotion::dataset::{Session, meet};
use lostmotion::diagnose::{Diagnosis, Options, Verdict, diagnose};
use lostmotion::drive::Encoder;
use lostmotion::error::Error;
use lostmotion::gearhead::rigid::{OMEGA, OMEGA_MAX, ROTOR_SHARE};
use lostmotion::plant::{self, Plant};
use lostmotion::replay;
use lostmotion::robot::{Accuracy, JointModel, Model};
use lostmotion::scenario::Findings;
use lostmotion::timeseries::{Channel, TimeSeries};

/// Inertia [kg·m²] of the arm's rotors at the motor shaft.
const ROTOR: f64 = 0.0008;

/// Takes values away from a joint.
type Forget = fn(&mut JointModel);

/// What a model file may leave out, by the word that is then not in it.
const UNKNOWN: [(&str, Forget); 5] = [
    ("gear_stiffness =", |joint| joint.gear_stiffness = None),
    ("gear_damping =", |joint| joint.gear_damping = None),
    ("rotor_inertia =", |joint| joint.rotor_inertia = None),
    ("motor]", |joint| joint.motor = None),
    ("gear_stiffness =", |joint| {
        (joint.gear_stiffness, joint.gear_damping, joint.rotor_inertia, joint.motor) = (None, None, None, None);
    }),
];

/// The arm without a value on its first joint.
fn without(forget: Forget, with_friction: bool) -> Model {
    let mut model = arm(with_friction);
    forget(&mut model.joints[0]);
    model
}

/// A recording as seen by a machine without motors: torques in place of currents.
fn as_torque(series: &TimeSeries) -> TimeSeries {
    let mut series = series.clone();
    for (joint, model) in series.joints.iter_mut().zip(&arm(true).joints) {
        let current = joint.channels.remove(&Channel::Current).expect("a current");
        let torque: Vec<f64> = current.iter().map(|i| model.torque_per_ampere() * i).collect();
        joint.channels.insert(Channel::Torque, torque.into());
    }
    series
}

fn session(series: TimeSeries) -> Session {
    let controllers = vec![None; series.joints.len()];
    Session { series, notes: Vec::new(), source: PathBuf::from("made.csv"), controllers }
}

/// The first seconds of a recording.
fn beginning(series: &TimeSeries, seconds: f64) -> TimeSeries {
    let samples = (seconds / INTERVAL) as usize;
    let mut short = series.clone();
    short.time.truncate(samples);
    for joint in &mut short.joints {
        joint.channels.values_mut().for_each(|values| *values = values[..samples].to_vec().into());
    }
    short
}

fn diagnosed(model: &Model, sessions: &[TimeSeries]) -> Diagnosis {
    diagnose(model, sessions, &[], &Options::default(), &mut |_, _| {}).expect("a diagnosis")
}

#[test]
fn property_what_is_unknown_is_not_written() {
    for (word, forget) in UNKNOWN {
        let model = without(forget, true);
        let text = model.to_toml(Path::new("arm.urdf"));
        assert_eq!(text.matches(word).count(), 1, "{word} of the second joint alone:\n{text}");
        let again = Model::from_texts(&text, &model.urdf_text, Path::new("model.toml")).expect("a good model");
        assert_eq!(again.joints, model.joints);
    }
}

/// One second of the recording, the model in the loop of the replay: it follows the links as the complete model does.
#[test]
fn property_a_model_without_a_value_is_simulated() {
    let recorded = beginning(&as_torque(&fast_sessions(70)[0]), 1.0);
    for (word, forget) in UNKNOWN {
        let model = without(forget, true);
        let replayed = replay::replay(&model, &session(recorded.clone()), &replay::Options::default()).expect(word);
        for error in replayed.errors.iter().filter(|error| error.quantity == replay::Observable::Position) {
            // The loop of the replay has 2 Hz or more: an unknown rotor of a tenth of the inertia leaves parts of the motion's 0.1 rad.
            assert!(error.rms < 0.01, "without {word}: {error:?}");
        }
    }
}

/// Rotor and link together are carried at 50 Hz; a rotor that is light for that oscillates at 500 Hz and is damped by 0.79.
#[test]
fn analytic_a_rigid_gear_carries_its_link_at_50_hz() {
    let model = without(|joint| (joint.gear_stiffness, joint.gear_damping) = (None, None), true);
    let flanks = model.joints[0].flanks(0.0, 0.3, 1.0 / 0.1 + 1.0 / 0.2);
    assert!((flanks.stiffness - OMEGA.powi(2) * 0.3).abs() < 1e-9 * flanks.stiffness);
    let mobility = 1e4;
    let flanks = model.joints[0].flanks(0.0, 0.3, mobility);
    assert!((flanks.stiffness * mobility / OMEGA_MAX.powi(2) - 1.0).abs() < 1e-12);
    // ζ = d √(A/k)/2
    let ratio = 0.5 * flanks.damping * (mobility / flanks.stiffness).sqrt();
    assert!((ratio - 0.785).abs() < 1e-3, "{ratio}");
    // A plant takes steps of 0.45 of the fastest mode; those of two joints are at most √2 faster than each alone.
    let mut rigid = arm(true);
    rigid.joints.iter_mut().for_each(|joint| (joint.gear_stiffness, joint.gear_damping) = (None, None));
    let plant = Plant::new(&rigid, &plant::Options::default()).expect("a machine");
    assert!(plant.step_rate(1e-3) <= 2.0_f64.sqrt() * OMEGA_MAX / 0.45);
}

#[test]
fn analytic_an_unknown_rotor_is_a_share_of_its_link() {
    let model = without(|joint| joint.rotor_inertia = None, true);
    assert_eq!(model.joints[0].reflected_inertia(), 0.0);
    assert_eq!(model.joints[0].rotor_beside(0.4), ROTOR_SHARE * 0.4);
    assert_eq!(model.joints[1].rotor_beside(0.4), model.joints[1].reflected_inertia());
}

/// Nothing is hidden: nothing is named, whatever the model file leaves out.
#[test]
#[ignore = "long: .ci/long carries it out"]
fn recover_nothing_from_a_healthy_arm_without_values() {
    let sessions: Vec<TimeSeries> = fast_sessions(70).iter().map(as_torque).collect();
    for (word, forget) in UNKNOWN {
        let found = diagnosed(&without(forget, false), &sessions);
        assert_eq!(found.verdict, Verdict::NothingFound, "without {word}: {:?} {:?}", found.effects, found.mistakes);
    }
}

#[test]
fn recover_the_inertia_of_an_unknown_rotor() {
    let model = without(|joint| joint.rotor_inertia = None, false);
    let found = diagnosed(&model, &fast_sessions(71));
    let fitted = found.baseline["joint1"].rotor_inertia.as_ref().expect("an inertia");
    assert!((fitted.value - ROTOR).abs() < 4.0 * fitted.std_error, "{fitted:?}");
    // Accelerations of up to 100 rad/s² on 0.02 kg·m² against 10 mN·m of noise.
    assert!(fitted.std_error < 0.03 * ROTOR, "{fitted:?}");
    assert_eq!(found.extended_model.joints[0].rotor_inertia, Some(fitted.value));
    assert_eq!(found.baseline["joint2"].rotor_inertia, None, "given by the model file");
    assert!(found.effects.is_empty(), "{:?}", found.effects);
}

/// The arm as a first model states it, torque constants several times too large and too small.
fn with_guessed_constants() -> Model {
    let mut model = arm(false);
    model.accuracy = Accuracy { torque_constants: 1.0, ..Accuracy::EXACT };
    for (joint, factor) in model.joints.iter_mut().zip([5.0, 0.2]) {
        joint.motor.as_mut().expect("a motor").torque_constant *= factor;
    }
    model
}

/// Torque constants of a diagnosis over the true ones.
fn constants(found: &Diagnosis) -> Vec<f64> {
    let of = |joint: &JointModel| joint.motor.as_ref().expect("a motor").torque_constant;
    found.extended_model.joints.iter().zip(&arm(false).joints).map(|(found, truth)| of(found) / of(truth)).collect()
}

/// The inertia of exact links shows both constants. No error of a constant is sought, as the model file claims none.
#[test]
fn recover_torque_constants_that_are_guesses() {
    let found = diagnosed(&with_guessed_constants(), &fast_sessions(74));
    assert!(found.effects.is_empty() && found.mistakes.is_empty(), "{:?} {:?}", found.effects, found.mistakes);
    for constant in constants(&found) {
        // Inertias take up to 2 N·m beside 10 mN·m of noise in thousands of rows; kernels flatten the fastest motion by some 0.1 %.
        assert!((constant - 1.0).abs() < 0.01, "{constant}");
    }
    assert!(found.method.baseline.contains("joint1 0.100 to 0.0"), "{}", found.method.baseline);
    let sought = |effect: &str| found.candidates.iter().any(|candidate| candidate.effect == effect);
    assert!(sought("payload") && !sought("torque_constant_error"), "{:?}", found.candidates);
}

/// A load acts on both joints in newton metres, whatever their constants are guessed to be: the arm hangs, and its weight shows both.
#[test]
fn recover_a_load_beside_torque_constants_that_are_guesses() {
    let mass = 0.3;
    let hanging = |mut model: Model| {
        model.robot.gravity = nalgebra::Vector3::new(9.81, 0.0, 0.0);
        model
    };
    let loaded = hanging(with("payload", None, &[("mass", mass), ("x", 0.24)]));
    let session = |k: u64| record(&format!("loaded_{k}"), &loaded, 80 + k, &|_, _, _| 0.0);
    let found = diagnosed(&hanging(with_guessed_constants()), &(0..4).map(session).collect::<Vec<_>>());
    let first = found.effects.first().unwrap_or_else(|| panic!("{:?} {:?}", found.mistakes, found.verdict));
    assert_eq!(first.effect, "payload");
    let measured = &first.parameters["mass"];
    // Three standard errors, which contain those of the constants.
    assert!((measured.value - mass).abs() < 3.0 * measured.std_error, "{measured:?}");
    for constant in constants(&found) {
        // Twice as much as without a load, whose mass and place are fitted beside the constants.
        assert!((constant - 1.0).abs() < 0.02, "{constant}");
    }
}

#[test]
fn regress_a_current_without_a_torque_constant_is_refused() {
    let model = without(|joint| joint.motor = None, true);
    let text = model.to_toml(Path::new("arm.urdf"));
    let model = Model::from_texts(&text, &model.urdf_text, Path::new("model.toml")).expect("a good model");
    let recorded = session(beginning(&fast_sessions(72)[0], 1.0));
    let Err(Error::Input(fault)) = meet(&model, &[&recorded]) else { panic!("expected an error") };
    assert_eq!(fault.file, Path::new("model.toml"));
    assert_eq!(fault.key, "joints.joint1.motor.torque_constant");
    assert!(fault.expected.ends_with("since the recording has a current and no torque"), "{fault}");
    assert!(fault.to_string().starts_with("model.toml:5: "), "the table of the joint: {fault}");
    let torque = session(as_torque(&recorded.series));
    assert!(meet(&model, &[&torque]).is_ok());
}

#[test]
fn recover_an_unknown_encoder_from_the_positions() {
    let model = arm(true);
    assert_eq!(model.joints[0].encoder, None);
    let mut recorded = session(fast_sessions(73)[0].clone());
    assert_eq!(meet(&model, &[&recorded]).expect("a model").joints[0].encoder, None, "exact positions");
    let encoder = Encoder { counts_per_turn: 2000.0 };
    let step = JointModel { encoder: Some(encoder), ..model.joints[0].clone() }.encoder_step();
    let position = recorded.series.joints[0].channels.get_mut(&Channel::Position).expect("a position");
    *position = position.iter().map(|q| (q / step).round() * step).collect::<Vec<f64>>().into();
    let met = meet(&model, &[&recorded]).expect("a model");
    let found = met.joints[0].encoder.expect("an encoder").counts_per_turn;
    assert!((found / 2000.0 - 1.0).abs() < 1e-6, "{found}");
    assert_eq!(met.joints[1].encoder, None);
    // Findings complete the model themselves.
    let findings = Findings::new(&model, vec![recorded], Vec::new(), &mut |_, _| {}).expect("a diagnosis");
    assert_eq!(findings.diagnosis.baseline_model.joints[0].encoder, met.joints[0].encoder);
}

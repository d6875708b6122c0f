//! The same arm with torque sensors behind its gears: position of the motors and torque on the links, no current.

use lostmotion::diagnose::Verdict;
use lostmotion::timeseries::{Channel, JointSeries};

use super::*;

/// [N·m] Resolution of the torque sensors.
const RESOLUTION: f64 = 0.02;

/// Position and torque through the gear, the torque in this channel.
fn sensed(machine: &Model, effects: &[EffectEntry], seed: u64, channel: Channel) -> Vec<TimeSeries> {
    let mut run = simulated(machine, effects, seed);
    for joint in run.sessions.iter_mut().flat_map(|session| &mut session.joints) {
        let taken = |from: Channel| joint.channels.get(&from).expect("a recorded channel").clone();
        let torque: Vec<f64> =
            taken(Channel::GearTorque).iter().map(|torque| (torque / RESOLUTION).round() * RESOLUTION).collect();
        let channels = [(Channel::Position, taken(Channel::Position)), (channel, torque.into())];
        *joint = JointSeries { name: joint.name.clone(), channels: channels.into() };
    }
    run.sessions
}

/// A model whose rotors are three times too heavy: a sensor behind the gear does not see them.
fn heavy_rotors() -> Model {
    let mut model = symmetric();
    for joint in &mut model.joints {
        joint.rotor_inertia = joint.rotor_inertia.map(|inertia| 3.0 * inertia);
    }
    model
}

/// What a motor does is not in the torque on its link: neither its rotor and friction nor effects that live on its side.
#[test]
fn property_nothing_of_the_motor_is_found_behind_the_gear() {
    let hidden = [
        effect("rotor_inertia", Some("joint2"), &[("error", 0.5)]),
        effect("torque_constant_error", Some("joint3"), &[("error", 0.15)]),
        effect("current_offset", Some("joint1"), &[("offset", 0.1)]),
    ];
    let recorded = sensed(&symmetric(), &hidden, 71, Channel::LinkTorque);
    let found = diagnosed_from(heavy_rotors(), &recorded);
    assert!(found.effects.is_empty() && found.mistakes.is_empty(), "{:?} {:?}", found.effects, found.mistakes);
    for (joint, nominal) in found.extended_model.joints.iter().zip(&heavy_rotors().joints) {
        assert_eq!((joint.rotor_inertia, &joint.motor), (nominal.rotor_inertia, &nominal.motor));
        // A tenth of the friction acts behind the gear: half of it separates that from the whole.
        let (measured, whole) = (&found.baseline[&joint.name].friction["coulomb"], coulomb(&joint.name));
        println!("{}: {measured:?} of {whole}", joint.name);
        assert!(measured.value.abs() < 0.5 * whole, "{}: {measured:?} of {whole}", joint.name);
    }
}

fn coulomb(name: &str) -> f64 {
    let model = symmetric();
    let joint = model.joints.iter().find(|joint| joint.name == name).expect("a joint of the arm");
    joint.friction.expect("friction").law.coulomb(lostmotion::gearhead::Direction::Positive)
}

#[test]
fn recover_a_heavier_tool_behind_the_gears() {
    let planted = [("mass", 1.0), ("x", 0.09), ("z", 0.022)];
    let found = diagnosed_from(
        heavy_rotors(),
        &sensed(&symmetric(), &[effect("payload", None, &planted)], 72, Channel::LinkTorque),
    );
    assert_eq!(first(&found).0, "payload");
    let mass = &found.effects[0].parameters["mass"];
    // Three standard errors, and a tenth of the value for the sensor's good resolution.
    assert!((mass.value - 1.0).abs() < 3.0 * mass.std_error && mass.std_error < 0.1, "{mass:?}");
}

/// The same torque taken for that of the motors: rotors and friction are missing in it, and that is said.
#[test]
#[ignore = "long: .ci/long carries it out"]
fn property_the_place_of_the_sensor_matters() {
    let found = diagnosed_from(heavy_rotors(), &sensed(&symmetric(), &[], 71, Channel::Torque));
    println!("{:?} {:?}", found.verdict, found.mistakes);
    assert_ne!(found.verdict, Verdict::NothingFound);
}

//! A spring balancer planted in simulated machines with their sensors and controllers: named first on its joint, beside exact and rough models.

use crate::drawn::Drawn;
use crate::hidden::{Arm, Field, Order};
use crate::sines;
use crate::told;
use lostmotion::diagnose::{Diagnosis, Options, diagnose};
use lostmotion::robot::{Accuracy, EffectEntry, Model};
use lostmotion::timeseries::TimeSeries;
use rayon::prelude::*;

fn counterbalance(joint: &str, amplitude: f64, angle: f64) -> EffectEntry {
    let parameters = [("amplitude", amplitude), ("angle", angle)].map(|(name, value)| (name.to_owned(), value)).into();
    EffectEntry { effect: "counterbalance".to_owned(), joint: Some(joint.to_owned()), parameters }
}

fn diagnosed(nominal: &Model, sessions: &[TimeSeries]) -> Diagnosis {
    let options = Options { backlash: false, ..Options::default() };
    let (train, hold_out) = sessions.split_at(sessions.len() - 1);
    let found = diagnose(nominal, train, hold_out, &options, &mut |_, _| {}).expect("a diagnosis");
    told::print(&found);
    found
}

fn machine(arm: Arm, rough: f64, seed: u64) -> Drawn {
    Drawn::new(&Order { field: Some(Field { arm, rough }), ..Order::nothing(seed) })
}

fn assert_first(found: &Diagnosis, joint: &str, amplitude: f64) {
    let first = found.effects.first().expect("something is found");
    assert_eq!((first.effect.as_str(), &first.joints[..]), ("counterbalance", &[joint.to_owned()][..]));
    let measured = &first.parameters["amplitude"];
    // One in a hundred estimates lies outside 2.6 standard errors; an error of 30 % or more would be no measurement.
    assert!((measured.value - amplitude).abs() < 2.6 * measured.std_error, "{measured:?}");
    assert!(measured.std_error < 0.3 * amplitude, "{measured:?}");
}

#[test]
fn recover_a_counterbalance_on_the_planar_arm() {
    [(0.0, 33_100), (1.0, 33_101)].into_par_iter().for_each(|(rough, seed)| {
        let amplitude = 0.2;
        let mut drawn = machine(Arm::Planar, rough, seed);
        drawn.entries = vec![counterbalance("joint1", amplitude, 0.8)];
        assert_first(&diagnosed(&drawn.nominal, &drawn.sessions().collect::<Vec<_>>()), "joint1", amplitude);
    });
}

/// On the second axis of a large arm, whose links are known: 20 N·m. Beside masses that are off by 10 %, gravity of the links before a level
/// axis takes it for its own, and `link_inertia` is named.
#[test]
#[ignore = "long: .ci/long carries it out"]
fn recover_a_counterbalance_on_the_second_of_six_joints() {
    let amplitude = 20.0;
    let mut drawn = machine(Arm::SixJoints, 0.0, 33_110);
    drawn.entries = vec![counterbalance("joint2", amplitude, -0.4)];
    assert_first(&diagnosed(&drawn.nominal, &drawn.sessions().collect::<Vec<_>>()), "joint2", amplitude);
}

/// On a single level axis, with inertias known to 15 % and rotors to 10 %. A load that left no larger an error would be named instead.
#[test]
fn recover_a_counterbalance_on_a_level_axis_that_accelerates() {
    let level = |mut model: Model| {
        model.robot.gravity = nalgebra::Vector3::new(0.0, -9.81, 0.0);
        model.accuracy = Accuracy { inertias: 0.15, rotor_inertias: 0.1, ..Accuracy::EXACT };
        model
    };
    let amplitude = 0.15;
    let mut machine = level(sines::nominal());
    machine.effects = vec![counterbalance("joint1", amplitude, -1.2)];
    let sessions: Vec<TimeSeries> = (1..=3).map(|number| sines::recorded(&machine, number)).collect();
    assert_first(&diagnosed(&level(sines::nominal()), &sessions), "joint1", amplitude);
}

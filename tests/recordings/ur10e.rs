//! A UR10e on the same path without and with a load of 2.805 kg, by dynamic_calibration of Sh. Mamedov.

use lostmotion::dataset;
use lostmotion::diagnose::{Diagnosis, Options, compare, compared_channels, diagnose};
use lostmotion::robot::Model;
use lostmotion::timeseries::TimeSeries;

/// The model as the program takes it, with what the recordings say about the sensors.
fn machine(recordings: &[&str]) -> (Model, Vec<TimeSeries>) {
    let folder = super::recordings().expect("the folder of recordings").join("arms/ur10e");
    let model = Model::load(&folder.join("model.toml")).expect("the nominal model");
    let read = |name: &&str| dataset::load_for(&folder.join(name), &model).expect("a recording");
    let sessions: Vec<_> = recordings.iter().map(read).collect();
    let met = dataset::meet(&model, &sessions.iter().collect::<Vec<_>>()).expect("a model for these recordings");
    (met, sessions.into_iter().map(|session| session.series).collect())
}

/// Strain wave gears have friction that grows with their load. Fitted with the load in two recordings at once, by plain least squares with free
/// inertias, it is 0.064 to 0.068 on the second joint in all three pairs. Without the load a single recording hardly tells load from posture, so
/// that half of that is allowed. In this recording five names of the wrist joints are taken first and withdrawn again.
pub fn friction_grows_with_load() {
    let (model, recorded) = machine(&["reference_2.csv"]);
    let found = diagnose(&model, &recorded, &[], &Options::default(), &mut |_, _| {}).expect("a diagnosis");
    let [effect] = found.effects.as_slice() else { panic!("{:?}", found.effects) };
    assert_eq!(
        (effect.effect.as_str(), effect.joints.as_slice()),
        ("load_dependent_friction", &["shoulder_lift_joint".to_owned()][..])
    );
    let coefficient = &effect.parameters["coefficient"];
    assert!((0.03..0.10).contains(&coefficient.value), "{coefficient:?}");
}

/// The three wrists of a UR10e have the same actuator. The published model gives the third one's rotor 4.3e-5 kg·m², and those of the first and second
/// 0.7e-5 and 2.3e-5: their inertias were identified with links that weigh more. A load, which is withdrawn, first explains most of the first one's torque.
pub fn wrists_have_one_actuator() {
    let (model, recorded) = machine(&["reference_1.csv", "reference_2.csv", "reference_3.csv"]);
    let found = diagnose(&model, &recorded, &[], &Options::default(), &mut |_, _| {}).expect("a diagnosis");
    let rotor = |name: &str| model.joints.iter().find(|joint| joint.name == name).and_then(|joint| joint.rotor_inertia);
    let published = rotor("wrist_3_joint").expect("a rotor's inertia");
    for wrist in ["wrist_1_joint", "wrist_2_joint"] {
        let is_it = |one: &&lostmotion::diagnose::FoundEffect| one.effect == "rotor_inertia" && one.joints == [wrist];
        let error = &found.effects.iter().find(is_it).expect("an error of the rotor's inertia").parameters["error"];
        let [value, std_error] = [1.0 + error.value, error.std_error].map(|share| share * rotor(wrist).expect("one"));
        println!("{wrist}: {value:.2e} ± {std_error:.1e} kg·m², wrist_3_joint {published:.2e}");
        // Three standard errors, and what actuators of one kind differ by: oil, seals and brakes.
        assert!((value - published).abs() < 3.0 * std_error + 0.05 * published, "{wrist}: {value}");
    }
}

fn compared(reference: &str, now: &str) -> Diagnosis {
    let (model, mut recorded) = machine(&[reference, now]);
    recorded.iter_mut().for_each(|series| series.keep(&compared_channels()));
    compare(&model, &recorded[..1], &recorded[1..], &[], &Options::default(), &mut |_, _| {}).expect("a comparison")
}

/// 5 % of the load: as accurate as torque constants are known.
pub fn carries_the_load() {
    for (reference, now, sign) in [
        ("reference_1.csv", "now_1.csv", 1.0),
        ("reference_2.csv", "now_2.csv", 1.0),
        ("reference_3.csv", "now_3.csv", 1.0),
        ("reference_1.csv", "now_2.csv", 1.0),
        ("now_1.csv", "reference_1.csv", -1.0),
    ] {
        let found = compared(reference, now);
        let first = &found.effects[0];
        let mass = first.parameters.get("mass").map(|mass| mass.value);
        println!("{reference}, {now}: {} {mass:?}", first.effect);
        assert_eq!(first.effect, "payload");
        assert!(mass.is_some_and(|mass| (sign * mass - 2.80).abs() < 0.15), "{mass:?}");
    }
    let found = compared("reference_1.csv", "reference_2.csv");
    assert!(found.effects.is_empty(), "{:?}", found.effects);
}

//! Effects added to the currents of recordings of others, with their sensors and the errors of their models.

use lostmotion::dataset;
use lostmotion::diagnose::{Diagnosis, Options, diagnose};
use lostmotion::robot::Model;
use lostmotion::timeseries::TimeSeries;

use super::added::{Moved, added};

/// A diagnosis of recordings to which an effect was added on one joint, and the true value of a parameter.
fn with(effect: &str, torque: f64, joint: usize, model: &str, [train, held_out]: [&[&str]; 2]) -> (Diagnosis, f64) {
    let folder = super::recordings().expect("the folder of recordings").join("arms");
    let nominal = Model::load(&folder.join(model)).expect("the nominal model");
    let read = |name: &&str| dataset::load_for(&folder.join(name), &nominal).expect("a recording");
    let read: Vec<_> = train.iter().chain(held_out).map(read).collect();
    let model = dataset::meet(&nominal, &read.iter().collect::<Vec<_>>()).expect("a model for these recordings");
    let all: Vec<TimeSeries> = read.into_iter().map(|session| session.series).collect();
    let one = added(effect, torque, Moved::new(&all, joint), &model, joint);
    let altered: Vec<TimeSeries> = all.iter().map(|session| one.to(session, &model, joint)).collect();
    let options = Options { backlash: false, ..Options::default() };
    let (train, held_out) = altered.split_at(train.len());
    let found = diagnose(&model, train, held_out, &options, &mut |_, _| {}).expect("a diagnosis");
    (found, one.truth.expect("a known size").1)
}

/// The motor is the joint, so that it passes less than one turn, and rows of constant direction show a part of the wave alone. A contact
/// describes it in the training data, and leaves four times as much of the data held out.
pub fn ripple_is_no_contact() {
    let file = |stiffness: &str, motion: &str| format!("bam_xl330/{stiffness}_{motion}.csv");
    let motions = ["lift_and_drop", "sin_sin", "sin_time_square", "up_and_down"];
    let train: Vec<String> = ["kp100", "kp200", "kp400"].iter().flat_map(|k| motions.map(|m| file(k, m))).collect();
    let held_out = motions.map(|motion| file("kp800", motion));
    let [train, held_out] = [&train[..], &held_out].map(|files| files.iter().map(String::as_str).collect::<Vec<_>>());
    let (found, _) = with("cogging", 0.06, 0, "bam_xl330/model.toml", [&train, &held_out]);
    let names: Vec<&str> = found.effects.iter().map(|one| one.effect.as_str()).collect();
    assert_eq!(names, ["velocity_lag"]);
    assert!(found.unexplained.iter().any(|one| one.joint == "joint1"), "{:?}", found.unexplained);
}

/// Currents with noise that is larger in the rate of a row's torque than the rate itself, and 12 ms late.
pub fn late_currents_show_in_noise() {
    let train = ["six_axis_none/slow.csv", "six_axis_none/fast_1.csv", "six_axis_none/fast_2.csv"];
    let model = "six_axis_none/model_rough_15.toml";
    let (found, truth) = with("sensor_delay", 0.0, 1, model, [&train[..], &["six_axis_none/fast_3.csv"]]);
    let [effect] = found.effects.as_slice() else { panic!("{:?}", found.effects) };
    assert_eq!(effect.effect, "sensor_delay");
    let delay = &effect.parameters["current_delay"];
    assert!((delay.value - truth).abs() < 2.0 * delay.std_error, "{delay:?}");
    // Less than one interval of the sampling.
    assert!(delay.std_error < 0.002, "{delay:?}");
}

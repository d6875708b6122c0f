//! Uneven sampling, pauses, and a velocity channel that lags: simulated recordings with and without, even and uneven.

#[path = "support/machines.rs"]
mod machines;

use std::collections::BTreeMap;

use lostmotion::diagnose::{Diagnosis, Options, diagnose};
use lostmotion::drive::VelocitySensor;
use lostmotion::effects::Kind;
use lostmotion::plant::{Options as PlantOptions, Plant};
use lostmotion::robot::{EffectEntry, JointModel, Model};
use lostmotion::timeseries::{Channel, JointSeries, TimeSeries};
use machines::*;

/// [s] Sample interval of the simulated controller.
const STEP: f64 = 1e-3;
/// [s] Length of a session.
const SECONDS: f64 = 16.0;
/// [s] `τ` of the velocity sensor in the model file.
const NOMINAL: f64 = 0.005;
/// Standard errors within which a planted value has to be recovered: 1 in 80 estimates lies outside.
const WITHIN: f64 = 2.5;

/// One joint without a gap, with friction, encoder and noisy current.
fn nominal() -> Model {
    let joint = scara().joints.remove(0);
    let velocity_sensor = Some(VelocitySensor::LowPass(NOMINAL));
    model(turntable(0.05), vec![JointModel { backlash: Some(0.0), velocity_sensor, ..joint }])
}

fn with(parameters: &[(&str, f64)]) -> Model {
    let mut machine = nominal();
    if !parameters.is_empty() {
        let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        let (effect, joint) = ("velocity_lag".to_owned(), Some("joint1".to_owned()));
        machine.effects.push(EffectEntry { effect, joint, parameters });
    }
    machine
}

/// A session of a machine that follows slow, medium and fast sines.
fn recorded(machine: &Model, number: u32) -> TimeSeries {
    let options = PlantOptions { seed: u64::from(number), ..PlantOptions::default() };
    let mut plant = Plant::new(machine, &options).expect("a plant");
    let mut columns: BTreeMap<Channel, Vec<f64>> = BTreeMap::new();
    let mut time = Vec::new();
    let phase = f64::from(number);
    // Slowly growing, so that it starts at rest.
    let path = |t: f64| {
        let grow = 1.0 - (-t).exp();
        grow * (0.8 * (2.1 * t + phase).sin() + 0.2 * (7.0 * t).sin() + 0.06 * (15.0 * t + 2.0 * phase).sin())
    };
    for k in 0..(SECONDS / STEP) as usize {
        let t = k as f64 * STEP;
        let reading = plant.read()[0];
        time.push(t);
        for (channel, value) in [
            (Channel::Position, reading.position),
            (Channel::Velocity, reading.velocity),
            (Channel::Current, reading.current),
        ] {
            columns.entry(channel).or_default().push(value);
        }
        let state = plant.states()[0];
        let speed = (path(t + STEP) - path(t)) / STEP;
        let torque = 60.0 * (path(t) - state.motor_position) + 4.0 * (speed - state.motor_velocity);
        plant.advance(&[torque.clamp(-9.0, 9.0)], STEP).expect("a step");
    }
    let channels = columns.into_iter().map(|(channel, values)| (channel, values.into())).collect();
    let joints = vec![JointSeries { name: "joint1".to_owned(), channels }];
    TimeSeries { name: format!("session_{number}"), time, joints }
}

/// The samples that `keep` selects.
fn thinned(session: &TimeSeries, keep: impl Fn(usize) -> bool) -> TimeSeries {
    let kept: Vec<usize> = (0..session.len()).filter(|k| keep(*k)).collect();
    let pick = |values: &[f64]| -> Vec<f64> { kept.iter().map(|k| values[*k]).collect() };
    let mut thinned = session.clone();
    thinned.time = pick(&session.time);
    for values in thinned.joints[0].channels.values_mut() {
        *values = pick(values).into();
    }
    thinned
}

/// Steps of 3 to 6 ms, 3 ms in most cases: median 3 ms, mean 3.9 ms.
fn uneven(session: &TimeSeries) -> TimeSeries {
    let mut kept = vec![false; session.len()];
    let mut k = 0;
    for draw in 0_usize.. {
        if k >= kept.len() {
            break;
        }
        kept[k] = true;
        k += [3, 3, 5, 3, 3, 6, 3, 5, 3, 5][(draw * 7 + draw / 5) % 10];
    }
    thinned(session, |k| kept[k])
}

fn diagnosed(sessions: &[TimeSeries]) -> Diagnosis {
    let options = Options { backlash: false, ..Options::default() };
    let (train, hold_out) = sessions.split_at(2);
    diagnose(&nominal(), train, hold_out, &options, &mut |_, _| {}).expect("a diagnosis")
}

fn sessions(parameters: &[(&str, f64)], change: fn(&TimeSeries) -> TimeSeries) -> Vec<TimeSeries> {
    (1..=3).map(|number| change(&recorded(&with(parameters), number))).collect()
}

fn recovers(planted: (&str, f64), other: &str, change: fn(&TimeSeries) -> TimeSeries) {
    let found = diagnosed(&sessions(&[planted], change));
    let lag = found.effects.iter().find(|one| one.effect == "velocity_lag").expect("the lag is named");
    println!("{planted:?}: {:?}, gain {:.0} %", lag.parameters, lag.gain.gain_percent);
    assert_eq!((lag.kind, lag.joints.as_slice()), (Kind::Measurement, ["joint1".to_owned()].as_slice()));
    let measured = &lag.parameters[planted.0];
    assert!((measured.value - planted.1).abs() < WITHIN * measured.std_error, "{measured:?}");
    assert!(!lag.parameters.contains_key(other), "the other lag is ruled out: {:?}", lag.parameters);
    // The lag is nearly all that the channel's error consists of.
    assert!(lag.gain.gain_interval_percent[0] > 50.0, "{:?}", lag.gain);
}

#[test]
fn recover_a_late_velocity_channel() {
    recovers(("delay", 0.02), "time_constant", TimeSeries::clone);
}

#[test]
fn recover_a_late_velocity_channel_at_uneven_times() {
    recovers(("delay", 0.02), "time_constant", uneven);
}

#[test]
fn recover_a_filtered_velocity_channel() {
    recovers(("time_constant", 0.05), "delay", TimeSeries::clone);
}

#[test]
fn recover_a_filtered_velocity_channel_at_uneven_times() {
    recovers(("time_constant", 0.2), "delay", uneven);
}

/// The negative control: the low-pass of the model file, even and uneven samples, and a pause.
#[test]
fn property_nothing_is_found_without_a_lag() {
    let paused = |session: &TimeSeries| thinned(session, |k| !(5000..7000).contains(&k));
    let coarse = |session: &TimeSeries| thinned(session, |k| k % 4 == 0);
    for change in [TimeSeries::clone as fn(&TimeSeries) -> TimeSeries, coarse, uneven, paused] {
        let found = diagnosed(&sessions(&[], change));
        assert!(found.effects.is_empty() && found.mistakes.is_empty(), "{:?} {:?}", found.effects, found.mistakes);
        // 0.442 N·m of Coulomb friction in the simulated machine.
        let coulomb = &found.baseline["joint1"].friction["coulomb"];
        assert!((coulomb.value - 0.442).abs() < 0.02, "{coulomb:?}");
    }
}

#[test]
fn property_a_pause_gets_no_rows_and_ends_no_session() {
    let paused = |session: &TimeSeries| thinned(session, |k| !(5000..7000).contains(&k));
    let found = diagnosed(&sessions(&[], paused));
    assert_eq!(found.series.len(), 3, "one series a session");
    for series in &found.series {
        assert!(series.time.iter().any(|t| *t < 4.9) && series.time.iter().any(|t| *t > 7.1));
        // The widest kernel keeps away from both sides; the narrowest is 6 ms.
        assert!(series.time.iter().all(|t| *t < 4.994 || *t > 7.005), "{:?}", series.time);
    }
}

//! A joint that follows slow, medium and fast sines, recorded at even and at uneven times.

use std::collections::BTreeMap;

use lostmotion::drive::VelocitySensor;
use lostmotion::plant::{Options as PlantOptions, Plant};
use lostmotion::robot::{EffectEntry, JointModel, Model};
use lostmotion::timeseries::{Channel, JointSeries, TimeSeries};

use crate::machines::{model, scara, turntable};

/// [s] Sample interval of the simulated controller.
const STEP: f64 = 1e-3;
/// [s] Length of a session.
const SECONDS: f64 = 16.0;
/// [s] `τ` of the velocity sensor in the model file.
const NOMINAL: f64 = 0.005;
/// One joint without a gap, with friction, encoder and noisy current.
pub fn nominal() -> Model {
    let joint = scara().joints.remove(0);
    let velocity_sensor = Some(VelocitySensor::LowPass(NOMINAL));
    model(turntable(0.05), vec![JointModel { backlash: Some(0.0), velocity_sensor, ..joint }])
}

/// That machine with an effect on its joint; without parameters, it has none.
pub fn with(effect: &str, parameters: &[(&str, f64)]) -> Model {
    let mut machine = nominal();
    if !parameters.is_empty() {
        let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        let (effect, joint) = (effect.to_owned(), Some("joint1".to_owned()));
        machine.effects.push(EffectEntry { effect, joint, parameters });
    }
    machine
}

/// A session of a machine that follows slow, medium and fast sines.
pub fn recorded(machine: &Model, number: u32) -> TimeSeries {
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
pub fn thinned(session: &TimeSeries, keep: impl Fn(usize) -> bool) -> TimeSeries {
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
pub fn uneven(session: &TimeSeries) -> TimeSeries {
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

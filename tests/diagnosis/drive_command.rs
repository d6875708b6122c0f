//! Current against command: the dead band of a drive, on the simulated machine in its velocity loop with noisy, quantised sensors.

use std::collections::BTreeMap;

use crate::machines::scara;
use lostmotion::diagnose::{Diagnosis, Options, diagnose};
use lostmotion::plant::{self, Plant};
use lostmotion::robot::{EffectEntry, Model};
use lostmotion::timeseries::{Channel, JointSeries, TimeSeries};

const INTERVAL: f64 = 1e-3;
const JOINTS: [&str; 2] = ["joint1", "joint2"];

fn with(entries: &[(&str, &str, &str, f64)]) -> Model {
    let mut model = scara();
    model.effects = entries
        .iter()
        .map(|(effect, joint, parameter, value)| EffectEntry {
            effect: (*effect).to_owned(),
            joint: Some((*joint).to_owned()),
            parameters: BTreeMap::from([((*parameter).to_owned(), *value)]),
        })
        .collect();
    model
}

/// Twenty seconds of two sines a joint; the command is logged with the readings that it answers to.
fn record(name: &str, model: &Model, seed: u64) -> TimeSeries {
    let options = plant::Options { step: 5e-4, substeps: 5, seed, ..plant::Options::default() };
    let mut plant = Plant::new(model, &options).expect("a machine");
    let mut joints = JOINTS.map(|name| JointSeries { name: name.to_owned(), ..JointSeries::default() });
    let (mut integral, mut time) = ([0.0; 2], Vec::new());
    let per_ampere: Vec<f64> = model.joints.iter().map(|joint| joint.torque_per_ampere()).collect();
    for k in 0..20_000 {
        let t = f64::from(k) * INTERVAL;
        time.push(t);
        let readings = plant.read().to_vec();
        let mut commands = [0.0; 2];
        for (j, reading) in readings.iter().enumerate() {
            let phase = seed as f64 + j as f64;
            let wanted: f64 = [(0.7, 0.5), (0.4, 0.9)].iter().map(|(a, w)| a * (w * t + phase).sin()).sum();
            let error = wanted * (t / 0.5).min(1.0) - reading.velocity;
            integral[j] += [50.0, 15.0][j] * error * INTERVAL;
            commands[j] = ([5.0, 1.5][j] * error + integral[j]) / per_ampere[j];
            let samples = [
                (Channel::Position, reading.position),
                (Channel::Velocity, reading.velocity),
                (Channel::Current, reading.current),
                (Channel::CommandCurrent, commands[j]),
            ];
            for (channel, value) in samples {
                joints[j].channels.entry(channel).or_default().push(value);
            }
        }
        plant.advance(&commands, INTERVAL).expect("a run");
    }
    TimeSeries { name: name.to_owned(), time, joints: joints.into() }
}

/// What a recorder does to a current.
type Alteration<'a> = &'a dyn Fn(&[f64]) -> Vec<f64>;

/// Two sessions, the second held out, with their currents altered.
fn sessions(truth: &Model, alter: Alteration) -> [TimeSeries; 2] {
    [("one", 41), ("two", 42)].map(|(name, seed)| {
        let mut session = record(name, truth, seed);
        for joint in &mut session.joints {
            if let Some(current) = joint.channels.get_mut(&Channel::Current) {
                *current = alter(current).into();
            }
        }
        session
    })
}

fn diagnosed([train, held_out]: &[TimeSeries; 2]) -> Diagnosis {
    let options = Options { backlash: false, ..Options::default() };
    diagnose(&scara(), std::slice::from_ref(train), std::slice::from_ref(held_out), &options, &mut |_, _| {})
        .expect("a diagnosis")
}

/// Joint, width, standard error.
fn bands(found: &Diagnosis) -> Vec<(String, f64, f64)> {
    let of_band = found.effects.iter().filter(|effect| effect.effect == "drive_dead_band");
    of_band
        .map(|effect| {
            (effect.joints[0].clone(), effect.parameters["width"].value, effect.parameters["width"].std_error)
        })
        .collect()
}

#[test]
fn recover_the_dead_band_of_one_drive() {
    let truth = with(&[("drive_dead_band", "joint2", "width", 0.3)]);
    for late in [0.0, 0.4] {
        // Between samples a late recorder mixes two currents; the sensor's zero is off as well.
        let mix = |current: &[f64]| -> Vec<f64> {
            let before = |k: usize| current[k.saturating_sub(1)];
            (0..current.len()).map(|k| 0.2 + (1.0 - late) * current[k] + late * before(k)).collect()
        };
        let found = diagnosed(&sessions(&truth, &mix));
        let bands = bands(&found);
        assert_eq!(bands.len(), 1, "late by {late} samples: {:?}", found.effects);
        let (joint, width, std_error) = &bands[0];
        assert_eq!(joint, "joint2");
        // Four standard errors are exceeded once in 16,000; the error is that of a band seen in thousands of samples.
        assert!((width - 0.3).abs() < 4.0 * std_error && *std_error < 0.005, "{width} ± {std_error}");
    }
}

#[test]
fn property_a_drive_that_obeys_has_no_dead_band() {
    let same = |current: &[f64]| current.to_vec();
    let late = |current: &[f64]| (0..current.len()).map(|k| current[k.saturating_sub(5)]).collect();
    // 8 ms: a loop that is slower than its commands change.
    let slow = |current: &[f64]| -> Vec<f64> {
        let mut state = 0.0;
        let follow = |i: &f64| {
            state += (i - state) * (1.0 - (-INTERVAL / 0.008_f64).exp());
            state
        };
        current.iter().map(follow).collect()
    };
    let offset = |current: &[f64]| current.iter().map(|i| i + 0.4).collect();
    let alterations: [(&str, Alteration); 4] =
        [("as it is", &same), ("late", &late), ("slow", &slow), ("offset", &offset)];
    for (name, alter) in alterations {
        let found = diagnosed(&sessions(&scara(), alter));
        assert!(bands(&found).is_empty(), "{name}: {:?}", bands(&found));
    }
}

#[test]
fn property_without_a_command_nothing_is_said_of_the_drive() {
    let truth = with(&[("drive_dead_band", "joint2", "width", 0.3)]);
    let mut sessions = sessions(&truth, &|current| current.to_vec());
    for joint in sessions.iter_mut().flat_map(|session| &mut session.joints) {
        joint.channels.remove(&Channel::CommandCurrent);
    }
    assert!(bands(&diagnosed(&sessions)).is_empty());
}

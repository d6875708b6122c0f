//! What a recording says about the torque that the motors gave.

use super::Loop;
use crate::dataset::Session;
use crate::drive::Sensing;
use crate::error::{Error, Place, Result};
use crate::robot::{JointModel, Model};
use crate::timeseries::{Channel, JointSeries};

/// The recorded signals of one joint that a replay needs. Joint side, SI.
#[derive(Debug, Clone)]
pub(super) struct Input {
    /// [rad or m] motor position.
    pub(super) position: Vec<f64>,
    /// [N·m or N] what to ask of the drive from a sample to the next, before any correction.
    pub(super) forward: Vec<f64>,
    /// [N·m or N] what to compare the simulated torque with.
    pub(super) torque: Vec<f64>,
    /// Whether `torque` is what was asked for at a sample, or what was measured then.
    pub(super) commanded: bool,
    /// Whether `torque` is a magnitude: its sign was not measured.
    pub(super) magnitude: bool,
    /// Whether it was recorded at all.
    pub(super) recorded: bool,
}

/// One input a joint of the model. A joint that was not recorded stands still at zero.
///
/// # Errors
/// No joint of the model was recorded; one lacks its position, or torque and current; in open loop nothing says which way it was driven.
pub(super) fn inputs(model: &Model, session: &Session, control: Loop, notes: &mut Vec<String>) -> Result<Vec<Input>> {
    let series = &session.series;
    if !model.joints.iter().any(|joint| series.joint(&joint.name).is_some()) {
        let names: Vec<&str> = model.joints.iter().map(|joint| joint.name.as_str()).collect();
        let expected = format!("a recording of a joint of the model: {}", names.join(", "));
        return Err(Error::input(&session.source, Place::File, "joints", "", expected));
    }
    let mut inputs = Vec::new();
    for joint in &model.joints {
        if joint.friction.is_none() {
            notes.push(format!("friction of {} is unknown: replayed without", joint.name));
        }
        if joint.backlash.is_none() {
            notes.push(format!("gap of {} is unknown: replayed without", joint.name));
        }
        inputs.push(match series.joint(&joint.name) {
            Some(found) => input(joint, found, session, control)?,
            None => {
                notes.push(format!("{} was not recorded: held at zero", joint.name));
                still(series.len())
            }
        });
    }
    Ok(inputs)
}

fn still(samples: usize) -> Input {
    let zeros = vec![0.0; samples];
    Input {
        position: zeros.clone(),
        forward: zeros.clone(),
        torque: zeros,
        commanded: true,
        magnitude: false,
        recorded: false,
    }
}

fn input(joint: &JointModel, series: &JointSeries, session: &Session, control: Loop) -> Result<Input> {
    let missing = |channel: &str| {
        let key = format!("{}.{channel}", series.name);
        Error::input(&session.source, Place::File, key, "(missing)", "a recorded channel")
    };
    let position = series.get(Channel::Position).ok_or_else(|| missing("position"))?.to_vec();
    if let Some(torque) = series.get(Channel::Torque) {
        let (forward, torque) = (torque.to_vec(), torque.to_vec());
        return Ok(Input { position, forward, torque, commanded: true, magnitude: false, recorded: true });
    }
    let torque_of = |channel| {
        let currents = series.get(channel)?.iter();
        Some(currents.map(|current| joint.torque_per_ampere() * current).collect::<Vec<f64>>())
    };
    let magnitude = joint.current_sensor.is_some_and(|sensor| sensor.sensing == Sensing::Absolute);
    match (torque_of(Channel::CommandCurrent), torque_of(Channel::Current)) {
        (Some(forward), Some(torque)) => {
            Ok(Input { position, forward, torque, commanded: false, magnitude, recorded: true })
        }
        (Some(torque), None) => {
            Ok(Input { position, forward: torque.clone(), torque, commanded: true, magnitude: false, recorded: true })
        }
        (None, Some(_)) if magnitude && control == Loop::Open => {
            let key = format!("{}.current", series.name);
            let expected = "a torque, a command or a current with its sign, which alone can drive a model in open loop";
            Err(Error::input(&session.source, Place::File, key, "a magnitude", expected))
        }
        (None, Some(torque)) => {
            let forward = if magnitude { vec![0.0; torque.len()] } else { one_ahead(&torque) };
            Ok(Input { position, forward, torque, commanded: false, magnitude, recorded: true })
        }
        (None, None) => Err(missing("current")),
    }
}

/// Every sample one earlier, the last one twice: a reading shows what was asked for one sample before.
fn one_ahead(samples: &[f64]) -> Vec<f64> {
    samples.iter().skip(1).chain(samples.last()).copied().collect()
}

//! Recorded motor torques, as inputs of a replay.

use super::Loop;
use crate::dataset::Session;
use crate::drive::Sensing;
use crate::effects::{JointState, Reading};
use crate::error::{Error, Place, Result};
use crate::robot::{JointModel, Model};
use crate::timeseries::{Channel, JointSeries, Samples};

/// A recorded signal times a constant; it shares the samples of the recording.
#[derive(Debug, Clone)]
pub(super) struct Signal {
    samples: Samples,
    scale: f64,
    /// Number of samples by which it is read ahead; after the end, its last sample is used.
    ahead: usize,
}

impl Signal {
    fn new(samples: &Samples, scale: f64) -> Self {
        Self { samples: samples.clone(), scale, ahead: 0 }
    }

    /// Zero at all times.
    fn zero(samples: usize) -> Self {
        Self::new(&vec![0.0; samples].into(), 1.0)
    }

    /// Its value at a sample.
    pub(super) fn at(&self, k: usize) -> f64 {
        let sample = self.samples[(k + self.ahead).min(self.samples.len() - 1)];
        if self.scale == 1.0 { sample } else { self.scale * sample }
    }

    /// All values.
    pub(super) fn values(&self) -> Vec<f64> {
        (0..self.samples.len()).map(|k| self.at(k)).collect()
    }
}

/// The recorded signals of one joint that a replay needs. Joint side, SI.
#[derive(Debug, Clone)]
pub(super) struct Input {
    /// [rad or m] motor position.
    pub(super) position: Samples,
    /// [N·m or N] torque command to the drive from one sample to the next, before any correction.
    pub(super) forward: Signal,
    /// [N·m or N] torque to compare the simulated one with.
    pub(super) torque: Signal,
    /// Whether `torque` is a command at a sample, or a measurement.
    pub(super) commanded: bool,
    /// Whether `torque` is a magnitude: its sign was not measured.
    pub(super) magnitude: bool,
    /// Whether the joint was recorded with a torque that moves it.
    pub(super) recorded: bool,
}

/// What a recording says at a sample, as the simulated machine has to take it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Taken {
    /// [N·m or N] torque of the motor before any correction.
    pub(super) torque: f64,
    /// [N·m or N] what effects on the readings add to the recorded torque; the motor does not have it.
    pub(super) added: f64,
    /// [rad or m] what effects on the readings add to the recorded position.
    pub(super) misread: f64,
}

impl Input {
    /// Holds the joint on its recorded track: no torque moves it.
    pub(super) fn hold(&mut self) {
        (self.forward, self.recorded) = (Signal::zero(self.position.len()), false);
    }

    /// The sample `k`, while the simulated joint is in this state and reads so.
    pub(super) fn taken(&self, k: usize, torque_per_ampere: f64, state: &JointState, reading: &Reading) -> Taken {
        let added = torque_per_ampere * (reading.current - state.current);
        Taken { torque: self.forward.at(k) - added, added, misread: reading.position - state.motor_position }
    }
}

/// One input per joint of the model. A joint that was not recorded stands still at zero.
///
/// # Errors
/// No joint of the model was recorded; a joint lacks its position, or both torque and current; in open loop, only the
/// magnitude of the current is known.
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
    let zero = Signal::zero(samples);
    Input {
        position: zero.samples.clone(),
        forward: zero.clone(),
        torque: zero,
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
    let position = series.channels.get(&Channel::Position).ok_or_else(|| missing("position"))?.clone();
    let (commanded, magnitude, recorded) = (true, false, true);
    if let Some(torque) = series.channels.get(&Channel::Torque) {
        let torque = Signal::new(torque, 1.0);
        return Ok(Input { position, forward: torque.clone(), torque, commanded, magnitude, recorded });
    }
    let torque_of = |channel| Some(Signal::new(series.channels.get(&channel)?, joint.torque_per_ampere()));
    let magnitude = joint.current_sensor.is_some_and(|sensor| sensor.sensing == Sensing::Absolute);
    match (torque_of(Channel::CommandCurrent), torque_of(Channel::Current)) {
        (Some(forward), Some(torque)) => Ok(Input { position, forward, torque, commanded: false, magnitude, recorded }),
        (Some(torque), None) => {
            Ok(Input { position, forward: torque.clone(), torque, commanded, magnitude: false, recorded })
        }
        (None, Some(_)) if magnitude && control == Loop::Open => {
            let key = format!("{}.current", series.name);
            let expected = "a torque, a command or a current with its sign, which alone can drive a model in open loop";
            Err(Error::input(&session.source, Place::File, key, "a magnitude", expected))
        }
        (None, Some(torque)) => {
            // A reading shows the command of the sample before.
            let ahead = || Signal { ahead: 1, ..torque.clone() };
            let forward = if magnitude { Signal::zero(torque.samples.len()) } else { ahead() };
            Ok(Input { position, forward, torque, commanded: false, magnitude, recorded })
        }
        (None, None) => Err(missing("current")),
    }
}

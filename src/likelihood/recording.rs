//! A recording as the filter takes it: counts of the encoders, and the currents that drive the motors.
//!
//! The measured current has the first place, then a recorded torque, then a commanded current. Between two samples flows
//!
//! ```text
//!   i = w i_k + (1 − w) i_{k+1}         μ = T_i/T (1 − e^{−T/T_i}),  e = e^{−T/T_i},  w = μ − (1 − μ) e/(1 − e)
//! ```
//! the mean of a current that approaches the command of that interval with the loop's time constant `T_i`, since a reading at a sample shows the end of the
//! interval before; `w = 1` for a command, which is held. `T` is the interval between samples.

use super::count::Read;
use super::gears::LARGEST_IN_COUNTS;
use crate::dataset;
use crate::drive::{PowerStage, Sensing, Winding};
use crate::error::{Error, Place, Result};
use crate::robot::{JointModel, Model};
use crate::timeseries::{Channel, TimeSeries, root_mean_square, uninterrupted, white_noise};

/// Sharpness of an encoder's edges, as a share of a count.
const EDGE: f64 = 0.02;
/// Way that presses a gear to a flank, in gaps of the model and counts: a gap is known within some per cent, and a gear winds up by some counts.
const SETTLING_GAPS: f64 = 1.5;
const SETTLING_COUNTS: f64 = 4.0;

/// One joint of a recording.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Recorded {
    /// [A] what the current sensor read; without a motor, the torque.
    pub current: Vec<f64>,
    /// [A] standard deviation of a reading, noise and resolution.
    pub noise: f64,
    /// `w` [1].
    pub weight: f64,
    /// What the encoder read.
    pub position: Vec<f64>,
    /// `δ/2`, see [`Read`].
    half: f64,
    floor: f64,
    /// `R`, see [`Read`]: at least a count.
    range: f64,
    /// [rad or m] Way from the start of a window after which the link's place in its gap is known.
    settles: f64,
}

impl Recorded {
    /// The reading of the encoder at a sample.
    pub fn read(&self, sample: usize) -> Read {
        Read { middle: self.position[sample], half: self.half, floor: self.floor, range: self.range }
    }

    /// [rad/s or m/s] The fastest change from a sample to the next, by as much as a reading leaves open at most.
    pub fn fastest(&self, time: &[f64]) -> f64 {
        let changes = self.position.windows(2).zip(time.windows(2));
        let speed = |(position, time): (&[f64], &[f64])| {
            ((position[1] - position[0]).abs() + self.step()) / (time[1] - time[0])
        };
        changes.map(speed).fold(0.0, f64::max)
    }

    /// [rad or m] A count, or six deviations of an exact reading: about what one reading leaves open.
    pub fn step(&self) -> f64 {
        if self.half > 0.0 { 2.0 * self.half } else { 6.0 * self.floor }
    }
}

/// A recording, or a window of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Name of the session.
    pub name: String,
    /// [s] Sample times since the start of the session.
    pub time: Vec<f64>,
    pub(super) joints: Vec<Recorded>,
}

impl Recording {
    /// The longest uninterrupted part of a session; every joint of the model has to be recorded.
    ///
    /// # Errors
    /// A joint has no position, or neither a current with its sign nor a torque.
    pub fn new(model: &Model, series: &TimeSeries) -> Result<Self> {
        let parts = uninterrupted(&series.time);
        let longest = parts.into_iter().max_by_key(|part| part.len()).unwrap_or(0..0);
        let part = series.part(longest);
        let start = series.time.first().copied().unwrap_or(0.0);
        let joints = model.joints.iter().map(|joint| recorded(model, joint, &part)).collect::<Result<_>>()?;
        Ok(Self { name: part.name, time: part.time.iter().map(|time| time - start).collect(), joints })
    }

    /// The samples from one time [s] since the start of the session to another.
    #[must_use]
    pub fn window(&self, from: f64, to: f64) -> Self {
        let [first, last] = [from, to].map(|time| self.time.partition_point(|one| *one < time));
        let part = first..last.max(first);
        let cut = |joint: &Recorded| Recorded {
            current: joint.current[part.clone()].to_vec(),
            position: joint.position[part.clone()].to_vec(),
            ..joint.clone()
        };
        let joints = self.joints.iter().map(cut).collect();
        Self { name: self.name.clone(), time: self.time[part.clone()].to_vec(), joints }
    }

    /// The first sample of a joint that is scored: the burn-in [s] is over, and the joint has moved so far that its gear is pressed to a flank. Where it rests, friction holds
    /// its link anywhere in the gap, with any wind-up, and no reading tells.
    pub fn first_scored(&self, joint: usize, burn_in: f64) -> usize {
        let Some(start) = self.time.first() else { return 0 };
        let Recorded { position, settles, .. } = &self.joints[joint];
        let moved = position.iter().position(|place| (place - position[0]).abs() > *settles);
        self.time.partition_point(|time| *time < start + burn_in).max(moved.unwrap_or(position.len()))
    }

    /// Number of readings that are scored, of all joints together.
    pub fn readings(&self, burn_in: f64) -> usize {
        (0..self.joints.len()).map(|joint| self.len() - self.first_scored(joint, burn_in)).sum()
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }
}

fn recorded(model: &Model, joint: &JointModel, series: &TimeSeries) -> Result<Recorded> {
    let missing = |channel: &str, expected: &str| {
        let key = format!("{}.{channel}", joint.name);
        Error::input(&model.source, Place::File, key, "(missing)", expected.to_owned())
    };
    let found = series.joint(&joint.name).ok_or_else(|| missing("position", "a recorded joint"))?;
    let position = found.channels.get(&Channel::Position).ok_or_else(|| missing("position", "a recorded channel"))?;
    let step =
        if joint.encoder.is_some() { joint.encoder_step() } else { dataset::encoder_step(&[position]).unwrap_or(0.0) };
    let signed = joint.current_sensor.is_none_or(|sensor| sensor.sensing == Sensing::Signed);
    let interval = series.sample_interval();
    let measured = found.channels.get(&Channel::Current).filter(|_| signed);
    let (samples, scale, noise, weight) = if let Some(current) = measured {
        let noise = joint.current_sensor.map(|one| (one.noise.powi(2) + one.resolution.powi(2) / 12.0).sqrt());
        (current, 1.0, noise.unwrap_or_else(|| white_noise(current)), loop_weight(joint, interval))
    } else if let Some(torque) = found.channels.get(&Channel::Torque) {
        let scale = 1.0 / joint.torque_per_ampere();
        (torque, scale, scale * white_noise(torque), loop_weight(joint, interval))
    } else if let Some(command) = found.channels.get(&Channel::CommandCurrent) {
        (command, 1.0, 0.0, 1.0)
    } else {
        return Err(missing("current", "a current with its sign, a torque or a command"));
    };
    let current: Vec<f64> = samples.iter().map(|value| scale * value).collect();
    // Where nothing is said of the noise, a thousandth of the current.
    let floor = if step > 0.0 { EDGE * step } else { white_noise(position).max(1e-9) };
    let noise = noise.max(1e-3 * root_mean_square(&current));
    let gap = joint.backlash.map_or(LARGEST_IN_COUNTS * step, |gap| SETTLING_GAPS * gap);
    let settles = gap + SETTLING_COUNTS * step;
    let [least, most] = [f64::min, f64::max].map(|of| position.iter().copied().fold(position[0], of));
    let range = (most - least).max(step).max(floor);
    Ok(Recorded { current, noise, weight, position: position.to_vec(), half: 0.5 * step, floor, range, settles })
}

/// `w` of a measured current.
fn loop_weight(joint: &JointModel, interval: f64) -> f64 {
    let stage = PowerStage::new(joint.motor.as_ref(), &joint.amplifier, joint.torque_per_ampere());
    let Winding::Inductive { time_constant, .. } = stage.winding else { return 0.0 };
    let e = (-interval / time_constant).exp();
    let mu = time_constant / interval * (1.0 - e);
    mu - (1.0 - mu) * e / (1.0 - e)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A joint of counts of 1 mrad and a gap of 10 mrad, settled after 19, that rests, moves and rests again.
    #[test]
    fn analytic_a_joint_is_scored_from_where_its_gear_is_surely_pressed() {
        let position: Vec<f64> = (0..100).map(|k: i32| 1e-3 * f64::from((k - 20).clamp(0, 40))).collect();
        let joint = Recorded {
            current: vec![0.0; 100],
            noise: 0.01,
            weight: 0.0,
            position,
            half: 5e-4,
            floor: 2e-5,
            range: 0.04,
            settles: SETTLING_GAPS * 0.01 + SETTLING_COUNTS * 1e-3,
        };
        let time = (0..100).map(|k| 0.01 * f64::from(k)).collect();
        let recording = Recording { name: "made".to_owned(), time, joints: vec![joint] };
        assert_eq!(recording.first_scored(0, 0.1), 40);
        assert_eq!(recording.first_scored(0, 0.5), 50);
        assert_eq!(recording.readings(0.5), 50);
        // A window in which it rests has nothing to say of it.
        assert_eq!(recording.window(0.7, 0.9).readings(0.0), 0);
    }
}

//! What the identification reads of a joint in one session.

use crate::drive::Sensing;
use crate::error::{Error, Result};
use crate::robot::Model;
use crate::timeseries::{Channel, Clock, TimeSeries};

/// The signals of one joint in one session. Joint side, SI.
#[derive(Debug, Clone)]
pub struct Signals<'a> {
    /// [s]
    pub time: &'a [f64],
    /// The sample times.
    pub clock: Clock<'a>,
    /// [rad or m] encoder position.
    pub position: &'a [f64],
    /// [rad/s or m/s] as measured; `None` where it was not recorded.
    pub velocity: Option<&'a [f64]>,
    /// [rad/s or m/s] `None` where no reference was recorded.
    pub reference_velocity: Option<Vec<f64>>,
    /// `τ` [N·m or N] motor torque, `ratio K_t i`; its magnitude where `rectified`.
    pub torque: Vec<f64>,
    /// Whether the sign of the torque was lost in the current sensor.
    pub rectified: bool,
    /// [N·m or N] standard deviation of the torque's noise by the model file; 0 if the file gives none.
    pub torque_noise: f64,
    /// [rad or m] size of an encoder count; 0 for an exact encoder.
    pub count: f64,
}

impl<'a> Signals<'a> {
    /// The signals of a joint; `None` where the session lacks the joint, its position, or both current and torque.
    pub fn of(model: &Model, joint: usize, series: &'a TimeSeries) -> Option<Self> {
        let joint = &model.joints[joint];
        let recorded = series.joint(&joint.name)?;
        let position = recorded.get(Channel::Position)?;
        let gain = joint.torque_per_ampere();
        let (torque, from_current) = match (recorded.get(Channel::Current), recorded.get(Channel::Torque)) {
            // Without a torque constant the current has no scale, so a recorded torque is used instead.
            (Some(current), torque) if joint.motor.is_some() || torque.is_none() => {
                (current.iter().map(|i| gain * i).collect(), true)
            }
            (_, Some(torque)) => (torque.to_vec(), false),
            (_, None) => return None,
        };
        let sensor = joint.current_sensor.filter(|_| from_current);
        let clock = Clock::new(&series.time);
        let reference_velocity = recorded
            .get(Channel::ReferenceVelocity)
            .map(<[f64]>::to_vec)
            .or_else(|| recorded.get(Channel::ReferencePosition).map(|x| differences(x, &clock)));
        Some(Self {
            time: &series.time,
            clock,
            position,
            velocity: recorded.get(Channel::Velocity),
            reference_velocity,
            torque,
            rectified: sensor.is_some_and(|sensor| sensor.sensing == Sensing::Absolute),
            torque_noise: sensor.map_or(0.0, |sensor| gain * sensor.noise.hypot(sensor.resolution / 12f64.sqrt())),
            count: joint.encoder_step(),
        })
    }

    /// First sample from `from` on at which the position has just changed; `from` itself where the encoder is exact.
    pub fn edge_after(&self, from: usize) -> usize {
        if self.count == 0.0 {
            return from;
        }
        (from.max(1)..self.position.len()).find(|&k| self.position[k] != self.position[k - 1]).unwrap_or(from)
    }

    /// The error that says which channels a joint needs.
    pub fn missing(joint: &str) -> Error {
        Error::TooLittleData {
            quantity: "friction",
            joint: joint.to_owned(),
            found: 0,
            unit: "sessions with position and current (or torque)",
            needed: 1,
            advice: "record the motor's position and its current",
        }
    }
}

/// Derivative of a reference position, such that a ramp sampled in a text file stays constant: rounded at even times, else held until it
/// changes by more than the rounding of two times makes of it.
fn differences(x: &[f64], clock: &Clock) -> Vec<f64> {
    /// [1] Rounding of a derivative at even times, as a share of the largest.
    const GRAIN: f64 = 1e-4;
    /// [1] The same at uneven times: steps of 1 ms whose ends are rounded to 1 µs differ by 0.2 %. The slowest step of a staircase of
    /// twenty is 5 % of the largest.
    const HELD: f64 = 5e-3;
    let mut v: Vec<f64> =
        x.windows(2).enumerate().map(|(k, pair)| (pair[1] - pair[0]) / clock.elapsed(k, k + 1)).collect();
    v.push(v.last().copied().unwrap_or(0.0));
    let largest = v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if !clock.even {
        let mut held = v[0];
        for v in &mut v {
            if (*v - held).abs() > HELD * largest {
                held = *v;
            }
            *v = held;
        }
        return v;
    }
    let grain = GRAIN * largest;
    if grain > 0.0 {
        for v in &mut v {
            *v = (*v / grain).round() * grain;
        }
    }
    v
}

/// The signals of a joint in every session that has them.
///
/// # Errors
/// No session has them.
pub fn of_sessions<'a>(model: &Model, joint: usize, data: &'a [TimeSeries]) -> Result<Vec<(usize, Signals<'a>)>> {
    let found: Vec<_> = data
        .iter()
        .enumerate()
        .filter_map(|(session, series)| Signals::of(model, joint, series).map(|signals| (session, signals)))
        .collect();
    if found.is_empty() { Err(Signals::missing(&model.joints[joint].name)) } else { Ok(found) }
}

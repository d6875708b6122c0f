//! Readings of the current sensor before the first motion of a joint in a session, while its drive is idle.
//!
//! An offset of the sensor shows there already, and friction needs no current yet. A drive that holds a load may read any current.
//! The evidence is therefore that of a mixture, `0.9 N(ī; i0, σ²) + 0.1 U`, and is limited to a few nats.

use crate::effects::Motion;
use crate::timeseries::{Channel, TimeSeries};

/// Mean reading of one joint before its first motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standstill {
    /// [A] Mean.
    pub mean: f64,
    /// [A] Standard error of the mean.
    pub std_error: f64,
}

/// [A] Smallest standard error: drives are never completely idle.
const LEAST_ERROR: f64 = 0.02;
/// Relative error of an offset that is estimated from the motion.
const RELATIVE_ERROR: f64 = 0.1;
/// [s] Longest time that is read.
const LONGEST: f64 = 1.0;
/// Share of drives that hold a load at first.
const HOLDING: f64 = 0.1;

impl Standstill {
    /// Readings of every joint, all sessions combined; `None` where the joint moves from the start or has no signed current.
    pub fn of(motion: &Motion, sessions: &[&TimeSeries]) -> Vec<Option<Self>> {
        let readings = |joint: usize| {
            let name = &motion.model.joints[joint].name;
            let all: Vec<f64> =
                sessions.iter().flat_map(|session| before_motion(motion, joint, name, session)).collect();
            let sensor = motion.model.joints[joint].current_sensor;
            let noise = sensor.map_or(0.03, |sensor| sensor.noise.hypot(sensor.resolution));
            (!all.is_empty()).then(|| Self {
                mean: all.iter().sum::<f64>() / all.len() as f64,
                std_error: (noise / (all.len() as f64).sqrt()).max(LEAST_ERROR),
            })
        };
        (0..motion.joints.len()).map(readings).collect()
    }

    /// [nats] Evidence for a sensor that reads `offset` [A] at zero current, against zero; `span` [A] is the range of holding currents.
    pub fn evidence(&self, offset: f64, span: f64) -> f64 {
        let likelihood = |expected: f64| {
            let sigma = self.std_error.hypot(RELATIVE_ERROR * offset);
            let z = (self.mean - expected) / sigma;
            let normal = (-0.5 * z * z).exp() / (sigma * std::f64::consts::TAU.sqrt());
            (1.0 - HOLDING) * normal + HOLDING / (2.0 * span.max(sigma))
        };
        (likelihood(offset) / likelihood(0.0)).ln()
    }
}

fn before_motion(motion: &Motion, joint: usize, name: &str, session: &TimeSeries) -> Vec<f64> {
    let Some(series) = session.joint(name) else { return Vec::new() };
    let (Some(current), Some(position)) = (series.get(Channel::Current), series.get(Channel::Position)) else {
        return Vec::new();
    };
    let count = motion.model.joints[joint].encoder_step();
    let reference = series.get(Channel::ReferenceVelocity);
    let still = |index: &usize| {
        let asked = reference.is_some_and(|reference| reference[..=*index].iter().any(|v| v.abs() > 1e-4));
        let moved = (position[*index] - position[0]).abs() > 1.5 * count;
        let late = session.time[*index] - session.time[0] > LONGEST;
        !asked && !moved && !late
    };
    (0..current.len()).take_while(still).map(|index| current[index]).collect()
}

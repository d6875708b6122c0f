//! What the current sensor reads before a joint has moved for the first time in a session, while its drive has nothing to do.
//!
//! An offset of the sensor is there already; friction asks for nothing yet. A drive that holds a load reads anything:
//! so the evidence is that of a mixture, `0.9 N(ī; i0, σ²) + 0.1 U`, and stays within a few nats.

use crate::effects::Motion;
use crate::timeseries::{Channel, TimeSeries};

/// Mean reading of one joint before its first motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standstill {
    /// [A] mean.
    pub mean: f64,
    /// [A] its standard error.
    pub std_error: f64,
}

/// [A] Smallest standard error: drives are never quite at rest.
const LEAST_ERROR: f64 = 0.02;
/// Relative error of an offset that was estimated from the motion.
const RELATIVE_ERROR: f64 = 0.1;
/// Samples that are read at most: [s].
const LONGEST: f64 = 1.0;
/// Share of drives that hold something at first.
const HOLDING: f64 = 0.1;

impl Standstill {
    /// Readings of every joint in all sessions together; `None` where it moves from the start or has no signed current.
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

    /// [nats] for a sensor that reads `offset` [A] at no current, against one that reads zero; `span` [A] is what a drive may hold.
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

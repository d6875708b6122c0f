//! Dead channels: constant, frozen, or noise, while another channel of the same joint shows that they should change.
//!
//! Position: constant while the velocity channel moves the joint, in a whole session by a part of the joint's largest range, or from some sample
//! on by more than that range. Velocity: constant while the position changes. Current or torque: constant while the joint moves in both
//! directions, where friction alone changes the sign. The current of a joint that is switched off is zero in a part of a session while the
//! joint swings; so only whole sessions count, or a nonzero value that stays to the end. Noise: a current or torque that has only a few
//! values, or that differs from sample to sample without correlation, and does not depend on direction, speed and angle. With `R²` the share of its variance that these explain, noise has `R² ≈ p/N`
//! for `p` columns; Coulomb friction of one step of the sensor already has an `R²` of some tenths.

use nalgebra::{DMatrix, DVector};

use crate::linear::least_squares;
use crate::robot::Model;
use crate::timeseries::{Channel, JointSeries, TimeSeries};

/// Motion in both directions, relative to the joint's largest range, above which a constant torque counts as dead.
const WAY: f64 = 0.1;
/// [rad or m] Motion of the velocity channel above which a constant position counts as dead.
const LEAST: f64 = 0.1;
/// Least number of samples for which a channel is frozen.
const SAMPLES: usize = 50;

/// Most values that noise about a constant takes: four steps to either side.
const LEVELS: usize = 9;
/// Stands for more values than [`LEVELS`].
pub const MANY: usize = usize::MAX;
/// [1] Correlation of neighbouring samples up to which noise of many values is white: 4.5 standard errors for the least number of samples.
const WHITE: f64 = 0.2;
/// `R²` [1] below which motion explains nothing, far above what noise of hundreds of independent samples has by chance.
const EXPLAINED: f64 = 0.02;
/// Least number of samples for that.
const JUDGED: usize = 500;
/// Samples over which the direction of a motion is taken, less than any move lasts.
const SPAN: usize = 10;

/// A dead channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Dead {
    /// The joint's index in the model.
    pub joint: usize,
    /// The channel.
    pub channel: Channel,
    /// The session.
    pub session: String,
    /// The constant value, or the first.
    pub value: f64,
    /// Number of values that it has: 1 for a constant, [`MANY`] where they are not counted.
    pub levels: usize,
    /// [s] Time at which it starts.
    pub since: f64,
    /// [rad or m] Motion of the joint meanwhile.
    pub way: f64,
}

/// All dead channels.
pub fn found(model: &Model, sessions: &[&TimeSeries]) -> Vec<Dead> {
    let mut found = Vec::new();
    for (index, joint) in model.joints.iter().enumerate() {
        let series: Vec<(&TimeSeries, &JointSeries)> =
            sessions.iter().filter_map(|session| Some((*session, session.joint(&joint.name)?))).collect();
        let most = series.iter().filter_map(|(_, one)| one.get(Channel::Position)).map(range).fold(0.0, f64::max);
        for (session, one) in series {
            let dead = |(channel, since, way, levels): (Channel, usize, f64, usize)| {
                let values = one.get(channel)?;
                let (session_name, time) = (session.name.clone(), session.time[since] - session.time[0]);
                Some(Dead {
                    joint: index,
                    channel,
                    session: session_name,
                    value: values[since],
                    levels,
                    since: time,
                    way,
                })
            };
            found.extend(in_session(session, one, most).into_iter().filter_map(dead));
        }
    }
    found
}

/// Name of a channel in a recording.
pub const fn name(channel: Channel) -> &'static str {
    match channel {
        Channel::Position => "position",
        Channel::Velocity => "velocity",
        Channel::Torque | Channel::LinkTorque => "torque",
        _ => "current",
    }
}

/// Channel, first frozen sample, the motion meanwhile, and the number of values.
fn in_session(session: &TimeSeries, series: &JointSeries, most: f64) -> Vec<(Channel, usize, f64, usize)> {
    let mut dead = Vec::new();
    let Some(position) = series.get(Channel::Position) else { return dead };
    let end = position.len();
    if let Some(velocity) = series.get(Channel::Velocity) {
        let since = frozen_since(position);
        let path = path(&session.time[since..], &velocity[since..]);
        let way = range(&path);
        // A joint that is held also reads one value, and its velocity is noisy: a position that freezes during a session must miss a large motion.
        let least = if since == 0 { WAY * most } else { most };
        if end - since > SAMPLES && way > LEAST && way > least {
            dead.push((Channel::Position, since, way, 1));
        }
        let since = frozen_since(velocity);
        let way = if since < end { range(&position[since..]) } else { 0.0 };
        if end - since > SAMPLES && most > 0.0 && way > WAY * most {
            dead.push((Channel::Velocity, since, way, 1));
        }
    }
    for channel in [Channel::Current, Channel::Torque, Channel::LinkTorque] {
        let Some(values) = series.get(channel) else { continue };
        let frozen = frozen_since(values);
        let noise = noise_of(position, values);
        if noise.is_none() && (end - frozen <= SAMPLES || (frozen > 0 && values[frozen] == 0.0)) {
            continue;
        }
        let (since, levels) = noise.map_or((frozen, 1), |levels| (0, levels));
        let (up, down) = ways(&position[since..]);
        let way = up.min(down);
        if most > 0.0 && way > WAY * most {
            dead.push((channel, since, way, levels));
        }
    }
    dead
}

/// Number of values of a signal that is noise, whatever the motion; [`MANY`] where they are more than [`LEVELS`].
fn noise_of(position: &[f64], values: &[f64]) -> Option<usize> {
    let mut levels: Vec<f64> = Vec::new();
    for value in values {
        if !levels.contains(value) {
            levels.push(*value);
        }
        if levels.len() > LEVELS {
            break;
        }
    }
    if levels.len() < 2 || values.len() < JUDGED {
        return None;
    }
    let levels = if levels.len() > LEVELS { MANY } else { levels.len() };
    // Torque that other joints ask for does not depend on the joint's own motion either, but it lasts longer than a sample.
    if levels == MANY && correlation_of_neighbours(values).abs() > WHITE {
        return None;
    }
    let last = position.len() - 1;
    let moved = |k: usize| position[(k + SPAN).min(last)] - position[k.saturating_sub(SPAN)];
    let direction = |k: usize| if moved(k) == 0.0 { 0.0 } else { moved(k).signum() };
    let row = |k: usize| [1.0, direction(k), moved(k), position[k].sin(), position[k].cos()];
    let columns = DMatrix::from_fn(values.len(), 5, |k, column| row(k)[column]);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let signal = DVector::from_iterator(values.len(), values.iter().map(|value| value - mean));
    let (fit, _) = least_squares(&columns, &signal)?;
    let left = (&signal - columns * fit).norm_squared();
    (1.0 - left / signal.norm_squared() < EXPLAINED).then_some(levels)
}

/// Correlation of each sample with the next.
fn correlation_of_neighbours(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let product = |a: f64, b: f64| (a - mean) * (b - mean);
    let variance: f64 = values.iter().map(|x| product(*x, *x)).sum();
    values.windows(2).map(|pair| product(pair[0], pair[1])).sum::<f64>() / variance.max(1e-300)
}

/// Integral of a velocity without its mean: an offset is no motion.
fn path(time: &[f64], velocity: &[f64]) -> Vec<f64> {
    let mut path = vec![0.0; time.len()];
    for k in 1..time.len() {
        path[k] = path[k - 1] + 0.5 * (velocity[k] + velocity[k - 1]) * (time[k] - time[k - 1]);
    }
    let slope = path.last().copied().unwrap_or(0.0) / (time.len().max(2) - 1) as f64;
    path.iter().enumerate().map(|(k, x)| x - slope * k as f64).collect()
}

/// First of the samples at the end of a signal that have its last value.
fn frozen_since(values: &[f64]) -> usize {
    let last = values.last();
    values.len() - values.iter().rev().take_while(|value| Some(*value) == last).count()
}

fn range(values: &[f64]) -> f64 {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    if high > low { high - low } else { 0.0 }
}

/// Distances upwards and downwards.
fn ways(position: &[f64]) -> (f64, f64) {
    position.windows(2).fold((0.0, 0.0), |(up, down), pair| {
        let step = pair[1] - pair[0];
        (up + step.max(0.0), down - step.min(0.0))
    })
}

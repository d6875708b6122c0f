//! Steps of the position against the model's encoder: one count is `2π / (counts_per_turn · gear_ratio)` at the joint.
//!
//! A recorded encoder moves by whole counts, so the data give the size of a count with an error well below one percent. The gear ratio of
//! another stage, angles of the motor, or degrees change it by exactly that factor. A delay or a resampling interpolates between two
//! samples and gives
//! parts of counts; repeated readings then still differ by whole counts. Positions that were rounded to a decimal place or filtered have no such
//! steps, or steps of a round size, and are not judged.

use std::f64::consts::PI;

use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};
use crate::units::DEG;

/// Largest number of counts in a step that is used; beyond it the error of one count adds up.
const MOST_COUNTS: f64 = 6.0;
/// Largest deviation of a step from a whole number of counts, in counts.
const OFF: f64 = 0.12;
/// Least share of the steps that are whole counts.
const WHOLE: f64 = 0.98;
/// Least number of steps.
const FEWEST: usize = 200;
/// Least number of steps between repeated readings to show that smaller steps are parts of counts; the probability by chance is below 2⁻²⁰.
const FEWEST_LEVELS: usize = 20;
/// Relative difference up to which two sizes count as equal.
pub const SAME: f64 = 0.02;

/// Size of a count in the data relative to the model's; `None` where the data show no counts or the model has no encoder.
pub fn count_ratio(model: &Model, joint: usize, sessions: &[&TimeSeries]) -> Option<f64> {
    let expected = model.joints[joint].encoder_step();
    if expected <= 0.0 {
        return None;
    }
    let name = &model.joints[joint].name;
    let mut steps: Vec<f64> = Vec::new();
    let mut levels: Vec<f64> = Vec::new();
    for session in sessions {
        let position = session.joint(name)?.get(Channel::Position)?;
        // Differences in the last digits are rounding, not steps.
        let digits = 1e-12 * position.iter().fold(0.0_f64, |most, q| most.max(q.abs()));
        steps.extend(position.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > digits));
        let repeated: Vec<f64> =
            position.windows(2).filter(|pair| (pair[1] - pair[0]).abs() <= digits).map(|pair| pair[1]).collect();
        levels.extend(repeated.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > digits));
    }
    let smallest = steps.iter().copied().fold(f64::INFINITY, f64::min);
    steps.retain(|step| *step < (MOST_COUNTS + 0.5) * smallest);
    if steps.len() < FEWEST || is_round(smallest) {
        return None;
    }
    let mut count = smallest;
    for _ in 0..3 {
        let (sum, squares) = steps.iter().fold((0.0, 0.0), |(sum, squares), step| {
            let whole = (step / count).round();
            (sum + whole * step, squares + whole * whole)
        });
        count = sum / squares;
    }
    levels.retain(|step| *step < (MOST_COUNTS + 0.5) * expected);
    let parts = count < (1.0 - SAME) * expected && levels.len() >= FEWEST_LEVELS && are_whole(&levels, expected);
    (are_whole(&steps, count) && !parts && !is_round(count)).then_some(count / expected)
}

/// Whether steps are whole counts.
fn are_whole(steps: &[f64], count: f64) -> bool {
    let off = |step: &f64| (step / count - (step / count).round()).abs();
    let whole = steps.iter().filter(|step| off(step) < OFF).count();
    whole as f64 >= WHOLE * steps.len() as f64
}

/// Whether a step is 1, 2 or 5 times a power of ten in radians or degrees, or a turn over a power of two: such steps come from the file format.
fn is_round(step: f64) -> bool {
    let decimal = |step: f64| {
        let mantissa = step / 10.0_f64.powf(step.log10().floor());
        [1.0, 2.0, 2.5, 5.0, 10.0].iter().any(|round| (mantissa / round - 1.0).abs() < SAME)
    };
    let bits = (2.0 * PI / step).log2();
    decimal(step) || decimal(step / DEG) || (bits - bits.round()).abs() < 0.01
}

//! Quantities on which a residual may depend: the value of each axis in each row, and the bins for the mean residual.

use crate::diagnose::rows::reversals::{AFTER_REVERSAL, BEFORE_REVERSAL, since_reversal};
use std::f64::consts::TAU;

use crate::diagnose::fit::problem::Problem;
use crate::diagnose::result::Axis;

/// Bins of an axis.
const BINS: usize = 40;
/// Part of the rows that may lie beyond either end of an axis.
const OUTSIDE: f64 = 0.005;
/// [s] Shortest bin of time: a drift lasts over many strokes, and a stroke is not a drift.
const TIME_BIN: f64 = 20.0;

/// Rows of one joint in bins of one axis.
pub struct Binned {
    /// The rows.
    pub rows: Vec<usize>,
    /// Bin of each of them.
    pub bin: Vec<usize>,
    /// Centre of each bin.
    pub centre: Vec<f64>,
}

/// The rows in which an axis is evaluated: the rigid zone; for the time since a reversal, all rows in motion.
fn judged(problem: &Problem, joint: usize, axis: Axis) -> Vec<usize> {
    let judged = |row: &usize| match axis {
        Axis::ReversalPhase => problem.motion.joints[joint].direction[*row] != 0.0,
        _ => problem.judged[joint][*row],
    };
    (0..problem.motion.rows()).filter(judged).collect()
}

/// Assigns the rows of a joint to the bins of an axis.
pub fn binned(problem: &Problem, joint: usize, axis: Axis) -> Binned {
    let value = values(problem, joint, axis);
    let rows: Vec<usize> = judged(problem, joint, axis).into_iter().filter(|row| value[*row].is_finite()).collect();
    // A few extreme rows would make all bins wide: they go into the bins at the ends.
    let ends = |share: f64| {
        let mut sorted: Vec<f64> = rows.iter().map(|row| value[*row]).collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().saturating_sub(1) as f64;
        [share, 1.0 - share].map(|share| sorted.get((last * share) as usize).copied().unwrap_or(0.0))
    };
    let ([low, high], count) = match axis {
        Axis::Constant => ([-1.0, 1.0], 1),
        Axis::Direction => ([-2.0, 2.0], 2),
        Axis::MotorAngle => ([0.0, TAU], BINS),
        Axis::ReversalPhase => ([-BEFORE_REVERSAL, AFTER_REVERSAL], BINS),
        Axis::Time => {
            let [low, high] = ends(0.0);
            ([low, high], ((high - low) / TIME_BIN).clamp(1.0, BINS as f64) as usize)
        }
        _ => (ends(OUTSIDE), BINS),
    };
    let width = ((high - low) / count as f64).max(f64::MIN_POSITIVE);
    let bin = rows.iter().map(|row| (((value[*row] - low) / width).max(0.0) as usize).min(count - 1)).collect();
    Binned { rows, bin, centre: (0..count).map(|bin| low + (bin as f64 + 0.5) * width).collect() }
}

/// Value of an axis in each row; NaN where it has no value.
fn values(problem: &Problem, joint: usize, axis: Axis) -> Vec<f64> {
    let motion = &problem.motion;
    let (m, model) = (&motion.joints[joint], &motion.model.joints[joint]);
    match axis {
        Axis::Constant | Axis::Frequency => vec![0.0; motion.rows()],
        Axis::Time => motion.time.clone(),
        Axis::Velocity => m.v.clone(),
        Axis::Position => m.q.clone(),
        Axis::Acceleration => m.a.clone(),
        Axis::MotorAngle => m.q.iter().map(|q| (model.gear_ratio * q).rem_euclid(TAU)).collect(),
        Axis::Load => m.link_torque.clone(),
        Axis::Direction => m.direction.iter().map(|d| d.signum()).collect(),
        Axis::ReversalPhase => since_reversal(motion, joint),
    }
}

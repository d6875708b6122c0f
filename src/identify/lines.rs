//! The two lines of equations 7 to 9 by the linear least squares of equations 12 to 14.
//!
//! The points of a direction, sorted by speed, are split in two; each part has its line. Of all splits whose lines meet
//! (equation 8) between the parts, so that every point obeys the line it was given to, the one with the smallest sum of squares is taken;
//! where no split is consistent in this way, the smallest sum of squares alone decides.

use nalgebra::{DMatrix, DVector};

use super::least_squares;
use crate::gearhead::Lines;

/// A point of the characteristic in one direction.
#[derive(Debug, Clone, Copy)]
pub struct SpeedPoint {
    /// `|q̇|` [rad/s or m/s]
    pub speed: f64,
    /// Friction opposing the motion [N·m or N].
    pub magnitude: f64,
    /// Its standard error [N·m or N].
    pub std_error: f64,
}

/// Points that a line needs.
const FEWEST: usize = 2;

/// Two lines through the points of one direction; `None` with fewer than four points or none that fall in speed.
pub fn fit(points: &[SpeedPoint]) -> Option<Lines> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.speed.total_cmp(&b.speed));
    let splits = FEWEST..=sorted.len().checked_sub(FEWEST)?;
    let mut best: Option<(bool, f64, Lines)> = None;
    for split in splits {
        let (low, high) = sorted.split_at(split);
        let (Some((a1, b1, sum1)), Some((a2, b2, sum2))) = (line(low), line(high)) else { continue };
        let lines = Lines { a1, b1, a2, b2 };
        let meet = lines.switch_velocity();
        let consistent = low[low.len() - 1].speed <= meet && meet <= high[0].speed;
        let sum = sum1 + sum2;
        let better = best.as_ref().is_none_or(|(other, least, _)| match (consistent, *other) {
            (true, false) => true,
            (false, true) => false,
            _ => sum < *least,
        });
        if b2 > b1 && meet > 0.0 && better {
            best = Some((consistent, sum, lines));
        }
    }
    best.map(|(_, _, lines)| lines)
}

/// Weighted straight line: intercept, slope, sum of squares.
fn line(points: &[SpeedPoint]) -> Option<(f64, f64, f64)> {
    let x =
        DMatrix::from_fn(points.len(), 2, |i, j| (if j == 0 { 1.0 } else { points[i].speed }) / points[i].std_error);
    let y = DVector::from_fn(points.len(), |i, _| points[i].magnitude / points[i].std_error);
    let fit = least_squares::linear(&x, &y)?;
    Some((fit.parameters[0], fit.parameters[1], fit.chi_squared))
}

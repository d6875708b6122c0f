//! The two lines of equations 7 to 9 by the linear least squares of equations 12 to 14.
//!
//! The points of a direction, sorted by speed, are split in two; each part has its line. Splits whose lines meet (equation 8) far from
//! the gap between the parts are refused: a point must obey the line it was given to. Of the others the smallest sum of squares wins.

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

/// Splits that are handed on, best first: the law's own fit decides between them.
const CANDIDATES: usize = 3;

/// Two lines through the points of one direction, best split first; none with fewer than four points or where nothing falls in speed.
pub fn fit(points: &[SpeedPoint]) -> Vec<Lines> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.speed.total_cmp(&b.speed));
    let mut found: Vec<(f64, Lines)> = Vec::new();
    for split in FEWEST..=sorted.len().saturating_sub(FEWEST) {
        let (low, high) = sorted.split_at(split);
        let (Some((a1, b1, sum1)), Some((a2, b2, sum2))) = (line(low), line(high)) else { continue };
        let lines = Lines { a1, b1, a2, b2 };
        let meet = lines.switch_velocity();
        // The lines meet near the gap between both parts: no point is far on the other line's side.
        let gap = high[0].speed - low[low.len() - 1].speed;
        let near = low[low.len() - 1].speed - gap..=high[0].speed + gap;
        if a1 > 0.0 && b2 > b1 && near.contains(&meet) {
            found.push((sum1 + sum2, lines));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().take(CANDIDATES).map(|(_, lines)| lines).collect()
}

/// A start for points that nowhere fall with speed: one line through all of them, and a hint of a fall at its low end.
pub fn without_fall(points: &[SpeedPoint]) -> Option<Lines> {
    let (a2, b2, _) = line(points)?;
    let fastest = points.iter().fold(0.0_f64, |m, point| m.max(point.speed));
    let fall = 0.05 * a2.abs();
    Some(Lines { a1: a2 + fall, b1: b2 - 10.0 * fall / fastest, a2, b2 })
}

/// Weighted straight line: intercept, slope, sum of squares.
fn line(points: &[SpeedPoint]) -> Option<(f64, f64, f64)> {
    let x =
        DMatrix::from_fn(points.len(), 2, |i, j| (if j == 0 { 1.0 } else { points[i].speed }) / points[i].std_error);
    let y = DVector::from_fn(points.len(), |i, _| points[i].magnitude / points[i].std_error);
    let fit = least_squares::linear(&x, &y)?;
    Some((fit.parameters[0], fit.parameters[1], fit.chi_squared))
}

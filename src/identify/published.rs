//! The paper's own estimators, as published: plain least squares on window averages, and equation 15 on the last ten steps.
//!
//! A measurement point is the average of measured velocity and measured current in a steady window. All points have the same weight:
//!
//! ```text
//!   s ⟨ratio K_t |i|⟩ − G = s (a_j + b_j |q̇|) + C_ii q̇²        s = sgn q̇                       equations 11 to 13
//!   min Σ (left − right)²                                        over a1±, b1±, a2±, b2±, C_ii     equation 14
//! ```
//! A signed current is averaged with its sign, `⟨ratio K_t i⟩`. `j` = 1 "if the friction decreases with velocity, otherwise j = 2". Points
//! that scatter rise and fall in turn, so this is read as one speed in each direction that divides the points: the one with the least
//! sum of squares. `C_ii` has no index `j`, so it is one unknown for all four lines. Coefficients of the negative direction are
//! magnitudes against speed, as everywhere in this program.
//!
//! Left out, because the paper leaves it out: acceleration that remains in a window, the lag of the velocity channel, the non-linearity
//! of friction under a velocity that fluctuates, errors that differ from point to point.
//! Reference: L. Márton, B. Lantos (2009), sections III-A, III-B and IV.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::backlash::{self, EstimatorResult};
use super::law::{CENTRIFUGAL, COUNT, PER_DIRECTION};
use super::least_squares::{self, Fit};
use super::quantity::Quantity;
use super::result::{LinesEstimate, PerDirection};
use super::rigid_body::RigidBody;
use super::signals::Signals;
use super::statistics::mean;
use super::summary;
use super::windows::Window;
use crate::gearhead::Direction;
use crate::units::JointKind;

/// Points that determine a line.
const FEWEST: usize = 2;
/// Divisions that are tried in a direction, at most; a staircase has fewer speeds.
const DIVISIONS: usize = 64;
/// Rounds over both directions: they share only `C_ii`, so the second rarely changes anything.
const ROUNDS: usize = 4;

/// What the published estimators make of the recordings of a joint.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct PublishedEstimates {
    /// Equations 12 to 14; absent where a direction has fewer than two points for each line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<PublishedFriction>,
    /// Equation 15, literally: raw current, first local minimum; the last ten steps. Absent where the gap was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash: Option<EstimatorResult>,
    /// The same with the filter that noisy current needs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash_filtered: Option<EstimatorResult>,
}

/// The two lines of each direction and `C_ii`, from one plain least-squares fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PublishedFriction {
    /// Equations 7 to 9. Standard errors follow from the residuals alone.
    pub lines: PerDirection<LinesEstimate>,
    /// `C_ii` [N·m·s²/rad² or N·s²/m²].
    pub centrifugal: Quantity,
}

/// A measurement point of the paper. Joint side, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AveragePoint {
    /// `⟨q̇⟩` [rad/s or m/s] average of the measured velocity.
    pub velocity: f64,
    /// [N·m or N] average motor torque less gravity, with its sign.
    pub friction: f64,
}

impl AveragePoint {
    /// The point of a window; `signals` as measured, before any sign is recovered. Without a velocity channel, the velocity is the
    /// distance over the time.
    pub(super) fn of(signals: &Signals, rigid: &RigidBody, window: Window) -> Self {
        let Window { start, end } = window;
        let distance = signals.position[end] - signals.position[start];
        let slope = distance / (signals.time[end] - signals.time[start]);
        let velocity = signals.velocity.map_or(slope, |v| mean(&v[start..end]));
        let measured = mean(&signals.torque[start..end]);
        let torque = if signals.rectified { measured.copysign(distance) } else { measured };
        Self { velocity, friction: torque - rigid.gravity(window) }
    }

    fn direction(&self) -> Direction {
        Direction::of(self.velocity)
    }
}

/// Equations 12 to 14; `None` where a direction has fewer than two points for each line.
pub fn friction(kind: JointKind, points: &[AveragePoint]) -> Option<PublishedFriction> {
    let candidates = [Direction::Positive, Direction::Negative].map(|direction| divisions(points, direction));
    let mut split = [*candidates[0].first()?, *candidates[1].first()?];
    let mut best = fit(points, split);
    for _ in 0..ROUNDS {
        let before = split;
        for (k, speeds) in candidates.iter().enumerate() {
            for &speed in speeds {
                let mut other = split;
                other[k] = speed;
                let found = fit(points, other);
                let squares = |fit: &Option<Fit>| fit.as_ref().map_or(f64::INFINITY, |fit| fit.chi_squared);
                if squares(&found) < squares(&best) {
                    (best, split) = (found, other);
                }
            }
        }
        if split == before {
            break;
        }
    }
    let fit = best?;
    let errors = fit.scattered();
    let (lines, centrifugal) = (summary::lines_of(kind, &fit, &errors), summary::centrifugal_of(kind, &fit, &errors));
    Some(PublishedFriction { lines, centrifugal })
}

/// Speeds that leave at least two points for each line of a direction, slower ones and the others.
fn divisions(points: &[AveragePoint], direction: Direction) -> Vec<f64> {
    let side = points.iter().filter(|point| point.direction() == direction);
    let mut speeds: Vec<f64> = side.map(|point| point.velocity.abs()).collect();
    speeds.sort_by(f64::total_cmp);
    let end = (speeds.len() + 1).saturating_sub(FEWEST);
    let inner = speeds.get(FEWEST..end).unwrap_or_default();
    inner.iter().step_by(inner.len().div_ceil(DIVISIONS).max(1)).copied().collect()
}

/// The least-squares fit whose second lines begin at these speeds; `None` where the points do not determine it.
fn fit(points: &[AveragePoint], [positive, negative]: [f64; 2]) -> Option<Fit> {
    let mut x = DMatrix::zeros(points.len(), COUNT);
    for (row, point) in points.iter().enumerate() {
        let direction = point.direction();
        let (of_direction, from) =
            if direction == Direction::Positive { (0, positive) } else { (PER_DIRECTION, negative) };
        let at = of_direction + if point.velocity.abs() < from { 0 } else { PER_DIRECTION / 2 };
        x[(row, at)] = direction.sign();
        x[(row, at + 1)] = point.velocity;
        x[(row, CENTRIFUGAL)] = point.velocity * point.velocity;
    }
    let y = DVector::from_iterator(points.len(), points.iter().map(|point| point.friction));
    least_squares::linear(&x, &y)
}

/// All published estimates; `sessions`: the signals of the sessions that move the joint, for the gap.
pub(super) fn estimates(kind: JointKind, points: &[AveragePoint], sessions: Vec<Signals>) -> PublishedEstimates {
    let gaps = backlash::published(kind.position_unit(), sessions);
    let (backlash, backlash_filtered) = gaps.map(|[literal, filtered]| (literal, filtered)).unzip();
    PublishedEstimates { friction: friction(kind, points), backlash, backlash_filtered }
}

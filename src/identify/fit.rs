//! A friction law fitted to friction that was averaged over stretches of motion.
//!
//! Both laws are linear in three coefficients once one velocity is given (variable projection, G. Golub, V. Pereyra 1973):
//!
//! ```text
//!   equation 6   F = F_C + (F_S − F_C) e^{−v/v_S} + F_V v             given v_S
//!   equation 9   F = a1 + b1 v + (b2 − b1) max(0, v − v_sw)           given v_sw, equation 8
//! ```
//! So linear least squares, equations 12 to 14, at every velocity of a scan find a good start, and a few non-linear steps with all
//! coefficients find the minimum.

use nalgebra::{DMatrix, DVector};

use super::law::{self, CENTRIFUGAL, PER_DIRECTION};
use super::least_squares::{self, Fit, Search, levenberg_marquardt};
use super::points::Point;
use super::result::LawKind;
use crate::gearhead::{Direction, Lines};

/// A law with its coefficients and their covariance.
#[derive(Debug, Clone)]
pub struct LawFit {
    /// Which law.
    pub kind: LawKind,
    /// The coefficients in the order of [`law`].
    pub fit: Fit,
}

/// What a law is fitted to: friction averaged over a motion in one direction.
#[derive(Debug, Clone)]
pub struct Observation {
    /// Direction of the motion.
    pub direction: Direction,
    /// Shares of the time and velocities [rad/s or m/s]. If the shares sum to less than one, the joint stuck in the remaining time.
    pub velocities: Vec<(f64, f64)>,
    /// [N·m or N] friction with its sign, and the centrifugal term.
    pub friction: f64,
    /// [N·m or N] its standard error.
    pub std_error: f64,
}

impl Observation {
    /// A measurement point: its velocity represents the motion.
    pub fn of(point: &Point) -> Self {
        Self {
            direction: point.direction(),
            velocities: vec![(1.0, point.velocity)],
            friction: point.friction,
            std_error: point.std_error,
        }
    }

    /// Average over the motion.
    pub fn average(&self, value: impl Fn(f64) -> f64) -> f64 {
        self.velocities.iter().map(|(share, velocity)| share * value(*velocity)).sum()
    }
}

/// Velocities of the scan.
const SCAN: usize = 40;
/// Part of the slowest speed at which the scan of `v_S` begins: the data do not show a fall of friction below it.
const BELOW_SLOWEST: f64 = 0.5;
/// Largest plausible friction at rest, as a multiple of the largest friction that was measured.
const RISE: f64 = 2.0;
/// Fall with speed, as a part of the friction, that a law starts with if the data show none.
const SLIGHT: f64 = 0.05;

/// Best fit of a law; `C_ii` is zero unless it is free.
pub fn to(kind: LawKind, observations: &[Observation], free_centrifugal: bool) -> Option<LawFit> {
    let fastest = speeds(observations).fold(0.0, f64::max);
    let mut start = vec![0.0; law::COUNT];
    for (k, direction) in [Direction::Positive, Direction::Negative].into_iter().enumerate() {
        let side: Vec<_> = observations.iter().filter(|one| one.direction == direction).cloned().collect();
        let own = scan(kind, &side).or_else(|| without_fall(kind, &side))?;
        start[k * PER_DIRECTION..(k + 1) * PER_DIRECTION].copy_from_slice(&own);
    }
    let mut step = law::steps(kind, &start, fastest);
    if !free_centrifugal {
        step[CENTRIFUGAL] = 0.0;
    }
    let highest = highest(observations);
    let residuals = |theta: &[f64]| {
        let law = law::of(kind, theta)
            .filter(|_| theta[..CENTRIFUGAL].chunks(PER_DIRECTION).all(|own| believed(kind, own, highest)))?;
        let force = |v: f64| law.kinetic(v) + theta[CENTRIFUGAL] * v * v;
        Some(observations.iter().map(|one| (one.average(force) - one.friction) / one.std_error).collect())
    };
    let search = Search { step: &step, part: 1e-3, iterations: 60, tolerance: 1e-9 };
    levenberg_marquardt(&start, search, residuals).map(|fit| LawFit { kind, fit })
}

/// Mean speed of every motion.
fn speeds(observations: &[Observation]) -> impl Iterator<Item = f64> {
    observations.iter().map(|one| one.average(f64::abs))
}

/// The largest friction that was measured.
fn highest(observations: &[Observation]) -> f64 {
    observations.iter().map(|one| one.friction.abs()).fold(0.0, f64::max)
}

/// Whether the friction at rest of one direction's coefficients is plausible: not far above what was measured.
fn believed(kind: LawKind, own: &[f64], highest: f64) -> bool {
    let at_rest = match kind {
        LawKind::Exponential => own[1],
        LawKind::TwoLines => own[0],
    };
    at_rest <= RISE * highest
}

/// The coefficients of one direction with the smallest sum of squares over the velocities of a scan; `None` if none makes a valid law.
fn scan(kind: LawKind, side: &[Observation]) -> Option<[f64; PER_DIRECTION]> {
    let mut sorted: Vec<f64> = speeds(side).collect();
    sorted.sort_by(f64::total_cmp);
    let [slowest, second, .., before_last, fastest] = sorted[..] else { return None };
    let (low, high) = match kind {
        LawKind::Exponential => (BELOW_SLOWEST * slowest, fastest),
        // Either line needs two points.
        LawKind::TwoLines => (second, before_last),
    };
    let highest = highest(side);
    let mut best: Option<(f64, [f64; PER_DIRECTION])> = None;
    for k in 0..SCAN {
        let given = low * (high / low).powf(k as f64 / (SCAN - 1) as f64);
        let shape = |v: f64| match kind {
            LawKind::Exponential => (-v / given).exp(),
            LawKind::TwoLines => (v - given).max(0.0),
        };
        let Some(fit) = linear(side, &[&|_| 1.0, &shape, &|v| v]) else { continue };
        let [constant, shaped, slope] = fit.parameters[..] else { continue };
        let own = match kind {
            LawKind::Exponential => [constant, constant + shaped, given, slope],
            LawKind::TwoLines => [constant, slope, constant - shaped * given, slope + shaped],
        };
        let allowed = believed(kind, &own, highest) && law::of(kind, &[own, own].concat()).is_some();
        if allowed && best.is_none_or(|(least, _)| fit.chi_squared < least) {
            best = Some((fit.chi_squared, own));
        }
    }
    best.map(|(_, own)| own)
}

/// A start for friction that does not fall with speed: one line, with a slight fall at its low end.
fn without_fall(kind: LawKind, side: &[Observation]) -> Option<[f64; PER_DIRECTION]> {
    let fastest = speeds(side).fold(0.0, f64::max);
    let fit = linear(side, &[&|_| 1.0, &|v| v])?;
    let [level, slope] = fit.parameters[..] else { return None };
    let fall = SLIGHT * level.abs();
    let lines = Lines { a1: level + fall, b1: slope - 10.0 * fall / fastest, a2: level, b2: slope };
    Some(match kind {
        LawKind::TwoLines => [lines.a1, lines.b1, lines.a2, lines.b2],
        LawKind::Exponential => [lines.a2, lines.a1, lines.switch_velocity(), lines.b2],
    })
}

/// Equations 12 to 14: magnitudes of friction against functions of the speed, averaged over the motion.
fn linear(side: &[Observation], columns: &[&dyn Fn(f64) -> f64]) -> Option<Fit> {
    let x = DMatrix::from_fn(side.len(), columns.len(), |i, j| {
        side[i].average(|v| columns[j](v.abs())) / side[i].std_error
    });
    let y = DVector::from_fn(side.len(), |i, _| side[i].direction.sign() * side[i].friction / side[i].std_error);
    least_squares::linear(&x, &y)
}

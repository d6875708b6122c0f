//! Whether a gap varies with the angle: on flank ± the motor is ahead of the link by half of the local gap.
//!
//! ```text
//!   q − l = … + ½ side (b + a cos(nq + φ))        odds for a varying gap, over N orders:  L_n/L_0/N
//! ```
//! `L` is the robust likelihood of the whole fit for the number of independent rows. Links that float sometimes cause most of the
//! squared error, and plain least squares finds another order. The order is scanned, then refined.
//! An error of transmission or of an encoder has the same sign on both flanks, so it is no varying gap:
//! `cos nq`, `sin nq` with the same sign on both flanks compete, at their own best order.
//! Left out: joints without reversals; machines with estimated masses, where the flank in contact is unknown.

use rayon::prelude::*;

use super::SURELY;
use super::difference::{Difference, difference};
use super::fit::{AxisFit, Lag, fit, trained};
use super::solved::{Solved, solve};
use super::wave::{Wave, wave};
use crate::diagnose::fit::golden::golden_section;
use crate::diagnose::fit::problem::{Problem, independence};
use crate::diagnose::options::Rules;
use crate::diagnose::residuals::gains;
use crate::replay::Gain;
use crate::timeseries::{Estimate, TimeSeries};
use crate::units::JointKind;

/// [rad] Least phase of a wave over the motion: with less, it is a slope or a curve of any order.
const LEAST_PHASE: f64 = 1.5;
/// [1/turn] Largest order that is tried: the gap is crossed only at the places where the joint reverses.
const MOST: f64 = 30.0;
/// [rad] Difference of the phase at the ends of the motion between one order and the next.
const STEP: f64 = 0.25;

/// A varying gap.
#[derive(Debug, Clone)]
pub struct Varying {
    /// The whole fit with it.
    pub fit: AxisFit,
    /// Amplitude, order, phase.
    pub wave: Wave,
    /// Logarithm of the odds for a varying gap.
    pub log_odds: f64,
    /// Gain over a constant gap on held-out data.
    pub gain: Gain,
}

/// The variation of a joint's gap, if it varies; `constant` is the fit of a constant gap at the same `lag`.
pub fn varying(
    problem: &Problem,
    sessions: &[&TimeSeries],
    constant: &AxisFit,
    lag: f64,
    rules: &Rules,
) -> Option<Varying> {
    constant.gap?;
    let joint = constant.joint;
    let rows = trained(problem, sessions, joint, lag)?;
    if rows.motor_side || problem.motion.model.joints[joint].kind != JointKind::Revolute {
        return None;
    }
    let orders = orders(&rows)?;
    let side = rows.side(0.0);
    let base = [constant.columns(&rows), rows.mounting(problem)].concat();
    let beside = |columns: [Vec<f64>; 2]| solve(&rows.ahead, &[base.as_slice(), &columns].concat());
    let uneven = |order: f64| likelihood(beside(wave(&rows, &side, order)));
    let (at, best) = highest(&orders, uneven)?;
    let before = solve(&rows.ahead, &base)?;
    let independent = independence(&before.residual, &before.weights, &rows.rows, rows.rows.len());
    let log_odds = independent * (best - before.log_likelihood) - (orders.len() as f64).ln();
    if log_odds <= rules.nats {
        return None;
    }
    let both = vec![1.0; rows.rows.len()];
    let (_, rival) = highest(&orders, |order| likelihood(beside(wave(&rows, &both, order))))?;
    let step = orders[1] - orders[0];
    let fine = |low: f64, high: f64| high - low < 1e-3 * step;
    let (low, high) = golden_section([(at - step).max(0.5 * at), at + step], fine, uneven);
    let fit = fit(problem, sessions, joint, Lag::Known(lag), Some(0.5 * (low + high)))?;
    let (wave, gap) = (fit.wave?, fit.gap?);
    let held_out = difference(problem, sessions, joint, lag)?.filtered(|row| problem.held_out[row]);
    let [without, with] = [constant, &fit].map(|fit| fit.residual(problem, &held_out));
    let (without, with) = (without?, with?);
    // A gap is never negative.
    let possible = wave.amplitude.value - gap.value < SURELY * wave.amplitude.std_error;
    let sure = wave.amplitude.value > SURELY * wave.amplitude.std_error;
    (possible && sure && rival < best).then(|| Varying {
        wave: Wave { amplitude: Estimate { value: wave.amplitude.value.min(gap.value), ..wave.amplitude }, ..wave },
        log_odds,
        gain: gains::of_rows(&problem.motion, &held_out.rows, [&without, &with]),
        fit,
    })
}

/// Orders [1/turn] that the rows can show; at least two.
fn orders(rows: &Difference) -> Option<Vec<f64>> {
    let (low, high) =
        rows.q.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| (low.min(*q), high.max(*q)));
    let range = high - low;
    let (least, step) = (LEAST_PHASE / range, STEP / range);
    let count = ((MOST - least) / step).ceil();
    (range > 0.0 && count >= 2.0).then(|| (0..count as usize).map(|index| least + step * index as f64).collect())
}

fn likelihood(solved: Option<Solved>) -> f64 {
    solved.map_or(f64::NEG_INFINITY, |solved| solved.log_likelihood)
}

/// The order with the largest value, and that value.
fn highest(orders: &[f64], of: impl Fn(f64) -> f64 + Sync) -> Option<(f64, f64)> {
    let values: Vec<f64> = orders.par_iter().map(|order| of(*order)).collect();
    orders.iter().copied().zip(values).max_by(|a, b| a.1.total_cmp(&b.1))
}

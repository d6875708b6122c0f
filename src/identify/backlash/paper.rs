//! The paper's measurement of the gap, equation 15: velocity integrated from its zero crossing `t1` to the first local minimum
//! of the current `t2`,
//!
//! ```text
//!   b = |∫ θ̇ dt|,  t1 … t2,  by the trapezoid rule
//! ```
//!
//! Taken literally, the first local minimum of a noisy current is at the first pair of samples, and the estimate collapses. The filter
//! that the rule needs is a zero-phase mean over [`WIDTH`], and a minimum between a fall and a rise above the noise ([`RISE`]).
//! The filtered rule still ends the gap too early: while the rotor crosses the gap alone the current shows a plateau, and where
//! friction falls with speed, bursts.
//! Left out in both forms: the link coasting through the gap while the motor brakes, and the lag of the velocity channel.
//! Reference: L. Márton, B. Lantos (2009), section III-B.

use super::result::{EstimatorResult, LeftOut, Reason, ReversalGap, ShownReversal};
use super::reversal::{Reversal, Session};
use crate::identify::signals::Signals;
use crate::timeseries::Clock;

/// The gap is computed from this number of the last reversals.
const LAST_REVERSALS: usize = 10;
/// [s] Width of the zero-phase mean of the current.
const WIDTH: f64 = 0.060;
/// Least fall from the peak before the minimum, and least rise after it, as a part of the steady current's magnitude after the reversal.
const RISE: f64 = 0.2;
/// [s] What a figure shows before `t1` and after `t2`.
const SHOWN_BEFORE: f64 = 0.3;
/// As above.
const SHOWN_AFTER: f64 = 0.6;

/// Equation 15 on the raw current.
pub(super) fn literal(sessions: &[Session]) -> EstimatorResult {
    estimate("paper_literal", sessions, 0.0, 0.0)
}

/// Equation 15 on the filtered current.
pub(super) fn filtered(sessions: &[Session]) -> EstimatorResult {
    estimate("paper_filtered", sessions, WIDTH, RISE)
}

/// The values of the last ten reversals that have one, and the reversals that have none.
fn estimate(name: &'static str, sessions: &[Session], width: f64, rise: f64) -> EstimatorResult {
    let (mut values, mut left_out) = (Vec::new(), Vec::new());
    for Session { signals, reversals, .. } in sessions {
        let current = centred_mean(&signals.torque, &signals.clock, 0.5 * width);
        for reversal in reversals {
            let time = signals.time[reversal.turn];
            match one(signals, reversal, &current, rise) {
                Ok(Integral { area: gap, .. }) => values.push(ReversalGap {
                    time,
                    velocity: signals.velocity.map_or(f64::NAN, |v| v[reversal.end]),
                    gap,
                    std_error: f64::NAN,
                }),
                Err(reason) => left_out.push(LeftOut { time, reason }),
            }
        }
    }
    let unit = sessions.first().map_or("rad", |session| session.unit);
    let last = values.split_off(values.len().saturating_sub(LAST_REVERSALS));
    EstimatorResult::of_values(name, unit, last, left_out)
}

/// The reversal whose value by equation 15 on the filtered current is nearest to the mean of all.
pub(super) fn typical(sessions: &[Session]) -> Option<ShownReversal> {
    let mean = filtered(sessions).mean.value;
    let mut nearest: Option<(f64, ShownReversal)> = None;
    for Session { signals, reversals, .. } in sessions {
        let current = centred_mean(&signals.torque, &signals.clock, 0.5 * WIDTH);
        for reversal in reversals {
            let Ok(integral) = one(signals, reversal, &current, RISE) else { continue };
            let distance = (integral.area - mean).abs();
            if nearest.as_ref().is_none_or(|(least, _)| distance < *least) {
                nearest = shown(signals, &current, &integral).map(|shown| (distance, shown));
            }
        }
    }
    nearest.map(|(_, shown)| shown)
}

/// The signals around an integral.
fn shown(signals: &Signals, current: &[f64], &Integral { t1, t2, area }: &Integral) -> Option<ShownReversal> {
    let (from, to) = (signals.clock.before(t1, SHOWN_BEFORE), signals.clock.after(t2, SHOWN_AFTER).min(current.len()));
    Some(ShownReversal {
        time: signals.time[from..to].to_vec(),
        velocity: signals.velocity?[from..to].to_vec(),
        torque: signals.torque[from..to].to_vec(),
        filtered: current[from..to].to_vec(),
        ends: [t1 - from, t2 - from],
        area,
    })
}

/// The integral of equation 15: samples at its ends, and its value [rad or m].
struct Integral {
    t1: usize,
    t2: usize,
    area: f64,
}

/// Equation 15 at one reversal.
fn one(signals: &Signals, reversal: &Reversal, current: &[f64], rise: f64) -> Result<Integral, Reason> {
    let sign = reversal.sign();
    let velocity = signals.velocity.ok_or(Reason::NoZeroCrossing)?;
    let t1 = (reversal.start..reversal.end)
        .rev()
        .find(|&k| sign * velocity[k] <= 0.0)
        .and_then(|last_before| {
            // The first crossing after the stroke before it, not the last of a chattering one.
            (reversal.start..=last_before).find(|&k| sign * velocity[k] <= 0.0 && sign * velocity[k + 1] > 0.0)
        })
        .ok_or(Reason::NoZeroCrossing)?;
    let needed = rise * current[reversal.end].abs();
    let t2 = first_minimum(&current[t1..reversal.end], needed).map(|k| t1 + k).ok_or(Reason::NoMinimum)?;
    let area: f64 =
        (t1..t2).map(|k| 0.5 * (velocity[k] + velocity[k + 1]) * (signals.time[k + 1] - signals.time[k])).sum();
    Ok(Integral { t1, t2, area: sign * area })
}

/// First local minimum of `|i|`: with `needed` > 0 the lowest value after a fall of that size from the peak and before a rise of
/// that size.
fn first_minimum(current: &[f64], needed: f64) -> Option<usize> {
    let (mut peak, mut lowest, mut falling) = (0.0_f64, 0, false);
    for (k, i) in current.iter().map(|i| i.abs()).enumerate() {
        if falling {
            if i < current[lowest].abs() {
                lowest = k;
            } else if i > current[lowest].abs() + needed {
                return Some(lowest);
            }
        } else if i < peak - needed {
            (falling, lowest) = (true, k);
        }
        peak = peak.max(i);
    }
    None
}

/// Mean over the samples up to `half` [s] before and after each, fewer at the ends: no phase shift.
fn centred_mean(signal: &[f64], clock: &Clock, half: f64) -> Vec<f64> {
    let mut sums = Vec::with_capacity(signal.len() + 1);
    sums.push(0.0);
    let mut sum = 0.0;
    for &x in signal {
        sum += x;
        sums.push(sum);
    }
    (0..signal.len())
        .map(|k| {
            let (from, to) = (clock.before(k, half), (clock.after(k, half) + 1).min(signal.len()));
            (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}

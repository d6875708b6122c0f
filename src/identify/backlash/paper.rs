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

use std::borrow::Cow;

use super::result::{EstimatorResult, LeftOut, Reason, ReversalGap, ShownReversal};
use super::reversal::{Reversal, Session, find_reversals};
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

/// The signals of a joint in one session, and the reversals at which equation 15 is evaluated.
pub(super) struct Strokes<'a> {
    unit: &'static str,
    signals: Cow<'a, Signals<'a>>,
    reversals: Cow<'a, [Reversal]>,
}

impl<'a> Strokes<'a> {
    /// The reversals of a session that brake most gently.
    pub fn gentlest(session: &'a Session) -> Self {
        let Session { unit, signals, reversals, .. } = session;
        Self { unit, signals: Cow::Borrowed(signals), reversals: Cow::Borrowed(reversals) }
    }

    /// The reversals of the paper: one in each of the last ten steps, from its first direction to its second. Every other reversal leads
    /// from one step to the next.
    pub fn last_steps(unit: &'static str, signals: Signals<'a>) -> Self {
        let all = find_reversals(signals.position, signals.count);
        let mut reversals: Vec<Reversal> = all.into_iter().rev().step_by(2).take(LAST_REVERSALS).collect();
        reversals.reverse();
        Self { unit, signals: Cow::Owned(signals), reversals: Cow::Owned(reversals) }
    }

    /// Whether there are reversals.
    pub fn any(&self) -> bool {
        !self.reversals.is_empty()
    }
}

/// Equation 15 on the raw current.
pub(super) fn literal(strokes: &[Strokes]) -> EstimatorResult {
    estimate("paper_literal", strokes, 0.0, 0.0)
}

/// Equation 15 on the filtered current.
pub(super) fn filtered(strokes: &[Strokes]) -> EstimatorResult {
    estimate("paper_filtered", strokes, WIDTH, RISE)
}

/// The values of the last ten reversals that have one, and the reversals that have none.
fn estimate(name: &'static str, strokes: &[Strokes], width: f64, rise: f64) -> EstimatorResult {
    let (mut values, mut left_out) = (Vec::new(), Vec::new());
    for Strokes { signals, reversals, .. } in strokes {
        let current = centred_mean(&signals.torque, &signals.clock, 0.5 * width);
        for reversal in reversals.iter() {
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
    let unit = strokes.first().map_or("rad", |one| one.unit);
    let last = values.split_off(values.len().saturating_sub(LAST_REVERSALS));
    EstimatorResult::of_values(name, unit, last, left_out)
}

/// The reversal whose value by equation 15 on the filtered current is nearest to the mean of all.
pub(super) fn typical(strokes: &[Strokes]) -> Option<ShownReversal> {
    let mean = filtered(strokes).mean.value;
    let mut nearest: Option<(f64, ShownReversal)> = None;
    for Strokes { signals, reversals, .. } in strokes {
        let current = centred_mean(&signals.torque, &signals.clock, 0.5 * WIDTH);
        for reversal in reversals.iter() {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// [s] Sampling interval, acceleration [rad/s²] and steady speed [rad/s] of the made-up strokes.
    const INTERVAL: f64 = 1e-3;
    const ACCELERATION: f64 = 0.5;
    const SPEED: f64 = 0.1;
    /// Samples of a half stroke, from the reversal to the middle.
    const HALF: usize = 1000;

    /// `steps` steps of two strokes. After each reversal the velocity rises evenly to [`SPEED`]; the current falls from its peak until the
    /// rotor has moved by the gap of that reversal, where it has its first minimum, and rises from there on.
    fn strokes(steps: usize, gap: impl Fn(usize) -> f64) -> [Vec<f64>; 4] {
        let [mut time, mut position, mut velocity, mut torque] = [vec![], vec![], vec![], vec![]];
        let mut x = 0.0;
        for stroke in 0..2 * steps {
            let sign = if stroke % 2 == 0 { 1.0 } else { -1.0 };
            for k in 0..2 * HALF {
                let from_end = (2 * HALF - k) as f64 * INTERVAL;
                let v = sign * (ACCELERATION * (k as f64 * INTERVAL).min(from_end)).min(SPEED);
                // The traverse reaches the gap b at the time √(2 b/a).
                let late = k as f64 * INTERVAL - (2.0 * gap(stroke) / ACCELERATION).sqrt();
                time.push(time.len() as f64 * INTERVAL);
                position.push(x);
                velocity.push(v);
                torque.push(sign * (1.0 + late.abs()));
                x += v * INTERVAL;
            }
        }
        [time, position, velocity, torque]
    }

    /// Reversals into the second stroke of the last ten steps have gap `b`, all others twice that: only the former may be used.
    #[test]
    fn analytic_equation_15_integrates_the_traverses_of_the_last_ten_steps() {
        let (steps, b) = (14, 0.0082);
        let gap = |stroke: usize| if stroke % 2 == 1 && stroke >= 2 * (steps - 10) { b } else { 2.0 * b };
        let [time, position, velocity, torque] = strokes(steps, gap);
        for rectified in [false, true] {
            let torque = torque.iter().map(|tau: &f64| if rectified { tau.abs() } else { *tau }).collect();
            let signals = Signals {
                time: &time,
                clock: Clock::new(&time),
                position: &position,
                velocity: Some(&velocity),
                reference_velocity: None,
                torque,
                rectified,
                torque_noise: 0.0,
                count: 0.0,
            };
            let found = literal(&[Strokes::last_steps("rad", signals)]);
            assert_eq!(found.values.len(), 10, "{:?}", found.left_out);
            // The minimum lies within half a sample of its time, at 0.09 rad/s.
            let allowed = 0.5 * INTERVAL * SPEED;
            assert!(found.values.iter().all(|one| (one.gap - b).abs() < allowed), "{:?}", found.values);
            assert!(found.mean_deviation_percent < 1e-6, "{}", found.mean_deviation_percent);
        }
    }
}

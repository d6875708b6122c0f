//! Frequency, amplitude and phase of a line, and whether it is one line.
//!
//! For each piece, `A_s = 2i E_s/W_s = a e^{iφ}` has the variance `σ_s² = 4 level_s/W_s²`. The evidence `η_s = |E_s|²/level_s` gives
//! `σ_a/a = σ_φ = 1/√(2η)` and `σ_ω² = 1/(2 Σ η_s var_s t)`. All sessions share the phase relative to their start, as in the effect;
//! differences between them beyond noise increase the errors.

use crate::diagnose::fit::golden::golden_section;
use nalgebra::Complex;
use std::f64::consts::TAU;

use super::balance::Stiffness;
use super::piece::Piece;
use super::spectrum::unexplained;
use super::{PRESENT, beyond_chance};
use crate::replay::Gain;
use crate::timeseries::Estimate;

/// Least amplitude of a line in slow and in fast motion, relative to its mean amplitude; the largest is the inverse.
const EVERYWHERE: f64 = 0.5;
/// The same where the sessions disagree on the amplitude.
const ROUGHLY: f64 = 0.25;
/// Factor by which the faster half of the samples has to be faster.
const FASTER: f64 = 1.3;
/// Relative difference of pieces that is accepted beyond their errors: the links' inertia changes with the arm's shape.
const DIFFERENT: f64 = 0.25;
/// Probability that pieces of one line are judged as different.
const DISAGREE: f64 = 1e-3;
/// [1] Relative standard error of the torque balance, and [rad] of its phase: the influence of the gear's spring and gap on a fast torque.
/// On the tuning machines 1407, 4602, 4700 and 4701 the amplitude was off by −10, −13, 8 and −35 %, the phase by 0.13, 0.09, 0.21, −0.74.
const SYSTEMATIC: f64 = 0.3;
const PHASE: f64 = 0.35;
/// [rad] Drift of that phase with the arm's shape during a session: 2 mHz in 40 s.
const WANDER: f64 = 0.15;
/// Steps of the golden section that finds the frequency.
const STEPS: usize = 24;

/// A torque at a fixed frequency.
#[derive(Debug, Clone)]
pub struct Line {
    /// `f` [Hz].
    pub frequency: Estimate,
    /// `a` [N·m or N].
    pub amplitude: Estimate,
    /// `φ` [rad] of a sine, relative to the start of the session.
    pub phase: Estimate,
    /// [Hz] Frequency resolution.
    pub resolution: f64,
    /// [nats] Evidence of the training data.
    pub evidence: f64,
    /// Reduction of the amplitude at the frequency in the held-out data.
    pub gain: Gain,
}

impl Line {
    /// `a sin(2π f t + φ)` [N·m or N], `t` [s] since the start of a session.
    pub fn torque(&self, t: f64) -> f64 {
        self.amplitude.value * (TAU * self.frequency.value * t + self.phase.value).sin()
    }
}

/// One piece with stiffness and noise near its frequency.
pub struct MeasuredPiece<'p> {
    /// The piece.
    pub piece: &'p Piece,
    /// `1/R̄`.
    pub stiffness: &'p Stiffness,
    /// Level of its noise.
    pub level: f64,
}

/// The line in one piece at the frequency.
struct Phasor {
    /// `a e^{iφ}`.
    a: Complex<f64>,
    /// `σ_s²` of its real and imaginary part together.
    variance: f64,
    /// `η`.
    evidence: f64,
}

fn phasor(part: &MeasuredPiece, f: f64, pick: &dyn Fn(usize) -> bool) -> Phasor {
    let (e, total) = unexplained(part.stiffness, part.piece, f, pick);
    // Noise grows with the share of samples in the part.
    let level = part.level * total / part.piece.total();
    Phasor {
        a: Complex::new(0.0, 2.0) * e / total.max(1e-300),
        variance: 4.0 * level / total.max(1e-300).powi(2),
        evidence: e.norm_sqr() / level.max(1e-300),
    }
}

/// The line near `f` [Hz], if there is one, estimated from the training pieces and judged by the held-out pieces; `step` [Hz] is the distance
/// of the scanned frequencies.
pub fn estimated((parts, held_out): (&[MeasuredPiece], &[MeasuredPiece]), f: f64, step: f64) -> Option<Line> {
    let phasors_of = |parts: &[MeasuredPiece], f: f64| -> Vec<Phasor> {
        parts.iter().map(|part| phasor(part, f, &|_| true)).collect()
    };
    let at = |f: f64| phasors_of(parts, f);
    let pieces: Vec<&Piece> = parts.iter().map(|part| part.piece).collect();
    let apart = |f: f64| -> f64 { at(f).iter().map(|phasor| phasor.evidence).sum() };
    let rough = peak(&apart, f, step);
    let together = |f: f64| mean(&at(f)).1;
    let f = if agrees(&at(rough)) { peak(&together, rough, step) } else { rough };
    let phasors = at(f);
    let agree = agrees(&phasors);
    let common = mean(&phasors).0;
    let amplitude = common.norm();
    // If the torque balance differs between sessions, a line that no session lacks is accepted, with an uncertain amplitude.
    let nowhere_lacking = phasors.iter().all(|phasor| phasor.evidence > PRESENT);
    if !(agree && everywhere(parts, f, amplitude, EVERYWHERE)
        || nowhere_lacking && everywhere(parts, f, magnitude(&phasors), ROUGHLY))
    {
        return None;
    }
    let evidence: f64 = phasors.iter().map(|phasor| phasor.evidence).sum();
    let relative = 1.0 / (2.0 * evidence).sqrt() * disagreement(&phasors).sqrt();
    let spread: f64 = pieces.iter().zip(&phasors).map(|(piece, phasor)| phasor.evidence * times(piece)[1]).sum();
    let late: f64 =
        pieces.iter().zip(&phasors).map(|(piece, phasor)| phasor.evidence * times(piece)[0]).sum::<f64>() / evidence;
    let wander = WANDER / (spread / evidence).sqrt();
    let omega_error = (1.0 / (2.0 * spread).sqrt()).hypot(wander);
    Some(Line {
        frequency: Estimate { value: f, std_error: omega_error / TAU },
        amplitude: Estimate { value: amplitude, std_error: amplitude * relative.hypot(SYSTEMATIC) },
        phase: Estimate { value: common.arg(), std_error: relative.hypot(late * omega_error).hypot(PHASE) },
        resolution: 4.0 * step,
        evidence,
        gain: gain(common, &phasors_of(held_out, f)),
    })
}

/// 97.5 % quantile of the normal distribution.
const Z: f64 = 1.959_964;

/// Gain of the amplitude in held-out pieces when the line is removed.
///
/// ```text
///   P = Σ |A|²/σ²,   D = Σ (|A|² − |A − c|²)/σ²,   g = 1 − √(1 − D/P),   Var D = 2 Σ |c|²/σ²
/// ```
/// `D` is linear in the readings `A`, whose real and imaginary parts each have the variance `σ²/2`; this gives its 95 % interval.
fn gain(c: Complex<f64>, held_out: &[Phasor]) -> Gain {
    let sum = |of: &dyn Fn(&Phasor) -> f64| -> f64 { held_out.iter().map(|phasor| of(phasor) / phasor.variance).sum() };
    let power = sum(&|phasor| phasor.a.norm_sqr()).max(1e-300);
    let less = power - sum(&|phasor| (phasor.a - c).norm_sqr());
    let scatter = Z * (2.0 * sum(&|_| c.norm_sqr())).sqrt();
    let percent = |less: f64| 100.0 * (1.0 - (1.0 - (less / power).min(1.0)).sqrt());
    let interval_percent = [percent(less - scatter), percent(less + scatter)];
    Gain { gain_percent: percent(less), interval_percent, shown: !held_out.is_empty() && interval_percent[0] > 0.0 }
}

/// Mean weighted by the errors, and its `|A|²/σ²`.
fn mean(phasors: &[Phasor]) -> (Complex<f64>, f64) {
    let weight: f64 = phasors.iter().map(|phasor| 1.0 / phasor.variance).sum();
    let sum: Complex<f64> = phasors.iter().map(|phasor| phasor.a / phasor.variance).sum();
    (sum / weight, (sum / weight).norm_sqr() * weight)
}

/// Mean amplitude for any phases, minus the contribution of noise.
fn magnitude(phasors: &[Phasor]) -> f64 {
    let weight: f64 = phasors.iter().map(|phasor| 1.0 / phasor.variance).sum();
    let power: f64 = phasors.iter().map(|phasor| phasor.a.norm_sqr() / phasor.variance - 1.0).sum();
    (power / weight).max(0.0).sqrt()
}

/// `χ²` of the pieces against their mean relative to its expectation by chance, at least 1 (R. T. Birge 1932).
fn disagreement(phasors: &[Phasor]) -> f64 {
    let common = mean(phasors).0;
    let sum: f64 = phasors.iter().map(|phasor| (phasor.a - common).norm_sqr() / phasor.variance).sum();
    (sum / (phasors.len().max(2) - 1) as f64).max(1.0)
}

/// Whether all pieces agree with the mean: by chance, their deviations follow a gamma distribution.
fn agrees(phasors: &[Phasor]) -> bool {
    let common = mean(phasors).0;
    let slack = (DIFFERENT * common.norm()).powi(2);
    let sum: f64 = phasors.iter().map(|phasor| (phasor.a - common).norm_sqr() / (phasor.variance + slack)).sum();
    sum < beyond_chance(phasors.len().max(2) - 1, DISAGREE)
}

/// Whether slow and fast motion show the line equally.
fn everywhere(parts: &[MeasuredPiece], f: f64, amplitude: f64, least: f64) -> bool {
    let mut speeds: Vec<f64> = parts
        .iter()
        .map(|part| part.piece)
        .flat_map(|piece| piece.speed.iter().zip(&piece.weight).filter(|(_, w)| **w > 0.0).map(|(v, _)| *v))
        .collect();
    if speeds.is_empty() {
        return false;
    }
    let middle = speeds.len() / 2;
    let (slower, median, faster) = speeds.select_nth_unstable_by(middle, f64::total_cmp);
    let average = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    if average(faster) < FASTER * average(slower) {
        return false;
    }
    let median = *median;
    [false, true].into_iter().all(|fast| {
        let half: Vec<Phasor> = parts
            .iter()
            .map(|part| phasor(part, f, &|k| (part.piece.speed[k] > median) == fast))
            .filter(|phasor| phasor.variance.is_finite() && phasor.variance > 0.0)
            .collect();
        let part = magnitude(&half) / amplitude;
        part > least && part < 1.0 / least
    })
}

/// [s, s²] Mean time of a piece since the start of its session, and its variance.
fn times(piece: &Piece) -> [f64; 2] {
    let moment = |power: i32| -> f64 {
        piece.weight.iter().enumerate().map(|(k, w)| w * piece.time(k).powi(power)).sum::<f64>() / piece.total()
    };
    let mean = moment(1);
    [mean, (moment(2) - mean * mean).max(0.0)]
}

/// The frequency of the largest value within one step on either side.
fn peak(value: &dyn Fn(f64) -> f64, f: f64, step: f64) -> f64 {
    let mut steps = 0..=STEPS;
    let (low, high) = golden_section([f - step, f + step], |_, _| steps.next().is_none(), value);
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn phasors(values: &[(f64, f64)]) -> Vec<Phasor> {
        let phasor = |(size, phase): &(f64, f64)| Phasor {
            a: Complex::from_polar(*size, *phase),
            variance: 1e-4,
            evidence: size * size / 1e-4,
        };
        values.iter().map(phasor).collect()
    }

    /// Deviations of one standard error are chance; scattered phases are not one line.
    #[test]
    fn sessions_agree_on_one_line_only() {
        assert!(agrees(&phasors(&[(0.10, 1.0), (0.11, 1.05), (0.095, 0.95)])));
        assert!(!agrees(&phasors(&[(0.10, 1.0), (0.10, 3.0), (0.10, -1.0)])));
        assert!((disagreement(&phasors(&[(0.1, 1.0), (0.1, 1.0)])) - 1.0).abs() < 1e-12);
    }

    /// The mean of values with equal errors is the plain mean.
    #[test]
    fn mean_of_equals() {
        let (common, evidence) = mean(&phasors(&[(0.1, 0.0), (0.3, 0.0)]));
        assert!((common - Complex::from(0.2)).norm() < 1e-12);
        // |A|²/σ² of two values: 0.04 · 2/1e-4.
        assert!((evidence - 800.0).abs() < 1e-6);
    }
}

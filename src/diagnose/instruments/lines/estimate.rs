//! Frequency, amplitude and phase of a line, and whether it is one line.
//!
//! ```text
//!   E = Σ w R* (θ − R τ_m) e^{−iωt},   W = Σ w |R|²,   A = 2i E/W = a e^{iφ},   σ² = 4 N/(W Σ w),   η = |E|² Σ w/(N W)
//! ```
//! in each piece, `R` of each sample's posture ([`balance`](super::balance)), `N` the level of the noise in position: the least squares of a line in a position
//! with even noise. The evidence `η` gives `σ_a/a = σ_φ = 1/√(2η)` and `σ_ω² = 1/(2 Σ η_s var_s t)`. All sessions share the phase relative to their start, as in the effect;
//! differences between them beyond noise increase the errors.

use crate::diagnose::fit::golden::golden_section;
use nalgebra::Complex;
use std::f64::consts::TAU;

use super::piece::Piece;
use super::{PRESENT, beyond_chance};
use crate::replay::Gain;
use crate::timeseries::Estimate;

/// Least amplitude of a line in slow and in fast motion, relative to its mean amplitude; the largest is the inverse.
const EVERYWHERE: f64 = 0.5;
/// Probability that noise shows a line in the slower or the faster half, or in all pieces but the strongest: beside the evidence of all, which is beyond chance.
const ABSENT: f64 = 0.01;
/// Factor of two speeds that makes them unlike: fast runs differ by less, a staircase from them by more.
const SIMILAR: f64 = 1.5;
/// Distances from a line, in frequency resolutions, at which it has less than a hundredth of its power.
const BESIDE: [f64; 4] = [3.5, 4.5, 5.5, 6.5];
/// Probability with which a continuum would look like a line, in a piece that shows it.
const CONTINUUM: f64 = 0.05;
/// Factor by which the faster half of the samples has to be faster.
const FASTER: f64 = 1.3;
/// Relative difference of pieces that is accepted beyond their errors: the links' inertia changes with the arm's shape.
const DIFFERENT: f64 = 0.25;
/// Probability that pieces of one line are judged as different.
const DISAGREE: f64 = 1e-3;
/// [1] Relative standard error of the torque balance, and [rad] of its phase: the influence of the gear's spring and gap on a fast torque.
/// On tuning machines (seeds 1093600 to 1093704) amplitudes were off by −7 to 22 %, phases by at most 0.24.
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
    /// Whether the gain is that of training pieces, each predicted from the others.
    pub is_gain_in_training: bool,
}

impl Line {
    /// `a sin(2π f t + φ)` [N·m or N], `t` [s] since the start of a session.
    pub fn torque(&self, t: f64) -> f64 {
        self.amplitude.value * (TAU * self.frequency.value * t + self.phase.value).sin()
    }
}

/// One piece with receptance and noise near a frequency.
pub struct MeasuredPiece<'p> {
    /// The piece.
    pub piece: &'p Piece,
    /// `R` in each of its postures.
    pub receptance: Vec<Complex<f64>>,
    /// `N`.
    pub noise: f64,
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
    let (sum, total) = part.piece.matched(f, &part.receptance, pick);
    let (e, total) = (sum / part.piece.gain(f), total.max(1e-300));
    let noise = part.noise / part.piece.total();
    Phasor {
        a: Complex::new(0.0, 2.0) * e / total,
        variance: 4.0 * noise / total,
        evidence: e.norm_sqr() / (noise * total).max(1e-300),
    }
}

/// The line near `f` [Hz], if there is one, estimated from the training pieces and judged by the held-out pieces; `step` [Hz] is the distance
/// of the scanned frequencies.
pub fn estimated((parts, held_out): (&[MeasuredPiece], &[MeasuredPiece]), f: f64, step: f64) -> Option<Line> {
    let phasors_of = |parts: &[MeasuredPiece], f: f64| -> Vec<Phasor> {
        parts.iter().map(|part| phasor(part, f, &|_| true)).collect()
    };
    let at = |f: f64| phasors_of(parts, f);
    let apart = |f: f64| -> f64 { at(f).iter().map(|phasor| phasor.evidence).sum() };
    let rough = peak(&apart, f, step);
    let together = |f: f64| mean(&at(f)).1;
    let f = if agrees(&at(rough)) { peak(&together, rough, step) } else { rough };
    let phasors = at(f);
    let agree = agrees(&phasors);
    let common = mean(&phasors).0;
    let amplitude = common.norm();
    // Where flanks part, a gear yields more than the balance says, and a line seems stronger, weaker or later: its frequency remains.
    let one_line = || narrow(parts, f) && several(&phasors) && in_both_halves(parts, f);
    if !(agree && everywhere(parts, f, amplitude) || one_line()) {
        return None;
    }
    let evidence: f64 = phasors.iter().map(|phasor| phasor.evidence).sum();
    let relative = 1.0 / (2.0 * evidence).sqrt() * disagreement(&phasors).sqrt();
    let moment = |power: usize| -> f64 {
        parts.iter().zip(&phasors).map(|(part, phasor)| phasor.evidence * times(part.piece)[power]).sum()
    };
    let (late, spread) = (moment(0) / evidence, moment(1));
    let wander = WANDER / (spread / evidence).sqrt();
    let omega_error = (1.0 / (2.0 * spread).sqrt()).hypot(wander);
    let (gain, is_gain_in_training) = shown_gain([parts, held_out], [&phasors, &phasors_of(held_out, f)]);
    Some(Line {
        frequency: Estimate { value: f, std_error: omega_error / TAU },
        amplitude: Estimate { value: amplitude, std_error: amplitude * relative.hypot(SYSTEMATIC) },
        phase: Estimate { value: common.arg(), std_error: relative.hypot(late * omega_error).hypot(PHASE) },
        resolution: 4.0 * step,
        evidence,
        gain,
        is_gain_in_training,
    })
}

/// 97.5 % quantile of the normal distribution.
const Z: f64 = 1.959_964;

/// The gain in the held-out pieces. Where noise hides what is expected there, and the training pieces show one, in these instead, each predicted from the
/// others; and whether it is that.
fn shown_gain([parts, held_out]: [&[MeasuredPiece]; 2], [phasors, held_out_phasors]: [&[Phasor]; 2]) -> (Gain, bool) {
    let all: Vec<(&MeasuredPiece, &Phasor)> = parts.iter().zip(phasors).collect();
    let expected: Vec<Complex<f64>> = held_out.iter().map(|one| predicted(&all, one)).collect();
    let confirmed = gain(&expected, held_out_phasors);
    let sought: f64 = held_out_phasors.iter().zip(&expected).map(|(one, c)| c.norm_sqr() / one.variance).sum();
    // From here on `D`, expected to be as large, would exceed its scatter.
    if confirmed.shown || sought > 2.0 * Z * Z || parts.len() < 2 {
        return (confirmed, false);
    }
    let from_others = |index: usize| {
        let others: Vec<_> = (0..all.len()).filter(|other| *other != index).map(|other| all[other]).collect();
        predicted(&others, &parts[index])
    };
    let elsewhere = gain(&(0..all.len()).map(from_others).collect::<Vec<_>>(), phasors);
    if elsewhere.shown { (elsewhere, true) } else { (confirmed, false) }
}

/// What a piece is expected to show: the mean of what other pieces show, those of similar speed first. Pieces of similar motion have their
/// flanks apart for similar times, which decides what a line does to a position.
fn predicted(others: &[(&MeasuredPiece, &Phasor)], one: &MeasuredPiece) -> Complex<f64> {
    let speed = |part: &MeasuredPiece| {
        let Piece { speed, weight, .. } = part.piece;
        speed.iter().zip(weight).map(|(v, w)| v * w).sum::<f64>() / part.piece.total()
    };
    let unlike = |part: &MeasuredPiece| ((speed(part) / speed(one)).ln() / SIMILAR.ln()).powi(2);
    let least = others.iter().map(|(part, _)| unlike(part)).fold(f64::INFINITY, f64::min);
    let weights: Vec<f64> =
        others.iter().map(|(part, phasor)| (least - unlike(part)).exp() / phasor.variance).collect();
    let sum: Complex<f64> = weights.iter().zip(others).map(|(weight, (_, phasor))| phasor.a * *weight).sum();
    sum / weights.iter().sum::<f64>()
}

/// Gain of the amplitude in held-out pieces when what is expected of the line is removed from each.
///
/// ```text
///   P = Σ |A|²/σ²,   D = Σ (|A|² − |A − c|²)/σ²,   g = 1 − √(1 − D/P),   Var D = 2 Σ |c|²/σ²
/// ```
/// `D` is linear in the readings `A`, whose real and imaginary parts each have the variance `σ²/2`; this gives its 95 % interval.
fn gain(expected: &[Complex<f64>], held_out: &[Phasor]) -> Gain {
    let sum = |of: &dyn Fn(&Phasor, Complex<f64>) -> f64| -> f64 {
        held_out.iter().zip(expected).map(|(phasor, c)| of(phasor, *c) / phasor.variance).sum()
    };
    let power = sum(&|phasor, _| phasor.a.norm_sqr()).max(1e-300);
    let less = power - sum(&|phasor, c| (phasor.a - c).norm_sqr());
    let scatter = Z * (2.0 * sum(&|_, c| c.norm_sqr())).sqrt();
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

/// Whether a line is as narrow as the length of the pieces allows: beside it, from three to six resolutions away, there is next to nothing. A loop that
/// oscillates by itself changes its frequency by more, and has as much there. Of a continuum, `η` exceeds the sum `S` of `n` values beside it with the
/// probability `(1 + η/S)^(−n)`. Every piece that shows the line has to be unlike one, and all together.
fn narrow(parts: &[MeasuredPiece], f: f64) -> bool {
    let of_continuum = |part: &MeasuredPiece| {
        let evidence = |f: f64| phasor(part, f, &|_| true).evidence;
        let resolution = 1.0 / (12.0 * times(part.piece)[1]).sqrt();
        let beside = BESIDE.map(|away| evidence(f + away * resolution) + evidence(f - away * resolution));
        let (here, beside) = (evidence(f), beside.iter().sum::<f64>());
        (here, -(2.0 * BESIDE.len() as f64) * (here / beside.max(f64::MIN_POSITIVE)).ln_1p())
    };
    let all: Vec<(f64, f64)> = parts.iter().map(of_continuum).collect();
    let together = -all.iter().map(|(_, ln_chance)| ln_chance).sum::<f64>();
    together > beyond_chance(parts.len(), ABSENT)
        && all.iter().all(|(here, ln_chance)| *here < PRESENT || *ln_chance < CONTINUUM.ln())
}

/// Whether several pieces show a line, if there are several: those without the strongest, beyond chance.
fn several(phasors: &[Phasor]) -> bool {
    let strongest = phasors.iter().map(|phasor| phasor.evidence).fold(0.0, f64::max);
    let others = phasors.iter().map(|phasor| phasor.evidence).sum::<f64>() - strongest;
    phasors.len() == 1 || others > beyond_chance(phasors.len() - 1, ABSENT)
}

/// The line in slow and in fast motion: in the slower and the faster half of the samples of each piece; `None` where speeds hardly differ.
fn halves(parts: &[MeasuredPiece], f: f64) -> Option<[Vec<Phasor>; 2]> {
    let mut speeds: Vec<f64> = parts
        .iter()
        .flat_map(|part| part.piece.speed.iter().zip(&part.piece.weight).filter(|(_, w)| **w > 0.0).map(|(v, _)| *v))
        .collect();
    if speeds.is_empty() {
        return None;
    }
    let middle = speeds.len() / 2;
    let (slower, median, faster) = speeds.select_nth_unstable_by(middle, f64::total_cmp);
    let average = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    if average(faster) < FASTER * average(slower) {
        return None;
    }
    let median = *median;
    let half = |fast: bool| -> Vec<Phasor> {
        let all = parts.iter().map(|part| phasor(part, f, &|k| (part.piece.speed[k] > median) == fast));
        all.filter(|phasor| phasor.variance.is_finite() && phasor.variance > 0.0).collect()
    };
    Some([half(false), half(true)])
}

/// Whether slow and fast motion show the line equally.
fn everywhere(parts: &[MeasuredPiece], f: f64, amplitude: f64) -> bool {
    let equally = |half: &Vec<Phasor>| (EVERYWHERE..1.0 / EVERYWHERE).contains(&(magnitude(half) / amplitude));
    halves(parts, f).is_some_and(|halves| halves.iter().all(equally))
}

/// Whether slow and fast motion both show the line beyond chance.
fn in_both_halves(parts: &[MeasuredPiece], f: f64) -> bool {
    let evidence = |half: &Vec<Phasor>| half.iter().map(|phasor| phasor.evidence).sum::<f64>();
    let shows = |half: &Vec<Phasor>| evidence(half) > beyond_chance(half.len().max(1), ABSENT);
    halves(parts, f).is_some_and(|halves| halves.iter().all(shows))
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
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

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

    /// A torque with white noise: a pure line, and one of the same power whose frequency wanders by 0.3 Hz as that of a loop does.
    #[test]
    fn property_what_wanders_in_frequency_is_no_narrow_line() {
        let (samples, dt, f) = (40_000, 1e-3, 25.0);
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let noise: Vec<f64> = (0..samples).map(|_| random.random_range(-0.5..0.5)).collect();
        let with = |wander: f64| {
            let d = |t: f64| {
                let turned = std::f64::consts::TAU * f * t + wander / 0.1 * (std::f64::consts::TAU * 0.1 * t).sin();
                0.1 * turned.sin() + noise[(t / dt).round() as usize]
            };
            Piece::of_torque(&[1.0], samples, dt, &d)
        };
        // |E|² of white noise of variance 1/12 over these samples, over H².
        let is_narrow = |piece: &Piece| {
            let level = samples as f64 / 12.0 / piece.gain(f).powi(2);
            let part = MeasuredPiece { piece, receptance: vec![Complex::from(1.0)], noise: level };
            let evidence = phasor(&part, f, &|_| true).evidence;
            assert!(evidence > PRESENT, "{evidence}");
            narrow(&[part], f)
        };
        assert!(is_narrow(&with(0.0)));
        assert!(!is_narrow(&with(0.3)));
    }

    #[test]
    fn property_a_line_of_one_session_is_no_line_of_several() {
        let with = |evidence: &[f64]| -> Vec<Phasor> {
            let one = |evidence: &f64| Phasor { a: Complex::from(0.1), variance: 1e-4, evidence: *evidence };
            evidence.iter().map(one).collect()
        };
        assert!(!several(&with(&[200.0, 2.0, 3.0])));
        // Beyond chance: one in a hundred exceeds 6.6 together.
        assert!(several(&with(&[65.0, 3.5, 3.5])) && several(&with(&[30.0])));
    }
}

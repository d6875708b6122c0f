//! Spectra of the residual of the rigid zone: against the order of the motor angle, and against frequency in time.
//!
//! Frequency: Hann windows of 4 s, overlapping by half, `A(f) = 2 |Σ w e e^{−2πift}|/Σ w` over the rows of the rigid zone, mean square of
//! all windows. A line of amplitude `a` at `f_k` gives `a` there and `a/2` in both neighbours, so that `⅔ Σ A²/2` of the three is its power.
//! The floor is the amplitude of noise with the size of the row floor, spread evenly over the band.

use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

use super::Residual;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::result::{FrequencySpectrum, OrderSpectrum};

/// Orders of the motor angle.
const ORDERS: usize = 48;
/// [s] Length of a window.
const WINDOW: f64 = 4.0;
/// Largest number of frequencies.
const FREQUENCIES: usize = 200;
/// Least part of a window in the rigid zone.
const LEAST_RIGID: f64 = 0.3;
/// Number of frequencies on either side of a line from which its background is taken.
const AROUND: usize = 8;
/// Amplitude relative to the strongest line of a joint's velocity above which a frequency belongs to the motion and is not reported.
const OF_MOTION: f64 = 0.02;
/// Noise bandwidth of the Hann window, in frequency steps.
const HANN_BANDWIDTH: f64 = 1.5;

fn rigid_rows(problem: &Problem, joint: usize) -> Vec<usize> {
    (0..problem.motion.rows()).filter(|row| problem.judged[joint][*row]).collect()
}

fn mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    values.map(|value| value * value).sum::<f64>() / count
}

/// Amplitude of the residual at whole orders of the motor angle, corrected for the kernel's gain.
pub fn by_order(problem: &Problem, residuals: &[Residual], floor: &[Vec<f64>]) -> Vec<OrderSpectrum> {
    let spectrum = |joint: usize| {
        let residual = &residuals[joint];
        let model = &problem.motion.model.joints[joint];
        let rows = rigid_rows(problem, joint);
        let amplitudes = |order: usize| {
            let [cos, sin] = problem.motion.harmonic(joint, order as f64 * model.gear_ratio, |_, _| 1.0);
            [&residual.before, &residual.after].map(|values| amplitude(&rows, &cos, &sin, values))
        };
        let found: Vec<[f64; 2]> = (1..=ORDERS).into_par_iter().map(amplitudes).collect();
        let independent = (rows.len() as f64 * problem.independence[joint]).max(1.0);
        OrderSpectrum {
            joint: model.name.clone(),
            order: (1..=ORDERS).map(|order| order as f64).collect(),
            before: found.iter().map(|[before, _]| *before).collect(),
            after: found.iter().map(|[_, after]| *after).collect(),
            floor: 2.0 * (mean_square(rows.iter().map(|row| floor[joint][*row])) / independent).sqrt(),
        }
    };
    problem.joints().into_iter().map(spectrum).collect()
}

/// Amplitude of a harmonic, fitted by least squares.
fn amplitude(rows: &[usize], cos: &[f64], sin: &[f64], values: &[f64]) -> f64 {
    let sums = rows.iter().fold([0.0; 5], |mut s, row| {
        let (c, d, e) = (cos[*row], sin[*row], values[*row]);
        for (sum, term) in s.iter_mut().zip([c * c, c * d, d * d, c * e, d * e]) {
            *sum += term;
        }
        s
    });
    let determinant = sums[0] * sums[2] - sums[1] * sums[1];
    if determinant <= 1e-12 * sums[0] * sums[2] || rows.is_empty() {
        return 0.0;
    }
    let a = (sums[2] * sums[3] - sums[1] * sums[4]) / determinant;
    let b = (sums[0] * sums[4] - sums[1] * sums[3]) / determinant;
    a.hypot(b)
}

/// Amplitude of the residual against frequency.
pub fn by_frequency(problem: &Problem, residuals: &[Residual], floor: &[Vec<f64>]) -> Vec<FrequencySpectrum> {
    let spectrum = |joint: usize| {
        let residual = &residuals[joint];
        let rows = rigid_rows(problem, joint);
        let power = mean_square(rows.iter().map(|row| floor[joint][*row]));
        let (frequency, before) = spectrum(problem, joint, &residual.before);
        let (_, after) = spectrum(problem, joint, &residual.after);
        let band = frequency.last().copied().unwrap_or(1.0);
        FrequencySpectrum {
            joint: problem.motion.model.joints[joint].name.clone(),
            floor: (2.0 * power * HANN_BANDWIDTH / WINDOW / band).sqrt(),
            frequency,
            before,
            after,
        }
    };
    problem.joints().into_par_iter().map(spectrum).collect()
}

/// Frequency [Hz] of the strongest line that does not belong to the motion, and its share in the squared residual, 0 to 1.
pub fn strongest_line(problem: &Problem, joint: usize, values: &[f64]) -> Option<(f64, f64)> {
    let (frequency, amplitude) = spectrum(problem, joint, values);
    let total = mean_square(rigid_rows(problem, joint).iter().map(|row| values[*row]));
    let power = |k: usize| 0.5 * amplitude[k] * amplitude[k];
    let line = |k: usize| {
        let around = k.saturating_sub(AROUND)..(k + AROUND + 1).min(amplitude.len());
        let mut beside: Vec<f64> = around.filter(|other| other.abs_diff(k) > 1).map(power).collect();
        beside.sort_by(f64::total_cmp);
        let below = beside.get(beside.len() / 2).copied().unwrap_or(0.0);
        ((k - 1..=k + 1).map(power).sum::<f64>() - 3.0 * below) / HANN_BANDWIDTH
    };
    let moved: Vec<Vec<f64>> = problem.motion.joints.par_iter().map(|m| spectrum(problem, joint, &m.v).1).collect();
    let of_motion = |k: usize| {
        moved.iter().any(|v| {
            let most = v.iter().fold(0.0_f64, |most, a| most.max(*a));
            v[k - 1..=k + 1].iter().any(|a| *a > OF_MOTION * most)
        })
    };
    let lines = (1..amplitude.len().saturating_sub(1)).filter(|k| !of_motion(*k)).map(|k| (frequency[k], line(k)));
    let (frequency, power) = lines.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((frequency, (power / total.max(1e-300)).clamp(0.0, 1.0)))
}

/// Frequencies [Hz] and amplitudes.
fn spectrum(problem: &Problem, joint: usize, values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let motion = &problem.motion;
    let spacing = (1..motion.rows())
        .filter(|row| motion.part[*row] == motion.part[row - 1])
        .map(|row| motion.time[row] - motion.time[row - 1])
        .fold(0.0, f64::max);
    let count = ((0.5 / spacing.max(1e-6) * WINDOW) as usize).clamp(1, FREQUENCIES);
    let mut powers = vec![0.0; count];
    let mut windows = 0.0;
    let mut first = 0;
    while first < motion.rows() {
        let end = |from: usize, length: f64| {
            let same =
                |row: &usize| motion.part[*row] == motion.part[from] && motion.time[*row] < motion.time[from] + length;
            (from..motion.rows()).take_while(same).last().map_or(from + 1, |row| row + 1)
        };
        let rows = first..end(first, WINDOW);
        if let Some(amplitudes) = window(problem, joint, rows, values, count) {
            powers.iter_mut().zip(&amplitudes).for_each(|(power, a)| *power += a * a);
            windows += 1.0;
        }
        first = end(first, 0.5 * WINDOW);
    }
    let frequency = (1..=count).map(|k| k as f64 / WINDOW).collect();
    (frequency, powers.iter().map(|power| (power / f64::max(windows, 1.0)).sqrt()).collect())
}

/// Amplitudes of one window; `None` where too little of it is in the rigid zone.
fn window(
    problem: &Problem,
    joint: usize,
    rows: std::ops::Range<usize>,
    values: &[f64],
    count: usize,
) -> Option<Vec<f64>> {
    let time = &problem.motion.time;
    let start = time[rows.start];
    if time[rows.end - 1] - start < 0.9 * WINDOW {
        return None;
    }
    let (mut sums, mut weights, mut all) = (vec![[0.0; 2]; count], 0.0, 0.0);
    for row in rows {
        let t = time[row] - start;
        let weight = (PI * t / WINDOW).sin().powi(2);
        all += weight;
        if !problem.judged[joint][row] {
            continue;
        }
        weights += weight;
        // Rotate from one frequency to the next instead of computing a sine each time.
        let (sin, cos) = (TAU * t / WINDOW).sin_cos();
        let (mut re, mut im) = (weight * values[row], 0.0);
        for sum in &mut sums {
            (re, im) = (re * cos - im * sin, re * sin + im * cos);
            sum[0] += re;
            sum[1] += im;
        }
    }
    (weights > LEAST_RIGID * all).then(|| sums.iter().map(|[re, im]| 2.0 * re.hypot(*im) / weights).collect())
}

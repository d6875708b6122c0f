//! Spectrum of the disturbance torque of a piece, and the level of its noise.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::f64::consts::{PI, TAU};

use super::balance::Stiffness;
use super::piece::Piece;

/// [Hz] Distance on either side of a frequency over which its level is computed.
const AROUND: f64 = 2.0;
/// [Hz] Distance of the frequencies at which levels are computed.
const SPACING: f64 = 0.5;

/// `|E|²` at the frequencies `k · step`, and the level of its noise.
pub struct Spectrum {
    /// `|E|²`, starting at the first frequency.
    pub power: Vec<f64>,
    /// Mean of `|E|²` where there is no line, at the same frequencies.
    pub level: Vec<f64>,
}

/// `E = Σ w d e^{−iωt}` of a piece over the selected samples, and their `Σ w`.
pub fn unexplained(stiffness: &Stiffness, piece: &Piece, f: f64, pick: &dyn Fn(usize) -> bool) -> (Complex<f64>, f64) {
    let ([position, torque], total) = piece.transform(f, pick);
    ((stiffness.at(f) * position - torque) / piece.gain(f), total)
}

/// The spectrum at the multiples `first..last` of `step` [Hz], which is `1/(length · dt)` of a piece at even times.
pub fn spectrum(stiffness: &Stiffness, piece: &Piece, length: usize, step: f64, [first, last]: [usize; 2]) -> Spectrum {
    let mut z = vec![Complex::default(); length];
    let samples = piece.position.iter().zip(&piece.torque).map(|(position, torque)| Complex::new(*position, *torque));
    match piece.uneven_times() {
        None => {
            z.iter_mut().zip(samples).for_each(|(z, sample)| *z = sample);
            FftPlanner::new().plan_fft_forward(length).process(&mut z);
        }
        Some(times) => z = transform(times, &samples.collect::<Vec<_>>(), step, length),
    }
    let power: Vec<f64> = (first..last)
        .map(|k| {
            let (a, b) = (z[k], z[length - k].conj());
            let (position, torque) = ((a + b) * 0.5, (a - b) * Complex::new(0.0, -0.5));
            let f = k as f64 * step;
            ((stiffness.at(f) * position - torque) / piece.gain(f)).norm_sqr()
        })
        .collect();
    let level = levels(&power, (AROUND / step) as usize, ((SPACING / step) as usize).max(1));
    Spectrum { power, level }
}

/// Neighbours of a sample on the grid, on either side: the error is `e^{−π · 10 · (1 − 1/3)}`, nine digits.
const NEIGHBOURS: usize = 10;

/// `Σ x e^{−2πi k step t}` for `k` from 0 to half the `length`, and for `−k` at `length − k`, as a Fourier transform at even times has them.
///
/// ```text
///   u_m = Σ_j x_j e^{−(φ_j − 2πm/M)²/4s}      φ = 2π step t,  M = 2 length,  s = π · 10/(length² · 2 · 1.5)
///   X_k = √(π/s) e^{k² s}/M · Σ_m u_m e^{−2πi k m/M}
/// ```
/// Each sample is spread over the neighbouring points of a grid twice as fine. Reference: L. Greengard, J.-Y. Lee (2004), Accelerating the
/// nonuniform fast Fourier transform, eq. 8 to 11.
fn transform(times: &[f64], samples: &[Complex<f64>], step: f64, length: usize) -> Vec<Complex<f64>> {
    let fine = 2 * length;
    let s = PI * NEIGHBOURS as f64 / ((length * length) as f64 * 3.0);
    let mut grid = vec![Complex::default(); fine];
    for (t, x) in times.iter().zip(samples) {
        let place = (t * step).rem_euclid(1.0) * fine as f64;
        let nearest = place as usize;
        for m in 0..2 * NEIGHBOURS {
            let point = nearest + fine + m + 1 - NEIGHBOURS;
            let distance = TAU * (place + fine as f64 - point as f64) / fine as f64;
            grid[point % fine] += x * (-distance * distance / (4.0 * s)).exp();
        }
    }
    FftPlanner::new().plan_fft_forward(fine).process(&mut grid);
    let scale = |k: usize| (PI / s).sqrt() * ((k * k) as f64 * s).exp() / fine as f64;
    let mut z = vec![Complex::default(); length];
    for k in 0..length / 2 {
        z[k] = grid[k] * scale(k);
        if k > 0 {
            z[length - k] = grid[fine - k] * scale(k);
        }
    }
    z
}

/// Mean of an exponential distribution with the median of the neighbours.
fn levels(power: &[f64], reach: usize, spacing: usize) -> Vec<f64> {
    let at = |centre: usize| {
        let (from, to) = (centre.saturating_sub(reach), (centre + reach).min(power.len()));
        // Neighbouring bins of a padded transform are nearly equal: a part of them is enough.
        let mut near: Vec<f64> = power[from..to].iter().step_by(4).copied().collect();
        let middle = near.len() / 2;
        (*near.select_nth_unstable_by(middle, f64::total_cmp).1 / std::f64::consts::LN_2).max(1e-300)
    };
    let known: Vec<f64> = (0..power.len()).step_by(spacing).map(at).collect();
    (0..power.len()).map(|k| known[((k + spacing / 2) / spacing).min(known.len() - 1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum at each frequency, term by term.
    #[test]
    fn equivalent_transform_at_uneven_times() {
        let times: Vec<f64> = (0..300).map(|k| 0.01 * (f64::from(k) + 0.4 * (f64::from(k) * 1.7).sin())).collect();
        let samples: Vec<Complex<f64>> =
            times.iter().map(|t| Complex::new((40.0 * t).sin(), (70.0 * t).cos() * t)).collect();
        let (length, step) = (512, 1.0 / (512.0 * 0.01));
        let found = transform(&times, &samples, step, length);
        let size: f64 = samples.iter().map(|x| x.norm()).sum();
        for k in (0..length / 2).step_by(7) {
            for (sign, at) in [(-1.0, k), (1.0, (length - k) % length)] {
                let phase = |t: f64| Complex::from_polar(1.0, sign * TAU * k as f64 * step * t);
                let expected: Complex<f64> = times.iter().zip(&samples).map(|(t, x)| x * phase(*t)).sum();
                // The spreading keeps nine digits of the sum of magnitudes.
                assert!((found[at] - expected).norm() < 1e-8 * size, "{k}: {} for {expected}", found[at]);
            }
        }
    }
}

//! Fourier transforms of samples at even and at uneven times; the only place that names rustfft.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use nalgebra::Complex;
use rustfft::{Fft, FftPlanner};

/// Neighbours of a sample on the grid, on either side: the error is `e^{−π · 10 · (1 − 1/3)}`, nine digits.
const NEIGHBOURS: usize = 10;

/// `Σ_m x_m e^{−2πi k m/n}` of `n` samples, in their place.
pub fn transform(samples: &mut [Complex<f64>]) {
    FftPlanner::new().plan_fft_forward(samples.len()).process(samples);
}

/// The transform of samples at the same uneven times, prepared for several signals.
///
/// ```text
///   u_m = Σ_j x_j e^{−(φ_j − 2πm/M)²/4s}      φ = 2π step t,  M = 2 length,  s = π · 10/(length² · 2 · 1.5)
///   X_k = √(π/s) e^{k² s}/M · Σ_m u_m e^{−2πi k m/M}
/// ```
/// Each sample is spread over the neighbouring points of a grid twice as fine. Reference: L. Greengard, J.-Y. Lee (2004), Accelerating the
/// nonuniform fast Fourier transform, eq. 8 to 11.
pub struct Uneven {
    length: usize,
    /// `s`.
    spread: f64,
    /// Place of each sample on the grid.
    places: Vec<f64>,
    fft: Arc<dyn Fft<f64>>,
}

impl Uneven {
    /// For samples at these `times` [s]: frequencies `k step` [Hz], and `length` of them.
    pub fn new(times: &[f64], step: f64, length: usize) -> Self {
        let fine = 2 * length;
        let spread = PI * NEIGHBOURS as f64 / ((length * length) as f64 * 3.0);
        let places = times.iter().map(|t| (t * step).rem_euclid(1.0) * fine as f64).collect();
        Self { length, spread, places, fft: FftPlanner::new().plan_fft_forward(fine) }
    }

    /// `Σ x e^{−2πi k step t}` for `k` from 0 to half the length, and for `−k` at `length − k`, as [`transform`] has them; one sample for each time.
    pub fn transform(&self, samples: impl IntoIterator<Item = Complex<f64>>) -> Vec<Complex<f64>> {
        let Self { length, spread, .. } = *self;
        let fine = 2 * length;
        let mut grid = vec![Complex::default(); fine];
        for (place, x) in self.places.iter().zip(samples) {
            let first = *place as usize + fine + 1 - NEIGHBOURS;
            for point in first..first + 2 * NEIGHBOURS {
                let distance = TAU * (place + fine as f64 - point as f64) / fine as f64;
                grid[point % fine] += x * (-distance * distance / (4.0 * spread)).exp();
            }
        }
        self.fft.process(&mut grid);
        let scale = |k: usize| (PI / spread).sqrt() * ((k * k) as f64 * spread).exp() / fine as f64;
        let mut z = vec![Complex::default(); length];
        for k in 0..length / 2 {
            z[k] = grid[k] * scale(k);
            if k > 0 {
                z[length - k] = grid[fine - k] * scale(k);
            }
        }
        z
    }
}

/// Transforms `A` and `B` of two real signals at frequency `k`, from the transform of `a + ib`.
pub fn of_pair(z: &[Complex<f64>], k: usize) -> [Complex<f64>; 2] {
    let (one, other) = (z[k], z[(z.len() - k) % z.len()].conj());
    [(one + other) * 0.5, (one - other) * Complex::new(0.0, -0.5)]
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
        let found = Uneven::new(&times, step, length).transform(samples.iter().copied());
        let size: f64 = samples.iter().map(|x| x.norm()).sum();
        let sum = |of: &dyn Fn(&Complex<f64>) -> Complex<f64>, turns: f64| -> Complex<f64> {
            times.iter().zip(&samples).map(|(t, x)| of(x) * Complex::from_polar(1.0, TAU * turns * step * t)).sum()
        };
        // The spreading keeps nine digits of the sum of magnitudes.
        let close = |found: Complex<f64>, expected: Complex<f64>| (found - expected).norm() < 1e-8 * size;
        for k in (0..length / 2).step_by(7) {
            for (sign, at) in [(-1.0, k), (1.0, (length - k) % length)] {
                assert!(close(found[at], sum(&|x| *x, sign * k as f64)), "{k}: {}", found[at]);
            }
            let [real, imaginary] = of_pair(&found, k);
            assert!(close(real, sum(&|x| x.re.into(), -(k as f64))), "{k}: {real}");
            assert!(close(imaginary, sum(&|x| x.im.into(), -(k as f64))), "{k}: {imaginary}");
        }
    }
}

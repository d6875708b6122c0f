//! The smoothing kernel on samples at uneven times: weights of a local polynomial in true time.
//!
//! Each sample stands for a cell, which reaches half way to its neighbours. With `s = (t − t_c)/w`, the kernel `K` and a cell from `l` to `r`,
//!
//! ```text
//!   value  ∫ K = C(r) − C(l)        w · rate  −(K(r) − K(l))        w² · curvature  K'(r) − K'(l)
//! ```
//! are the averages of a signal that is constant within each cell. To each is added `g p(s)`, with the weight `g` of the value and a cubic `p`,
//! the least change (Σ Δ²/g) that makes the averages of `1, s, s², s³` those of the kernel:
//!
//! ```text
//!            1   s   s²   s³
//!   value    1   0   1/7  0
//!   rate     0   1   0    3/7
//!   curv.    0   0   2    0
//! ```
//! Rate and curvature of a parabola are then exact, and the gain for an oscillation is that of the kernel up to fourth order in `ω w`.
//! References: A. Savitzky, M. J. E. Golay (1964); J. Fan, I. Gijbels (1996), Local Polynomial Modelling and Its Applications, ch. 3 (weights
//! of uneven designs).

use std::ops::Range;

use nalgebra::{Matrix4, Matrix4x3};

use super::kernel::{Averages, density, density_slope, share_before};

/// Averages of `1, s, s², s³` for value, `w` times rate, and `w²` times curvature.
const MOMENTS: [[f64; 4]; 3] = [[1.0, 0.0, 1.0 / 7.0, 0.0], [0.0, 1.0, 0.0, 3.0 / 7.0], [0.0, 0.0, 2.0, 0.0]];

/// Least number of samples before and after the centre: with its own, seven for the four moments.
pub const LEAST: usize = 3;

/// Weights of the samples around a time.
#[derive(Debug, Clone)]
pub struct LocalWeights {
    first: usize,
    /// Sample that is subtracted first, so that a large constant costs no precision.
    origin: usize,
    /// `w` [s]
    pub half_width: f64,
    /// Value, rate and curvature of each sample.
    weights: Vec<[f64; 3]>,
}

impl LocalWeights {
    /// For the half width `w` [s] around `t` [s], from rising times that hold at least [`LEAST`] samples before and after `t`. Where the
    /// kernel covers fewer, it is wider.
    pub fn new(time: &[f64], t: f64, w: f64) -> Self {
        let next = time.partition_point(|sample| *sample < t);
        let from = time.partition_point(|sample| *sample <= t - w).min(next.saturating_sub(LEAST));
        let to = time.partition_point(|sample| *sample < t + w).max((next + LEAST + 1).min(time.len()));
        let inside = &time[from..to];
        // The outermost sample of a wider kernel lies half a step within it.
        let reach = |at: usize, neighbour: usize| (time[at] - t).abs() + 0.5 * (time[at] - time[neighbour]).abs();
        let wide = (t - time[from] >= w).then(|| reach(from, from + 1));
        let wide_after = (time[to - 1] - t >= w).then(|| reach(to - 1, to - 2));
        let w = w.max(wide.unwrap_or(0.0)).max(wide_after.unwrap_or(0.0));
        let mut weights = of_cells(inside, t, w);
        correct(&mut weights, inside, t, w);
        weights.iter_mut().for_each(|[_, rate, curvature]| (*rate, *curvature) = (*rate / w, *curvature / (w * w)));
        Self { first: from, origin: next.min(time.len() - 1), half_width: w, weights }
    }

    /// For a signal that has `by` more samples before the first time.
    pub fn shift(&mut self, by: usize) {
        self.first += by;
        self.origin += by;
    }

    /// The samples that have a weight.
    pub fn samples(&self) -> Range<usize> {
        self.first..self.first + self.weights.len()
    }

    /// Averages of a signal with one value per time.
    pub fn averages(&self, signal: &[f64]) -> Averages {
        let origin = signal[self.origin];
        let mut averages = Averages::default();
        for (sample, [value, rate, curvature]) in signal[self.first..].iter().zip(&self.weights) {
            let x = sample - origin;
            averages.value += value * x;
            averages.rate += rate * x;
            averages.curvature += curvature * x;
        }
        averages.value += origin;
        averages
    }
}

/// The averages of a signal that is constant within each cell; the outermost cells reach to the ends of the kernel.
fn of_cells(time: &[f64], t: f64, w: f64) -> Vec<[f64; 3]> {
    let up_to = |s: f64| [share_before(s), -density(s), density_slope(s)];
    let middles = time.windows(2).map(|pair| ((0.5 * (pair[0] + pair[1]) - t) / w).clamp(-1.0, 1.0));
    let mut left = up_to(-1.0);
    let of_cell = |border: f64| {
        let right = up_to(border);
        let cell = std::array::from_fn(|kind| right[kind] - left[kind]);
        left = right;
        cell
    };
    middles.chain([1.0]).map(of_cell).collect()
}

/// Adds the least change that gives the kernel's moments.
fn correct(weights: &mut [[f64; 3]], time: &[f64], t: f64, w: f64) {
    // `Σ g s^n` up to twice the degree of the cubic, and up to its degree of the rate and the curvature.
    let (mut of_value, mut of_others) = ([0.0; 7], [[0.0; 4]; 2]);
    for ([g, rate, curvature], sample) in weights.iter().zip(time) {
        let s = (sample - t) / w;
        let mut power = 1.0;
        for n in 0..of_value.len() {
            of_value[n] += g * power;
            if n < 4 {
                of_others[0][n] += rate * power;
                of_others[1][n] += curvature * power;
            }
            power *= s;
        }
    }
    let gram = Matrix4::from_fn(|i, j| of_value[i + j]);
    let lacking = Matrix4x3::from_fn(|n, kind| {
        let sum = if kind == 0 { of_value[n] } else { of_others[kind - 1][n] };
        MOMENTS[kind][n] - sum
    });
    let Some(p) = gram.lu().solve(&lacking) else { return };
    for (weight, sample) in weights.iter_mut().zip(time) {
        let (g, s) = (weight[0], (sample - t) / w);
        for (kind, weight) in weight.iter_mut().enumerate() {
            *weight += g * (p[(0, kind)] + s * (p[(1, kind)] + s * (p[(2, kind)] + s * p[(3, kind)])));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps from 10 to 13 ms, rounded to a millisecond as in recordings of a robot controller at about 95 Hz.
    fn uneven(count: usize) -> Vec<f64> {
        let mut time = vec![0.0];
        for k in 1..count {
            let step = [0.010, 0.010, 0.012, 0.010, 0.011, 0.013, 0.010][(k * k + k / 3) % 7];
            time.push(time[k - 1] + step);
        }
        time
    }

    /// A cubic is averaged as the kernel averages it: rate and curvature of the parabola in it are its own.
    #[test]
    fn closed_form_a_cubic_at_uneven_times_is_averaged_as_by_the_kernel() {
        let time = uneven(60);
        for (t, w) in [(time[30], 0.08), (time[30] + 0.004, 0.035), (time[30], 0.2)] {
            let local = LocalWeights::new(&time, t, w);
            let [a, b, c, d] = [1e4, -3.0, 5.0, -7.0];
            let signal: Vec<f64> =
                time.iter().map(|x| x - t).map(|x| a + b * x + 0.5 * c * x * x + d * x.powi(3) / 6.0).collect();
            let averages = local.averages(&signal);
            let w = local.half_width;
            // Rounding: 1e4 has 2e-12; the weights of the curvature sum to 20/w² in magnitude.
            assert!((averages.value - (a + c * w * w / 14.0)).abs() < 1e-11, "{averages:?}");
            assert!((averages.rate - (b + d * w * w / 14.0)).abs() < 1e-11 * 20.0 / w, "{averages:?}");
            assert!((averages.curvature - c).abs() < 1e-11 * 20.0 / (w * w), "{averages:?}");
        }
    }

    /// Weights and kernel agree on polynomials up to degree 3. By Taylor's theorem they differ on `A sin(ω t + φ)` by no more than
    /// `A ω⁴/24 · (Σ |weight| |t|⁴ + ∫ |K^(n)| |t|⁴)`.
    #[test]
    fn analytic_a_sine_at_uneven_times_is_averaged_as_by_the_kernel() {
        use crate::effects::kernel_gain;
        let time = uneven(80);
        let (t, w, omega, phase) = (time[40], 0.06, 9.0, 0.7);
        let local = LocalWeights::new(&time, t, w);
        let signal: Vec<f64> = time.iter().map(|x| (omega * (x - t) + phase).sin()).collect();
        let gain = kernel_gain(omega * w);
        let expected = [gain * phase.sin(), gain * omega * phase.cos(), -gain * omega * omega * phase.sin()];
        let found = local.averages(&signal);
        let fourth = |kind: usize| -> f64 {
            let samples = time[local.first..].iter().zip(&local.weights);
            samples.map(|(x, weight)| weight[kind].abs() * (x - t).powi(4)).sum()
        };
        // ∫ |K| s⁴ = 1/21, ∫ |K'| s⁴ = 15/2 (1/6 − 1/8) = 5/16, and ∫ |K''| s⁴ ≤ ∫ 15/4 (3 s² + 1) s⁴ < 5.
        let of_kernel = [w.powi(4) / 21.0, 0.3125 * w.powi(3), 5.0 * w * w];
        let found = [found.value, found.rate, found.curvature];
        for kind in 0..3 {
            let bound = omega.powi(4) / 24.0 * (fourth(kind) + of_kernel[kind]);
            let error = (found[kind] - expected[kind]).abs();
            println!("{kind}: {} ± {bound:.1e}, off by {error:.1e}", found[kind]);
            assert!(error <= bound, "{kind}: {error} > {bound}");
            // The bound decides something: it is a few per cent of the amplitude at most.
            assert!(bound < 0.12 * [1.0, omega, omega * omega][kind], "{kind}: {bound}");
        }
    }

    #[test]
    fn property_a_kernel_with_too_few_samples_is_wider() {
        let time = uneven(20);
        let local = LocalWeights::new(&time, time[10], 0.006);
        assert_eq!(local.weights.len(), 2 * LEAST + 1);
        assert!(local.half_width > time[10] - time[7] && local.half_width < time[10] - time[6], "{local:?}");
    }
}

//! The covariance of the state: carried along the motion, and reduced by readings.
//!
//! ```text
//!   P ← F P Fᵀ + Σ σ² g gᵀ              g: response of the state to a torque of standard deviation σ [N·m or N]
//!   K = P_:θ/s²,   P ← P − K Kᵀ s² (1 − V*/s²)
//! ```
//! Reference: S. Särkkä, L. Svensson (2023), Bayesian filtering and smoothing, algorithm 7.4 (linearised) and 8.12 (points).

use super::points::Points;
use crate::plant::tangent::Tangent;

/// A covariance `P` of `size` states, row by row: four for the motion of each joint, then the torque that the model misses on each.
#[derive(Debug, Clone)]
pub(super) struct Covariance {
    size: usize,
    p: Vec<f64>,
    product: Vec<f64>,
    /// `F` of the last interval, row by row.
    pub transition: Vec<f64>,
    /// `K` of the last update.
    pub gain: Vec<f64>,
}

impl Covariance {
    /// Of states that are independent, with these standard deviations.
    pub fn diagonal(deviations: &[f64]) -> Self {
        let size = deviations.len();
        let mut p = vec![0.0; size * size];
        deviations.iter().enumerate().for_each(|(k, deviation)| p[k * size + k] = deviation * deviation);
        Self { size, product: p.clone(), transition: p.clone(), p, gain: vec![0.0; size] }
    }

    /// `P_ii`.
    pub fn variance(&self, state: usize) -> f64 {
        self.p[state * self.size + state]
    }

    /// `√P_ii`.
    pub fn deviation(&self, state: usize) -> f64 {
        self.variance(state).max(0.0).sqrt()
    }

    /// Deviation of the difference of two states.
    pub fn deviation_between(&self, a: usize, b: usize) -> f64 {
        (self.variance(a) + self.variance(b) - 2.0 * self.p[a * self.size + b]).max(0.0).sqrt()
    }

    /// Points of it.
    pub fn factor(&self, points: &mut Points) {
        points.factor(&self.p);
    }

    /// Takes `F` over an interval from the derivative of the motion, while the torques that are missed keep the share `kept`.
    pub fn pass(&mut self, tangent: &Tangent, kept: f64) {
        let size = self.size;
        self.transition.fill(0.0);
        for (row, out) in self.transition.chunks_exact_mut(size).enumerate() {
            if row < size / 5 * 4 {
                out.copy_from_slice(tangent.response(row));
            } else {
                out[row] = kept;
            }
        }
    }

    /// Carries it over an interval by `F`.
    pub fn carry(&mut self) {
        let Self { size, p, product, transition, .. } = self;
        let size = *size;
        for (out, transition) in product.chunks_exact_mut(size).zip(transition.chunks_exact(size)) {
            out.fill(0.0);
            for (f, p) in transition.iter().zip(p.chunks_exact(size)) {
                if *f != 0.0 {
                    out.iter_mut().zip(p).for_each(|(out, p)| *out += f * p);
                }
            }
        }
        for row in 0..size {
            for column in 0..=row {
                let (a, f) = (&product[row * size..(row + 1) * size], &transition[column * size..(column + 1) * size]);
                let sum: f64 = a.iter().zip(f).map(|(a, f)| a * f).sum();
                p[row * size + column] = sum;
                p[column * size + row] = sum;
            }
        }
    }

    /// Carries it over an interval by its points, which have moved; writes the mean.
    pub fn collect(&mut self, points: &Points, mean: &mut [f64]) {
        points.collect(mean, &mut self.p, &mut self.transition);
    }

    /// Adds white noise of the torques on rotors and links over an interval: standard deviations [N·m or N] of their means, one pair per joint.
    pub fn add_noise(&mut self, tangent: &Tangent, noise: &[[f64; 2]]) {
        for row in 0..self.size / 5 * 4 {
            for column in 0..=row {
                let of_rotors = tangent.of_rotors(row).iter().zip(tangent.of_rotors(column));
                let of_links = tangent.of_links(row).iter().zip(tangent.of_links(column));
                let mut sum = 0.0;
                for (((a, b), (c, d)), [rotor, link]) in of_rotors.zip(of_links).zip(noise) {
                    sum += a * b * rotor * rotor + c * d * link * link;
                }
                self.p[row * self.size + column] += sum;
                if column < row {
                    self.p[column * self.size + row] += sum;
                }
            }
        }
    }

    /// Takes a reading of one state into account, whose variance with the sensor's is `s²` and falls to the share `V*/s²`; the gain `K` is kept.
    pub fn update(&mut self, state: usize, variance: f64, share: f64) {
        let Self { size, p, gain, .. } = self;
        let size = *size;
        gain.iter_mut().enumerate().for_each(|(row, gain)| *gain = p[row * size + state] / variance);
        let fall = variance * (1.0 - share);
        for row in 0..size {
            let factor = fall * gain[row];
            p[row * size..(row + 1) * size].iter_mut().zip(gain.iter()).for_each(|(p, gain)| *p -= factor * gain);
        }
    }

    /// Adds the variance `deviation²` to these states together, fully correlated.
    pub fn widen(&mut self, states: &[usize], deviation: f64) {
        for a in states {
            for b in states {
                self.p[a * self.size + b] += deviation * deviation;
            }
        }
    }
}

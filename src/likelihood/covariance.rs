//! The covariance of the state: carried along the motion, and reduced by readings.
//!
//! ```text
//!   P ← F P Fᵀ + Σ σ² g gᵀ              g: response of the state to a torque of standard deviation σ [N·m or N]
//!   K = P_:θ/s²,   P ← P − K Kᵀ s² (1 − V*/s²)
//! ```
//! Reference: S. Särkkä, L. Svensson (2023), Bayesian filtering and smoothing, algorithm 7.4.

use crate::plant::tangent::Tangent;

/// A covariance `P` of `size` states, row by row.
#[derive(Debug, Clone)]
pub(super) struct Covariance {
    size: usize,
    p: Vec<f64>,
    product: Vec<f64>,
    /// `K` of the last update.
    pub gain: Vec<f64>,
}

impl Covariance {
    /// Of states that are independent, with these standard deviations.
    pub fn diagonal(deviations: &[f64]) -> Self {
        let size = deviations.len();
        let mut p = vec![0.0; size * size];
        deviations.iter().enumerate().for_each(|(k, deviation)| p[k * size + k] = deviation * deviation);
        Self { size, product: p.clone(), p, gain: vec![0.0; size] }
    }

    /// `P_ii`.
    pub fn variance(&self, state: usize) -> f64 {
        self.p[state * self.size + state]
    }

    /// Carries it over an interval, with white noise of the torques on rotors and links: standard deviations [N·m or N] of their mean over the
    /// interval, one pair per joint.
    pub fn predict(&mut self, tangent: &Tangent, noise: &[[f64; 2]]) {
        let Self { size, p, product, .. } = self;
        let size = *size;
        for row in 0..size {
            let out = &mut product[row * size..(row + 1) * size];
            out.fill(0.0);
            for (f, p) in tangent.transition(row).iter().zip(p.chunks_exact(size)) {
                if *f != 0.0 {
                    out.iter_mut().zip(p).for_each(|(out, p)| *out += f * p);
                }
            }
        }
        for row in 0..size {
            for column in 0..=row {
                let (a, f) = (&product[row * size..(row + 1) * size], tangent.transition(column));
                let mut sum: f64 = a.iter().zip(f).map(|(a, f)| a * f).sum();
                let responses = tangent.of_rotors(row).iter().zip(tangent.of_rotors(column));
                let of_links = tangent.of_links(row).iter().zip(tangent.of_links(column));
                for (((a, b), (c, d)), [rotor, link]) in responses.zip(of_links).zip(noise) {
                    sum += a * b * rotor * rotor + c * d * link * link;
                }
                p[row * size + column] = sum;
                p[column * size + row] = sum;
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

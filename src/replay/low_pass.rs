//! Low-pass without phase shift: a second-order Butterworth filter, run forwards and then backwards.
//!
//! ```text
//!   H(z) = b (1 + z⁻¹)² / (1 + a₁ z⁻¹ + a₂ z⁻²)      c = 1/tan(π f_c T),  b = 1/(1 + √2 c + c²)
//!                                                   a₁ = 2 (1 − c²) b,  a₂ = (1 − √2 c + c²) b
//! ```
//! Both runs together have gain `1/(1 + (tan(π f T)/tan(π f_c T))⁴)`: one half at `f_c`.
//! The signal is extended at both ends by point reflection, over two periods of `f_c`. Left out: uneven sampling.
//! Reference: F. Gustafsson (1996), Determining the initial states in forward-backward filtering.

use std::f64::consts::{PI, SQRT_2};

/// Largest cut-off as a share of the sampling rate.
const MAX_SHARE: f64 = 0.45;

/// Filters samples of interval `interval` [s] with the cut-off `cutoff` [Hz].
pub fn low_pass(samples: &[f64], interval: f64, cutoff: f64) -> Vec<f64> {
    if samples.len() < 3 || interval <= 0.0 {
        return samples.to_vec();
    }
    let c = 1.0 / (PI * (cutoff * interval).min(MAX_SHARE)).tan();
    let b = 1.0 / (1.0 + SQRT_2 * c + c * c);
    let (a1, a2) = (2.0 * (1.0 - c * c) * b, (1.0 - SQRT_2 * c + c * c) * b);

    let wanted = (2.0 / (cutoff * interval)).ceil() as usize;
    let margin = wanted.min(samples.len() - 1);
    let last = samples.len() - 1;
    let before = (1..=margin).rev().map(|i| 2.0 * samples[0] - samples[i]);
    let after = (1..=margin).map(|i| 2.0 * samples[last] - samples[last - i]);
    let mut x: Vec<f64> = before.chain(samples.iter().copied()).chain(after).collect();
    for _ in 0..2 {
        run(&mut x, b, a1, a2);
        x.reverse();
    }
    x[margin..margin + samples.len()].to_vec()
}

/// One run, started as if the first sample had lasted for ever.
fn run(x: &mut [f64], b: f64, a1: f64, a2: f64) {
    let (mut x1, mut x2, mut y1, mut y2) = (x[0], x[0], x[0], x[0]);
    for sample in x {
        let y = b * (*sample + 2.0 * x1 + x2) - a1 * y1 - a2 * y2;
        (x2, x1, y2, y1) = (x1, *sample, y1, y);
        *sample = y;
    }
}

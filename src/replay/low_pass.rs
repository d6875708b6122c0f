//! Low-pass without phase shift: a second-order Butterworth filter, run forwards and then backwards.
//!
//! ```text
//!   H(z) = b (1 + z⁻¹)² / (1 + a₁ z⁻¹ + a₂ z⁻²)      c = 1/tan(π f_c T),  b = 1/(1 + √2 c + c²)
//!                                                   a₁ = 2 (1 − c²) b,  a₂ = (1 − √2 c + c²) b
//! ```
//! Both runs together have gain `1/(1 + (tan(π f T)/tan(π f_c T))⁴)`: one half at `f_c`.
//! At uneven times, the same filter in continuous time is solved exactly along straight lines between the samples; its gain is
//! `1/(1 + (f/f_c)⁴)`:
//!
//! ```text
//!   y = Im z,  ż = p z + √2 ω_c u,  p = ω_c (−1 + j)/√2        ω_c = 2π f_c
//! ```
//! The signal is extended at both ends by point reflection, over two periods of `f_c`.
//! Reference: F. Gustafsson (1996), Determining the initial states in forward-backward filtering.

use std::f64::consts::{PI, SQRT_2};

use nalgebra::Complex;

use crate::timeseries::Clock;

/// Largest cut-off as a share of the sampling rate.
const MAX_SHARE: f64 = 0.45;

/// Filters samples taken at these times with the cut-off `cutoff` [Hz].
pub fn low_pass(samples: &[f64], clock: &Clock, cutoff: f64) -> Vec<f64> {
    let interval = clock.interval;
    if samples.len() < 3 || interval <= 0.0 {
        return samples.to_vec();
    }
    if !clock.even {
        return at_uneven_times(samples, clock, cutoff);
    }
    let c = 1.0 / (PI * (cutoff * interval).min(MAX_SHARE)).tan();
    let b = 1.0 / (1.0 + SQRT_2 * c + c * c);
    let (a1, a2) = (2.0 * (1.0 - c * c) * b, (1.0 - SQRT_2 * c + c * c) * b);

    let wanted = (2.0 / (cutoff * interval)).ceil() as usize;
    let margin = wanted.min(samples.len() - 1);
    let mut x = extended(samples, margin, margin);
    for _ in 0..2 {
        run(&mut x, b, a1, a2);
        x.reverse();
    }
    x[margin..margin + samples.len()].to_vec()
}

/// Samples extended at both ends by the point reflection of so many samples.
fn extended(samples: &[f64], before: usize, after: usize) -> Vec<f64> {
    let last = samples.len() - 1;
    let first = (1..=before).rev().map(|i| 2.0 * samples[0] - samples[i]);
    let end = (1..=after).map(|i| 2.0 * samples[last] - samples[last - i]);
    first.chain(samples.iter().copied()).chain(end).collect()
}

/// The filter in continuous time, forwards and then backwards.
fn at_uneven_times(samples: &[f64], clock: &Clock, cutoff: f64) -> Vec<f64> {
    let last = samples.len() - 1;
    let span = 2.0 / cutoff;
    let (before, after) = (clock.after(0, span).min(last), last - clock.before(last, span));
    let time = extended(clock.time(), before, after);
    let mut x = extended(samples, before, after);
    let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // As at even times, the cut-off stays below half the sampling rate.
    let omega = 2.0 * PI * cutoff.min(MAX_SHARE / clock.interval);
    for _ in 0..2 {
        run_in_time(&mut x, &steps, omega);
        x.reverse();
        steps.reverse();
    }
    x[before..before + samples.len()].to_vec()
}

/// One run over samples whose distances [s] are `steps`, started as if the first sample had lasted for ever.
fn run_in_time(x: &mut [f64], steps: &[f64], omega: f64) {
    let gain = SQRT_2 * omega;
    let p = Complex::new(-1.0, 1.0) * (omega / SQRT_2);
    let mut z = -Complex::from(gain * x[0]) / p;
    let mut from = x[0];
    for (sample, step) in x[1..].iter_mut().zip(steps) {
        let [full, of_level, of_slope] = exponentials(p * *step);
        let (to, way) = (*sample, *sample - from);
        z = full * z + (of_level * from + of_slope * way) * (gain * step);
        *sample = z.im;
        from = to;
    }
}

/// `e^x`, `∫₀¹ e^(x (1 − s)) ds` and `∫₀¹ s e^(x (1 − s)) ds`.
fn exponentials(x: Complex<f64>) -> [Complex<f64>; 3] {
    let full = x.exp();
    if x.norm() < 1e-3 {
        // The next terms are x³/24 and x³/120, below 1e-10.
        return [full, x * x / 6.0 + x / 2.0 + 1.0, x * x / 24.0 + x / 6.0 + 0.5];
    }
    [full, (full - 1.0) / x, (full - 1.0 - x) / (x * x)]
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

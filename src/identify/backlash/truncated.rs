//! Moments of a normal variable that is known to lie in an interval.
//!
//! For `z ~ N(0, 1)` and `a ≤ z < b`, with `Z = Φ(b) − Φ(a)` and the density `φ`,
//!
//! ```text
//!   E z = d = (φ(a) − φ(b))/Z        Var z = 1 − k,   k = d² − (a φ(a) − b φ(b))/Z
//! ```
//! Reference: N. L. Johnson, S. Kotz, N. Balakrishnan (1994), Continuous Univariate Distributions 1, section 10.1.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Beyond this many standard deviations an interval's end is as good as infinite, or a tail is its asymptote.
const FAR: f64 = 6.0;

/// What an interval says of a standard normal variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Truncated {
    /// `ln Z`.
    pub log_mass: f64,
    /// `d`, the mean.
    pub mean: f64,
    /// `k`, by how much the variance falls below one, 0 to 1.
    pub reduction: f64,
}

impl Truncated {
    /// A standard normal variable in `[a, b)`, `a < b`.
    pub fn new(a: f64, b: f64) -> Self {
        if a < -FAR && b > FAR {
            return Self { log_mass: 0.0, mean: 0.0, reduction: 0.0 };
        }
        if a > FAR {
            // Mills' ratio: Z ≈ φ(a)/a.
            let log_mass = -0.5 * a * a - (a * (2.0 * PI).sqrt()).ln();
            return Self { log_mass, mean: a + 1.0 / a, reduction: 1.0 - 1.0 / (a * a) };
        }
        if b < -FAR || (b < 0.0 && a < 0.0) {
            let mirrored = Self::new(-b, -a);
            return Self { mean: -mirrored.mean, ..mirrored };
        }
        let mass = if a > 0.0 { upper_tail(a) - upper_tail(b) } else { 1.0 - upper_tail(b) - upper_tail(-a) };
        let (pa, pb) = (density(a), density(b));
        let mean = (pa - pb) / mass;
        Self { log_mass: mass.ln(), mean, reduction: mean * mean - (a * pa - b * pb) / mass }
    }
}

/// `φ(x)`.
fn density(x: f64) -> f64 {
    (-0.5 * x * x).exp() / (2.0 * PI).sqrt()
}

/// `1 − Φ(x)`.
fn upper_tail(x: f64) -> f64 {
    0.5 * erfc(x * FRAC_1_SQRT_2)
}

/// Complementary error function, relative error below 1.2e-7 everywhere (W. H. Press et al., Numerical Recipes, section 6.2).
fn erfc(x: f64) -> f64 {
    const SERIES: [f64; 10] = [
        -1.265_512_23,
        1.000_023_68,
        0.374_091_96,
        0.096_784_18,
        -0.186_288_06,
        0.278_868_07,
        -1.135_203_98,
        1.488_515_87,
        -0.822_152_23,
        0.170_872_77,
    ];
    let t = 1.0 / (1.0 + 0.5 * x.abs());
    let sum = SERIES.iter().rev().fold(0.0, |sum, c| sum * t + c);
    let tail = t * (sum - x * x).exp();
    if x >= 0.0 { tail } else { 2.0 - tail }
}

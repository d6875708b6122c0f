//! Moments of a normal variable that is known to lie in an interval.
//!
//! For `z ~ N(0, 1)` and `a ≤ z < b`, with `Z = Φ(b) − Φ(a)` and the density `φ`,
//!
//! ```text
//!   E z = d = (φ(a) − φ(b))/Z        Var z = 1 − k,   k = d² − (a φ(a) − b φ(b))/Z
//! ```
//! Reference: N. L. Johnson, S. Kotz, N. Balakrishnan (1994), Continuous Univariate Distributions 1, section 10.1.

use std::f64::consts::PI;

use crate::distributions::normal_upper_tail as upper_tail;

/// Beyond this many standard deviations an interval's end counts as infinite, and a tail is replaced by its asymptote.
const FAR: f64 = 6.0;

/// Moments of a standard normal variable that lies in an interval.
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

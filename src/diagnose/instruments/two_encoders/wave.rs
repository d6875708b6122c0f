//! A gap `b + c cos nq + s sin nq` seen by two encoders: amplitude `a = √(c² + s²)`, phase `φ = atan2(−s, c)`, and their errors.
//!
//! ```text
//!   y = … + ½ side (b + c cos nq + s sin nq)        ∂y/∂n = ½ side q (s cos nq − c sin nq)
//! ```
//! The errors are those of `c`, `s` and `n` together: `∂y/∂n` is a further column when they are computed.

use nalgebra::{Matrix2, Vector2};

use super::difference::Difference;
use super::flanks::flanks;
use super::solved::Regression;
use crate::diagnose::fit::problem::Problem;
use crate::timeseries::Estimate;

/// A gap `b + a cos(n q + φ)`.
#[derive(Debug, Clone, Copy)]
pub struct Wave {
    /// `a` [rad or m].
    pub amplitude: Estimate,
    /// `n` [1/turn].
    pub order: Estimate,
    /// `φ` [rad].
    pub phase: Estimate,
}

/// `½ side cos nq` and `½ side sin nq`: columns of a gap of order `n` in the difference of the encoders.
pub fn wave(rows: &Difference, side: &[f64], order: f64) -> [Vec<f64>; 2] {
    let of = |f: fn(f64) -> f64| rows.q.iter().zip(side).map(|(q, side)| 0.5 * side * f(order * q)).collect();
    [of(f64::cos), of(f64::sin)]
}

impl Wave {
    /// The wave of order `n` with its two coefficients at position `at`; `unknown` [rad or m] is the uncertain wind-up by friction whose share
    /// behind the gear is unknown.
    pub fn of(problem: &Problem, fit: &Regression, n: f64, at: usize, unknown: f64) -> Self {
        let Regression { rows, columns, solved } = fit;
        let k = Vector2::new(solved.coefficients[at], solved.coefficients[at + 1]);
        let [cos, sin] = [&columns[at], &columns[at + 1]];
        let slope = rows.q.iter().zip(cos.iter().zip(sin)).map(|(q, (cos, sin))| q * (k.y * cos - k.x * sin)).collect();
        let covariance = fit.covariance(problem, &[slope]);
        // Each change of flank shows the gap once, as the difference of two errors: the robust error, without floating rows, and the
        // uncertain part of friction. The mean square of a cosine is a half.
        let changes = flanks(&rows.side(0.0)).0.max(1);
        let of_changes = 4.0 / changes as f64 * (solved.scale.powi(2) + unknown.powi(2));
        let v: Matrix2<f64> = covariance.fixed_view::<2, 2>(at, at) + of_changes * Matrix2::identity();
        let a = k.norm().max(1e-300);
        let error = |direction: Vector2<f64>| direction.dot(&(v * direction)).max(0.0).sqrt();
        // An error of the phase divided by the angle from the middle of the motion is an error of the order.
        let mean = |of: &dyn Fn(&f64) -> f64| rows.q.iter().map(of).sum::<f64>() / rows.q.len() as f64;
        let middle = mean(&|q| *q);
        let spread = mean(&|q| (q - middle).powi(2)).max(1e-300);
        let last = columns.len();
        let of_order = covariance[(last, last)].max(0.0) + of_changes / (a * a * spread);
        Self {
            amplitude: Estimate { value: a, std_error: error(k / a) },
            order: Estimate { value: n, std_error: of_order.sqrt() },
            phase: Estimate { value: (-k.y).atan2(k.x), std_error: error(Vector2::new(-k.y, k.x) / a) / a },
        }
    }
}

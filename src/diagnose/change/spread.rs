//! Natural variation of a quantity: its spread between sessions of the healthy machine.
//!
//! The quantity is fitted separately in one session after the other; `d_s` is its difference from all other sessions, with the variance `σ_s²`.
//! The scatter beyond these errors is `τ² = (Q − (n − 1))/(Σw − Σw²/Σw)`, `w = 1/σ_s²`, `Q = Σ w (d_s − d̄)²`. It is zero if `Q` is within
//! twice its own scatter, `√(2 (n − 1))`, of its expectation. A change between `n` sessions and `m` has the variance `τ² (1/n + 1/m)` in addition.
//! Reference: R. DerSimonian, N. Laird (1986), Meta-analysis in clinical trials.

use crate::diagnose::fit::cause::Cause;
use std::ops::Range;

use super::robust::Estimates;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::term::Term;

/// Sessions count if their standard error is at most this multiple of the smallest one. A slow staircase determines an inertia poorly: its
/// result depends mainly on errors of the friction law.
const AS_TELLING: f64 = 3.0;

/// `τ²` of the first coefficient of an effect on its joints; 0 where only one session determines it.
pub fn between_sessions(
    problem: &Problem,
    terms: &[&Term],
    effect: Cause,
    joints: &[usize],
    shape: &[f64],
    sessions: Range<usize>,
) -> f64 {
    if sessions.len() < 2 {
        return 0.0;
    }
    let deviation = |session: usize| {
        let own = Term::new(&problem.motion, Cause::change(effect, session..session + 1), joints, shape.to_vec());
        let mut with = terms.to_vec();
        with.push(&own);
        let estimates = Estimates::new(problem, &with)?;
        let at = *estimates.fitted.term_at.last()?;
        let std_error = estimates.std_error(&[(at, 1.0)]);
        let known = std_error.is_finite() && std_error > 0.0;
        known.then(|| (estimates.fitted.solution.coefficients[at], std_error))
    };
    let mut found: Vec<(f64, f64)> = sessions.filter_map(deviation).collect();
    let least = found.iter().map(|(_, s)| *s).fold(f64::INFINITY, f64::min);
    found.retain(|(_, s)| *s <= AS_TELLING * least);
    excess(&found)
}

/// Variance beyond the errors, from pairs of deviation and standard error.
fn excess(found: &[(f64, f64)]) -> f64 {
    let weights: Vec<f64> = found.iter().map(|(_, s)| 1.0 / (s * s)).collect();
    let sum: f64 = weights.iter().sum();
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    let mean = found.iter().zip(&weights).map(|((d, _), w)| w * d).sum::<f64>() / sum;
    let q: f64 = found.iter().zip(&weights).map(|((d, _), w)| w * (d - mean).powi(2)).sum();
    let (free, degrees) = (sum - squares / sum, found.len().saturating_sub(1) as f64);
    let by_chance = degrees + 2.0 * (2.0 * degrees).sqrt();
    if found.len() < 2 || free <= 1e-9 * sum || q <= by_chance { 0.0 } else { (q - degrees) / free }
}

#[cfg(test)]
mod tests {
    use super::excess;

    #[test]
    fn analytic_sessions_that_scatter_as_their_errors_say_have_no_spread_of_their_own() {
        // Q = 1 + 0 + 1 = 2 = n − 1.
        assert_eq!(excess(&[(-1.0, 1.0), (0.0, 1.0), (1.0, 1.0)]), 0.0);
        // Equal errors: τ² is the sample variance minus σ²; here 9 − 1, with Q = 18 far above 2 + 2 · 2.
        assert!((excess(&[(-3.0, 1.0), (0.0, 1.0), (3.0, 1.0)]) - 8.0).abs() < 1e-12);
        // One session shows no spread.
        assert_eq!(excess(&[(5.0, 1.0)]), 0.0);
    }
}

//! Whether a change is larger than chance and than the natural variation of the machine between sessions.

use super::quantity;
use super::robust::Estimates;
use super::select::{Changes, SURE, Sides, resettle};
use super::spread::between_sessions;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::term::Term;

/// Prior probability that a quantity has changed.
const PRIOR: f64 = 0.03;

/// Largest probability that is said. It is a bound and no calibration: if `n` of `n` names were right, the next one is with a probability of
/// `(n + 1)/(n + 2)` (Laplace's rule of succession), and a larger bound would need more than 98 of 98, which nobody has counted.
const SUREST: f64 = 0.99;

/// Probability that a quantity has changed, if the difference is `z` standard errors, natural variation included: the likelihood of a
/// normal error without a change is compared with the largest likelihood of a change.
pub fn probability(z: f64) -> f64 {
    (1.0 / (1.0 + (1.0 - PRIOR) / PRIOR * (-0.5 * z * z).exp())).min(SUREST)
}

/// Standard deviation of the natural variation: the spread between sessions of the reference, or the constant of the quantity.
pub fn natural(problem: &Problem, changes: &Changes, term: &Term, sides: &Sides) -> f64 {
    let effect = term.effect.everywhere();
    let terms = changes.terms();
    let spread = between_sessions(problem, &terms, effect, &term.joints, &term.shape, sides.reference.clone());
    let share = 1.0 / sides.reference.len() as f64 + 1.0 / sides.now.len().max(1) as f64;
    let floor = quantity::find(effect.name())
        .map_or(0.0, |quantity| quantity.natural * quantity.reference(problem, term.joints[0]).0.abs());
    (share * spread).sqrt().max(floor)
}

/// Standard errors by which the largest coefficient of a term differs from zero.
fn standing(problem: &Problem, changes: &Changes, index: usize, sides: &Sides) -> f64 {
    let terms = changes.terms();
    let natural = natural(problem, changes, terms[index], sides);
    let at = changes.estimates.fitted.term_at[index];
    let one = |k: usize| {
        let own = changes.estimates.std_error(&[(at + k, 1.0)]);
        changes.estimates.coefficient(index, k).abs() / own.hypot(natural).max(1e-300)
    };
    (0..terms[index].coefficients()).map(one).fold(0.0, f64::max)
}

/// Drops changes within the natural variation, the smallest first; returns the standing of the remaining terms.
pub fn keep_significant(problem: &mut Problem, changes: &mut Changes, sides: &Sides) -> Option<Vec<f64>> {
    loop {
        let first = changes.shared.len();
        let standings: Vec<f64> =
            (first..changes.terms().len()).map(|index| standing(problem, changes, index, sides)).collect();
        let weakest = standings.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
        let Some((index, _)) = weakest.filter(|(_, standing)| **standing < SURE) else { return Some(standings) };
        let mut position = 0;
        for taken in &mut changes.taken {
            taken.terms.retain(|_| {
                position += 1;
                position - 1 != index
            });
        }
        changes.taken.retain(|taken| !taken.terms.is_empty());
        resettle(problem, &mut changes.shared, &mut changes.taken)?;
        changes.estimates = Estimates::new(problem, &changes.terms())?;
    }
}

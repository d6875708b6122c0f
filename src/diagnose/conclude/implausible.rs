//! A nominal model that would have to be less accurate than it states.
//!
//! ```text
//!   |z|² > k² χ²_n        z ~ N(0, 1): the n deviations of the nominal model that the motion shows
//! ```
//! Deviations are free within the stated accuracy, so that they can take the place of a cause that has no name: the error is small then, and the
//! deviations are improbable. The stated accuracy is itself an estimate, so that `k` times as large deviations are still believed. Estimates are
//! smaller than the deviations themselves where the motion shows little, which makes the test say less.
//! Reference: L. L. Scharf, B. Friedlander (1994), Matched subspace detectors (test of a quadratic form).

use crate::diagnose::fit::problem::Problem;
use crate::diagnose::result::Unexplained;
use crate::distributions::chi_squared_upper_tail;
use crate::timeseries::root_mean_square;

/// `k` [1] Factor by which a stated accuracy may be wrong.
const FACTOR: f64 = 2.0;

/// [1] Probability below which deviations are not believed.
const IMPROBABLE: f64 = 1e-3;

/// What the deviations say where they are improbable, at the joint whose torque they change most.
pub fn deviations(problem: &Problem) -> Option<Unexplained> {
    let held = problem.inertial.as_ref()?.held()?;
    let (size, n) = (held.z.norm_squared(), held.z.len());
    if !is_improbable(size, n) {
        return None;
    }
    let share = |joint: usize| {
        let torque = root_mean_square(&problem.motion.joints[joint].torque).max(f64::MIN_POSITIVE);
        root_mean_square(&held.torque[joint]) / torque
    };
    let joint = problem.joints().into_iter().max_by(|a, b| share(*a).total_cmp(&share(*b)))?;
    let pattern = format!(
        "the model would have to be off by {:.1} times its stated accuracy: here masses, centres, inertias and constants move {:.0} % of the torque",
        (size / n.max(1) as f64).sqrt(),
        100.0 * share(joint)
    );
    Some(Unexplained { joint: problem.motion.model.joints[joint].name.clone(), pattern })
}

/// Whether `|z|²` of `n` deviations exceeds what an accuracy allows that is wrong by [`FACTOR`].
fn is_improbable(size: f64, n: usize) -> bool {
    chi_squared_upper_tail(size / (FACTOR * FACTOR), n as f64) < IMPROBABLE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_deviations_of_twice_the_accuracy_are_believed_and_of_four_times_are_not() {
        for n in [10, 20, 60] {
            assert!(!is_improbable(4.0 * n as f64, n) && is_improbable(16.0 * n as f64, n), "{n}");
        }
        // The 99.9 % quantile for ten degrees of freedom is 29.59, from tables.
        assert!(!is_improbable(4.0 * 29.5, 10) && is_improbable(4.0 * 29.7, 10));
    }
}

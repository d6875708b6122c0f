//! Evidence that an effect lacks because nothing that can exist has the coefficients of its fit.
//!
//! A body on a link has ten linear coefficients, of which some combinations belong to no body. The torque of a balancer may be fitted by such a combination,
//! and only nearly by that of the nearest possible body. What is missing of its torque is an error like the others.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::evidence::prediction::Evidence;
use crate::diagnose::fit::problem::{Part, Problem};
use crate::diagnose::fit::term::Term;

/// Takes from the evidence for a term with the fitted coefficients `estimate` what is lost where they are the nearest possible ones. With the error of scale `s`
/// on `n` independent rows and what is missing, of RMS `t`, it is `n ln(√(s² + t²)/s)`. `independence`: independent rows per row of each joint.
pub fn hold_to_possible(
    problem: &Problem,
    term: &Term,
    estimate: &[f64],
    independence: &[f64],
    evidence: &mut [Evidence],
) {
    let shown = term.joints.iter().zip(&term.columns).filter(|(joint, _)| evidence[**joint].error > 0.0);
    let squares: Vec<(usize, Squares)> =
        shown.map(|(joint, columns)| (*joint, Squares::new(columns, &problem.rows(*joint, Part::Train)))).collect();
    let mut precision = DMatrix::zeros(estimate.len(), estimate.len());
    for (joint, squares) in &squares {
        precision += &squares.gram * (independence[*joint] / evidence[*joint].error.powi(2));
    }
    let Some(possible) = term.effect.nearest_possible(&problem.motion, &term.shape, estimate, &precision) else {
        return;
    };
    let missing = DVector::from_vec(possible) - DVector::from_column_slice(estimate);
    for (joint, squares) in squares {
        let evidence = &mut evidence[joint];
        let lost = (squares.mean(&missing).sqrt().hypot(evidence.error) / evidence.error).ln();
        evidence.nats -= squares.rows * independence[joint] * lost;
        evidence.log_scale -= lost;
        evidence.error *= lost.exp();
    }
}

/// Squares of a term's torque on one joint.
struct Squares {
    rows: f64,
    /// `Σ YᵀY`
    gram: DMatrix<f64>,
}

impl Squares {
    fn new(columns: &[Vec<f64>], rows: &[usize]) -> Self {
        let dot = |a: &[f64], b: &[f64]| rows.iter().map(|row| a[*row] * b[*row]).sum::<f64>();
        let gram = DMatrix::from_fn(columns.len(), columns.len(), |i, k| dot(&columns[i], &columns[k]));
        Self { rows: rows.len() as f64, gram }
    }

    /// Mean square of the torque of these coefficients.
    fn mean(&self, coefficients: &DVector<f64>) -> f64 {
        (coefficients.dot(&(&self.gram * coefficients)) / self.rows.max(1.0)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::path::Path;

    use super::*;
    use crate::effects::drawn::{LENGTH, MODEL, ROBOT, drawn};
    use crate::effects::{About, Action, Diagnosable, Effect, Kind, Motion, Scope};
    use crate::error::Result;
    use crate::robot::Model;

    /// `τ = c₁ + c₂ sin 2q` with `c₂ ≤ 1`.
    struct AtMostOne;

    static AT_MOST_ONE: About = About {
        name: "at_most_one",
        summary: "A torque of limited size.",
        equation: "τ = c₁ + c₂ sin 2q",
        kind: Kind::Physics,
        scope: Scope::Joint,
        parameters: &[],
        signature: "a torque that depends on the angle",
        look_alikes: &[],
        separate_by: "measure it",
        reference: "none",
    };

    impl Effect for AtMostOne {
        fn about(&self) -> &'static About {
            &AT_MOST_ONE
        }

        fn install(&self, _: &mut Model, _: Option<usize>, _: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
            Ok(Vec::new())
        }

        fn diagnosable(&self) -> Option<&dyn Diagnosable> {
            Some(self)
        }
    }

    impl Diagnosable for AtMostOne {
        /// `c₁` makes up for what it can.
        fn nearest_possible(
            &self,
            _: &Motion,
            _: &[f64],
            coefficients: &[f64],
            precision: &DMatrix<f64>,
        ) -> Option<Vec<f64>> {
            let beyond = coefficients[1] - 1.0;
            let made_up = beyond * precision[(0, 1)] / precision[(0, 0)];
            (beyond > 0.0).then(|| vec![coefficients[0] + made_up, 1.0])
        }

        fn columns(&self, motion: &Motion, joint: usize, _: &[f64]) -> Vec<Vec<f64>> {
            vec![motion.column(joint, |_, _| 1.0), motion.column(joint, |m, row| (2.0 * m.q[row]).sin())]
        }

        fn parameters(&self, _: &Motion, _: usize, _: &[f64], coefficients: &[f64]) -> Vec<f64> {
            coefficients.to_vec()
        }
    }

    /// What is missing is `0.5 (sin 2q − mean)` in the rows of the fit. The error becomes the root of the sum of squares, and each independent row loses the rise of
    /// its logarithm. What is possible loses nothing.
    #[test]
    fn closed_form_a_size_beyond_what_is_possible_is_an_error() {
        let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a good model");
        let motion = drawn(&model, 5, None, LENGTH);
        let held_out = vec![false; motion.rows()];
        let problem = Problem::new(motion, held_out);
        let term = Term::new(&problem.motion, &AtMostOne as &dyn Diagnosable, &[0], Vec::new());
        let rows = problem.rows(0, Part::Train);
        let before = Evidence { nats: 1000.0, log_scale: 2.0, error: 0.1 };
        let held = |size: f64| {
            let mut evidence = [before];
            hold_to_possible(&problem, &term, &[0.3, size], &[0.2], &mut evidence);
            evidence[0]
        };
        assert_eq!(held(0.9), before);
        let sines: Vec<f64> = rows.iter().map(|row| (2.0 * problem.motion.joints[0].q[*row]).sin()).collect();
        let n = sines.len() as f64;
        let mean = sines.iter().sum::<f64>() / n;
        let missing = 0.5 * (sines.iter().map(|sine| (sine - mean).powi(2)).sum::<f64>() / n).sqrt();
        let after = held(1.5);
        let error = before.error.hypot(missing);
        let lost = (error / before.error).ln();
        // Rounding.
        assert!((after.error / error - 1.0).abs() < 1e-9, "{} {error}", after.error);
        assert!((before.log_scale - after.log_scale - lost).abs() < 1e-9, "{after:?}");
        assert!(((before.nats - after.nats) / (0.2 * n * lost) - 1.0).abs() < 1e-9, "{after:?}");
    }
}

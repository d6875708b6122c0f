//! The system of equations of a fit, one block per joint, and its solution.

use super::baseline::JointBaseline;
use super::problem::{Fitted, Part, Problem, Term};
use super::regression::{Block, NU, Solution, System, profile_likelihood};

/// A system, and the positions of its coefficients.
pub struct Assembled {
    /// The equations.
    pub system: System,
    /// First coefficient of the baseline of each joint.
    pub baseline_at: Vec<usize>,
    /// First coefficient of each term.
    pub term_at: Vec<usize>,
    /// Whether the Stribeck velocities may change a little: the derivative of the falling part is then a column of its own.
    loose: bool,
}

impl Assembled {
    /// Places of the coefficients, without equations.
    fn new(problem: &Problem, terms: &[&Term], loose: bool) -> Self {
        let mut unknowns = 0;
        let mut place = |count: usize| {
            unknowns += count;
            unknowns - count
        };
        let of_baseline = |baseline: &JointBaseline| {
            place(baseline.len() + usize::from(loose && baseline.stribeck_derivative().is_some()))
        };
        let baseline_at = problem.baseline.iter().map(of_baseline).collect();
        let term_at = terms.iter().map(|term| place(term.coefficients())).collect();
        let blocks = vec![Block::default(); problem.baseline.len()];
        Self { system: System { blocks, unknowns, priors: Vec::new() }, baseline_at, term_at, loose }
    }

    /// The fit that a solution of some joints is.
    fn fitted(self, joints: Vec<usize>, solution: Solution) -> Fitted {
        Fitted { joints, solution, baseline_at: self.baseline_at, term_at: self.term_at }
    }
}

impl Problem<'_> {
    /// The blocks of a part with these terms.
    pub fn system(&self, terms: &[&Term], part: Part, loose: bool) -> Assembled {
        self.system_of(&self.joints(), terms, part, loose)
    }

    /// As [`system`](Self::system), with empty blocks for other joints.
    pub fn system_of(&self, joints: &[usize], terms: &[&Term], part: Part, loose: bool) -> Assembled {
        let mut assembled = Assembled::new(self, terms, loose);
        for joint in joints {
            assembled.system.blocks[*joint] = self.block(*joint, terms, part, &assembled);
        }
        assembled
    }

    fn block(&self, joint: usize, terms: &[&Term], part: Part, assembled: &Assembled) -> Block {
        let rows = self.rows(joint, part);
        let pick = |column: &[f64]| -> Vec<f64> { rows.iter().map(|row| column[*row]).collect() };
        let (baseline, first) = (&self.baseline[joint], assembled.baseline_at[joint]);
        let derivative = baseline.stribeck_derivative().filter(|_| assembled.loose);
        let own = baseline.columns().iter().chain(derivative);
        let mut columns: Vec<_> = own.enumerate().map(|(index, column)| (first + index, pick(column))).collect();
        for (term, at) in terms.iter().zip(&assembled.term_at) {
            if let Some(place) = term.joints.iter().position(|j| *j == joint) {
                columns.extend(term.columns[place].iter().enumerate().map(|(k, column)| (at + k, pick(column))));
            }
        }
        Block { y: pick(baseline.target()), columns }
    }

    /// Fits baseline and terms to a part of the training data.
    pub fn fit(&self, terms: &[&Term], part: Part, nu: f64) -> Option<Fitted> {
        let assembled = self.system(terms, part, false);
        let solution = assembled.system.solve(nu)?;
        Some(assembled.fitted(self.joints(), solution))
    }

    /// As [`fit`](Self::fit), and the Stribeck velocities may change a little: for the comparison of candidates.
    pub fn fit_loosely(&self, terms: &[&Term], part: Part) -> Option<Fitted> {
        let assembled = self.system(terms, part, true);
        let solution = assembled.system.solve(NU)?;
        Some(assembled.fitted(self.joints(), solution))
    }

    /// As [`fit_loosely`](Self::fit_loosely), for some joints only. It starts with the weights of a similar fit of all training rows, which takes
    /// a few iterations instead of dozens.
    pub fn fit_near(&self, joints: &[usize], terms: &[&Term], part: Part, near: &Fitted) -> Option<Fitted> {
        let assembled = self.system_of(joints, terms, part, true);
        let weights = |joint: usize| -> Vec<f64> {
            if !joints.contains(&joint) {
                return Vec::new();
            }
            let all = self.rows(joint, Part::Train).into_iter().zip(&near.solution.weights[joint]);
            all.filter(|(row, _)| !matches!(part, Part::Without(fold) if self.fold[*row] == fold))
                .map(|(_, w)| *w)
                .collect()
        };
        let weights = (0..self.baseline.len()).map(weights).collect();
        let solution = assembled.system.solve_from(NU, weights, near.solution.scale.clone())?;
        Some(assembled.fitted(joints.to_vec(), solution))
    }

    /// Log-likelihood of each joint on another part of the training data with a loose fit, as if rows were independent; 0 for joints not fitted.
    pub fn likelihood_elsewhere(&self, terms: &[&Term], fitted: &Fitted, part: Part) -> Vec<f64> {
        let Assembled { system, .. } = self.system_of(&fitted.joints, terms, part, true);
        let of_joint =
            |joint: &usize| profile_likelihood(&system.blocks[*joint].residual(&fitted.solution.coefficients), NU);
        let mut likelihood = vec![0.0; self.baseline.len()];
        fitted.joints.iter().for_each(|joint| likelihood[*joint] = of_joint(joint));
        likelihood
    }
}

//! The system of equations of a fit, one block per joint, and its solution.

use super::baseline::JointBaseline;
use super::inertial::{Inertial, Treated};
use super::problem::{Fitted, Part, Problem};
use super::regression::{Block, NU, Solution, System, profile_likelihood};
use super::term::Term;

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
    /// How deviations of the nominal model are treated.
    pub inertial: Treated,
}

impl Assembled {
    /// Places of the coefficients, without equations.
    fn new(problem: &Problem, terms: &[&Term], loose: bool, inertial: impl FnOnce(usize) -> Treated) -> Self {
        let mut unknowns = 0;
        let mut place = |count: usize| {
            unknowns += count;
            unknowns - count
        };
        let of_baseline = |baseline: &JointBaseline| {
            place(baseline.len() + usize::from(loose && baseline.stribeck_derivative().is_some()))
        };
        let baseline_at = problem.baseline.iter().map(of_baseline).collect();
        let term_at: Vec<usize> = terms.iter().map(|term| place(term.coefficients())).collect();
        let inertial = inertial(place(0));
        let mut priors: Vec<(usize, f64)> = inertial.range().map(|at| (at, 1.0)).collect();
        unknowns += priors.len();
        for (term, at) in terms.iter().zip(&term_at) {
            priors.extend(term.effect.priors(&term.shape).into_iter().map(|(k, precision)| (at + k, precision)));
        }
        let blocks = vec![Block::default(); problem.baseline.len()];
        // Priors count against independent samples; without them, the weight of a whole block changes nothing.
        let trust = if priors.is_empty() { Vec::new() } else { problem.independence.clone() };
        Self { system: System { blocks, unknowns, priors, trust }, baseline_at, term_at, loose, inertial }
    }

    /// The fit that a solution of some joints is.
    fn fitted(self, joints: Vec<usize>, solution: Solution) -> Fitted {
        Fitted { joints, solution, baseline_at: self.baseline_at, term_at: self.term_at, inertial: self.inertial }
    }
}

impl Problem<'_> {
    /// The blocks of a part with these terms.
    pub fn system(&self, terms: &[&Term], part: Part, loose: bool) -> Assembled {
        self.system_of(&self.joints(), terms, part, loose)
    }

    /// As [`system`](Self::system), with empty blocks for other joints.
    pub fn system_of(&self, joints: &[usize], terms: &[&Term], part: Part, loose: bool) -> Assembled {
        let mut assembled = Assembled::new(self, terms, loose, |at| self.treated(joints, terms, at));
        for joint in joints {
            assembled.system.blocks[*joint] = self.block(*joint, terms, part, &assembled);
        }
        assembled
    }

    /// The equations of all training rows, with the deviations of the nominal model as unknowns even where they are held.
    pub fn system_of_deviating(&self, terms: &[&Term]) -> Assembled {
        let count = self.inertial.as_ref().map(Inertial::count);
        let treated = |at| count.map_or(Treated::Fixed, |count| Treated::Shared { at, count });
        let mut assembled = Assembled::new(self, terms, false, treated);
        for joint in self.joints() {
            assembled.system.blocks[joint] = self.block(joint, terms, Part::Train, &assembled);
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
        let machine: Vec<&Term> = terms.iter().copied().filter(|term| term.is_machine()).collect();
        let shared = matches!(assembled.inertial, Treated::Seen { with_machine: true, .. });
        for (term, at) in terms.iter().zip(&assembled.term_at).filter(|(term, _)| !(shared && term.is_machine())) {
            if let Some(place) = term.joints.iter().position(|j| *j == joint) {
                columns.extend(term.columns[place].iter().enumerate().map(|(k, column)| (at + k, pick(column))));
            }
        }
        let mut y = pick(baseline.target());
        let deviations = self.deviations(joint, &machine, assembled.inertial);
        columns.extend(assembled.inertial.range().zip(&*deviations.columns).map(|(at, column)| (at, pick(column))));
        if let Some(known) = deviations.known {
            y.iter_mut().zip(&rows).for_each(|(y, row)| *y -= known[*row]);
        }
        Block { y, columns }
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

    /// A loose fit of the joints of another fit to the training rows, with the deviations of the nominal model as in that fit.
    pub fn fit_beside(&self, terms: &[&Term], deviating: &Fitted) -> Option<Fitted> {
        // What one joint sees includes the effects of the whole machine.
        let with_machine = matches!(deviating.inertial, Treated::Seen { with_machine: true, .. });
        let terms: Vec<&Term> = terms.iter().copied().filter(|term| !(with_machine && term.is_machine())).collect();
        let mut assembled = Assembled::new(self, &terms, true, |_| Treated::Fixed);
        for joint in &deviating.joints {
            let mut block = self.block(*joint, &terms, Part::Train, &assembled);
            if let (Treated::Seen { .. } | Treated::Shared { .. }, Some(known)) =
                (deviating.inertial, self.deviating_torque(&terms, deviating, *joint))
            {
                let rows = self.rows(*joint, Part::Train);
                block.y.iter_mut().zip(rows).for_each(|(y, row)| *y -= known[row]);
            }
            assembled.system.blocks[*joint] = block;
        }
        let solution =
            assembled.system.solve_from(NU, deviating.solution.weights.clone(), deviating.solution.scale.clone())?;
        Some(assembled.fitted(deviating.joints.clone(), solution))
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

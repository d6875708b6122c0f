//! Standard errors of coefficients for correlated errors: the sandwich over clusters.
//!
//! `V = A⁻¹ B A⁻¹`, `A = Σ ψ'(e/s) x xᵀ/s²`, `B = Σ_c g_c g_cᵀ`, `g_c = Σ_{row ∈ c} w x e/s²`, with the clusters `c` blocks of 5 s, or whole
//! sessions where these scatter more: errors within a cluster may have any correlation. `w` are the weights of Student's t,
//! `ψ' = (ν + 1)(ν − z²)/(ν + z²)²` the slope of its score, `z = e/s`, averaged over each joint.
//! Reference: K.-Y. Liang, S. Zeger (1986), Longitudinal data analysis using generalized linear models; P. Huber (1967).

use crate::linear::{Equilibrated, sandwich};
use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use crate::diagnose::fit::problem::{Fitted, Part, Problem};
use crate::diagnose::fit::term::Term;
use crate::diagnose::fit::uncertainty::mean_slope;

/// [s] Length of a block.
const BLOCK: f64 = 5.0;

/// A loose fit of the training rows and the covariance of its coefficients.
pub struct Estimates {
    /// The fit.
    pub fitted: Fitted,
    by_block: DMatrix<f64>,
    by_session: DMatrix<f64>,
}

impl Estimates {
    /// Fits the terms; `None` where the columns do not determine the coefficients.
    pub fn new(problem: &Problem, terms: &[&Term]) -> Option<Self> {
        let fitted = problem.fit_loosely(terms, Part::Train)?;
        let system = problem.system(terms, Part::Train, true).system;
        let n = system.unknowns;
        let mut bread = DMatrix::<f64>::zeros(n, n);
        let mut blocks: BTreeMap<(usize, usize), DVector<f64>> = BTreeMap::new();
        let mut sessions: BTreeMap<usize, DVector<f64>> = BTreeMap::new();
        let solution = &fitted.solution;
        for (joint, block) in system.blocks.iter().enumerate() {
            let rows = problem.rows(joint, Part::Train);
            let (e, w, s) = (&solution.residual[joint], &solution.weights[joint], solution.scale[joint]);
            let precision = system.trust.get(joint).unwrap_or(&1.0) / (s * s);
            let kappa = mean_slope(e, w, s);
            for (position, (i, x)) in block.columns.iter().enumerate() {
                for (j, y) in &block.columns[..=position] {
                    let sum: f64 = x.iter().zip(y).zip(w).map(|((x, y), w)| x * y * w).sum();
                    bread[(*i, *j)] += kappa * precision * sum;
                    if i != j {
                        bread[(*j, *i)] += kappa * precision * sum;
                    }
                }
                for (index, row) in rows.iter().enumerate() {
                    let session = problem.motion.session[*row];
                    let number = (problem.motion.time[*row].max(0.0) / BLOCK) as usize;
                    let score = precision * w[index] * x[index] * e[index];
                    let zero = || DVector::zeros(n);
                    blocks.entry((session, number)).or_insert_with(zero)[*i] += score;
                    sessions.entry(session).or_insert_with(zero)[*i] += score;
                }
            }
        }
        system.priors.iter().for_each(|(at, precision)| bread[(*at, *at)] += precision);
        // A coefficient that the rows do not show stays unchanged.
        let inverse = Equilibrated::new(&bread)?.inverse();
        // The scores of all clusters sum to zero, so one of them is not independent.
        Some(Self {
            fitted,
            by_block: sandwich(&inverse, blocks.values(), 1),
            by_session: sandwich(&inverse, sessions.values(), 1),
        })
    }

    /// Standard error of a linear combination of coefficients.
    pub fn std_error(&self, gradient: &[(usize, f64)]) -> f64 {
        let mut g = DVector::zeros(self.by_block.nrows());
        for (index, slope) in gradient {
            g[*index] += slope;
        }
        let variance = |covariance: &DMatrix<f64>| (g.transpose() * covariance * &g)[(0, 0)].max(0.0);
        variance(&self.by_block).max(variance(&self.by_session)).sqrt()
    }

    /// A coefficient of a term.
    pub fn coefficient(&self, term: usize, k: usize) -> f64 {
        self.fitted.solution.coefficients[self.fitted.term_at[term] + k]
    }
}

//! What speaks for a setting of the gear against a poorer one: prediction of rows that it was not fitted on.

use nalgebra::{Cholesky, DMatrix};

use super::attempt::Fit;
use super::channel::Channel;
use crate::diagnose::fit::problem::{FOLDS, Part, independence};
use crate::diagnose::fit::regression::{NU, Solution, profile_likelihood};

/// Largest lag that the autocorrelation is summed to.
const MOST_LAGS: usize = 200;
/// Share of the diagonal that keeps columns apart which others make up.
const RIDGE: f64 = 1e-10;

/// How well a fit predicts, in nats as if rows were independent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// On each fold of the training rows, its parameters moved to suit the others.
    pub folds: f64,
    /// Scale of the training error.
    pub scale: f64,
    /// Independent samples per row.
    pub independence: f64,
}

impl Channel<'_, '_> {
    /// Predicts with a fit. Where its parameters are bent straight (their sensitivities) it is fitted anew without each fold.
    pub fn predict(&self, fit: &Fit) -> Option<(Prediction, Solution)> {
        let elsewhere = |solution: &Solution, part: Part| {
            let system = self.system(&self.part(part), &fit.lack, &fit.columns);
            let block = &system.blocks[0];
            if block.y.is_empty() { 0.0 } else { profile_likelihood(&block.residual(&solution.coefficients), NU) }
        };
        let mut folds = 0.0;
        for fold in 0..FOLDS {
            let solution = self.fit(Part::Without(fold), &fit.lack, &fit.columns)?;
            folds += elsewhere(&solution, Part::Fold(fold));
        }
        let solution = self.fit(Part::Train, &fit.lack, &fit.columns)?;
        let prediction = Prediction { folds, scale: solution.scale[0], independence: self.independence(&solution) };
        Some((prediction, solution))
    }

    /// [`independence`] of its training rows.
    fn independence(&self, solution: &Solution) -> f64 {
        let rows: Vec<usize> = self.part(Part::Train).iter().map(|index| self.rows[*index]).collect();
        independence(&solution.residual[0], &solution.weights[0], &rows, MOST_LAGS)
    }

    /// Variance of each coefficient of a fit, the errors of the rows that belong together counted once.
    pub fn variances(&self, fit: &Fit, solution: &Solution, independence: f64) -> Option<Vec<f64>> {
        let system = self.system(&self.part(Part::Train), &fit.lack, &fit.columns);
        let columns = &system.blocks[0].columns;
        let precision = independence / (solution.scale[0] * solution.scale[0]);
        let weights = &solution.weights[0];
        let product = |i: usize, j: usize| -> f64 {
            let pairs = columns[i].1.iter().zip(&columns[j].1).zip(weights);
            precision * pairs.map(|((a, b), w)| w * a * b).sum::<f64>()
        };
        let information = DMatrix::from_fn(columns.len(), columns.len(), product);
        // In units of its own error each diagonal is one: parameters of any unit keep their digits.
        let size: Vec<f64> = information.diagonal().iter().map(|d| 1.0 / d.max(1e-300).sqrt()).collect();
        let scaled = DMatrix::from_fn(columns.len(), columns.len(), |i, j| information[(i, j)] * size[i] * size[j]);
        let inverse = Cholesky::new(scaled + RIDGE * DMatrix::identity(columns.len(), columns.len()))?.inverse();
        Some(size.iter().enumerate().map(|(i, size)| inverse[(i, i)] * size * size).collect())
    }
}

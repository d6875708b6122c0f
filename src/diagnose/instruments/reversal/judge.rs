//! Comparison of two settings of the gear: prediction of rows that were not used for the fit.

use nalgebra::DMatrix;

use crate::linear::Equilibrated;

use super::attempt::TurnFit;
use super::turn_rows::TurnRows;
use crate::diagnose::fit::problem::{FOLDS, Part, independence};
use crate::diagnose::fit::regression::{NU, Solution, profile_likelihood};

/// Largest lag of the autocorrelation sum.
const MOST_LAGS: usize = 200;

/// Log-likelihood of a fit's predictions [nats], as if rows were independent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnLikelihood {
    /// On each fold of the training rows, with the parameters fitted to the other folds.
    pub folds: f64,
    /// Scale of the training error.
    pub scale: f64,
    /// Independent samples per row.
    pub independence: f64,
}

impl TurnRows<'_, '_> {
    /// Predictions of a fit. Its parameters are linearised (with their sensitivities) and fitted again without each fold.
    pub fn predict(&self, fit: &TurnFit) -> Option<(TurnLikelihood, Solution)> {
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
        let prediction = TurnLikelihood { folds, scale: solution.scale[0], independence: self.independence(&solution) };
        Some((prediction, solution))
    }

    /// [`independence`] of its training rows.
    fn independence(&self, solution: &Solution) -> f64 {
        let rows: Vec<usize> = self.part(Part::Train).iter().map(|index| self.rows[*index]).collect();
        independence(&solution.residual[0], &solution.weights[0], &rows, MOST_LAGS)
    }

    /// Variance of each coefficient of a fit, with correlated errors of rows counted once.
    pub fn variances(&self, fit: &TurnFit, solution: &Solution, independence: f64) -> Option<Vec<f64>> {
        let system = self.system(&self.part(Part::Train), &fit.lack, &fit.columns);
        let columns = &system.blocks[0].columns;
        let precision = independence / (solution.scale[0] * solution.scale[0]);
        let weights = &solution.weights[0];
        let product = |i: usize, j: usize| -> f64 {
            let pairs = columns[i].1.iter().zip(&columns[j].1).zip(weights);
            precision * pairs.map(|((a, b), w)| w * a * b).sum::<f64>()
        };
        let information = DMatrix::from_fn(columns.len(), columns.len(), product);
        let inverse = Equilibrated::new(&information)?.inverse();
        Some(inverse.diagonal().iter().copied().collect())
    }
}

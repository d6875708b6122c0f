//! A robust fit of the difference of two encoders, with errors that may be correlated within blocks of time.

use crate::linear::{Equilibrated, sandwich};
use nalgebra::{DMatrix, DVector};

use super::difference::Difference;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::regression::{Block, NU, System};
use crate::timeseries::root_mean_square;

/// [s] Length of the blocks within which errors may have any correlation, for standard errors.
const BLOCK: f64 = 1.0;

/// A robust fit.
pub struct Solved {
    /// Coefficient of each column.
    pub coefficients: DVector<f64>,
    /// Residual of each row.
    pub residual: Vec<f64>,
    /// Weight of each row.
    pub weights: Vec<f64>,
    /// Log-likelihood, a constant left out.
    pub log_likelihood: f64,
    /// Scale of the robust error.
    pub scale: f64,
    /// RMS residual.
    pub rms: f64,
}

/// Fits columns to values.
pub fn solve(y: &[f64], columns: &[Vec<f64>]) -> Option<Solved> {
    let block = Block { y: y.to_vec(), columns: columns.iter().cloned().enumerate().collect() };
    let system = System { blocks: vec![block], unknowns: columns.len(), ..System::default() };
    let mut solution = system.solve(NU)?;
    let residual = solution.residual.swap_remove(0);
    let rms = root_mean_square(&residual);
    Some(Solved {
        coefficients: solution.coefficients,
        residual,
        weights: solution.weights.swap_remove(0),
        log_likelihood: solution.log_likelihood[0],
        scale: solution.scale[0],
        rms,
    })
}

/// Rows with the columns that were fitted to them.
pub struct Regression<'r> {
    /// The rows.
    pub rows: &'r Difference,
    /// Columns of the coefficients.
    pub columns: &'r [Vec<f64>],
    /// Their fit.
    pub solved: &'r Solved,
}

impl Regression<'_> {
    /// Covariance of the coefficients, and of those of further columns whose coefficients are zero, for any correlation of errors within a
    /// block of time (sandwich of Liang and Zeger 1986).
    pub fn covariance(&self, problem: &Problem, further: &[Vec<f64>]) -> DMatrix<f64> {
        let Self { rows, columns, solved } = self;
        let columns: Vec<&[f64]> = columns.iter().chain(further).map(Vec::as_slice).collect();
        let n = columns.len();
        let mut bread = DMatrix::zeros(n, n);
        let mut scores: Vec<DVector<f64>> = Vec::new();
        let mut sum: DVector<f64> = DVector::zeros(n);
        let key = |index: usize| {
            let row = rows.rows[index];
            (problem.motion.session[row], (problem.motion.time[row] / BLOCK) as usize)
        };
        for index in 0..rows.rows.len() {
            let x = DVector::from_iterator(n, columns.iter().map(|column| column[index]));
            bread += solved.weights[index] * &x * x.transpose();
            sum += solved.weights[index] * solved.residual[index] * x;
            if index + 1 == rows.rows.len() || key(index + 1) != key(index) {
                scores.push(std::mem::replace(&mut sum, DVector::zeros(n)));
            }
        }
        let Some(factor) = Equilibrated::new(&bread) else { return DMatrix::from_element(n, n, f64::INFINITY) };
        // Correction for the degrees of freedom that the fit takes from few blocks.
        let taken = n.min(scores.len().saturating_sub(1));
        sandwich(&factor.inverse(), scores.iter(), taken)
    }
}

//! Some thousand rows of a joint, which are enough to find the peaks of a scan over many shapes.

use super::problem::{Part, Problem};
use super::regression::{Block, Score, Solution, System};
use crate::effects::Motion;

/// Every so many rows of a joint's training data, with the score of what a fit left in them.
pub struct Scanned<'m> {
    /// The motion in these rows.
    pub motion: Motion<'m>,
    /// Score of new columns.
    pub score: Score,
    /// Independent samples per row of the scan.
    pub independence: f64,
}

impl<'m> Scanned<'m> {
    /// About `count` rows of the equations and of their solution.
    pub fn new(problem: &Problem<'m>, system: &System, solution: &Solution, joint: usize, count: usize) -> Self {
        let rows = problem.rows(joint, Part::Train);
        let stride = rows.len().div_ceil(count).max(1);
        let thin = |values: &[f64]| -> Vec<f64> { values.iter().step_by(stride).copied().collect() };
        let block = &system.blocks[joint];
        let columns = block.columns.iter().map(|(index, column)| (*index, thin(column))).collect();
        let block = Block { y: thin(&block.y), columns };
        let (residual, weights) = (thin(&solution.residual[joint]), thin(&solution.weights[joint]));
        // The rows of the scan stand for all rows, which count with their independence.
        let independence = problem.independence[joint] * stride as f64;
        let priors = system.priors_per_row(independence);
        let score = Score::new(&block, &residual, &weights, solution.scale[joint], &priors);
        let picked: Vec<usize> = rows.into_iter().step_by(stride).collect();
        Self { motion: problem.motion.at_rows(&picked), score, independence }
    }
}

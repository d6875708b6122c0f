//! The Stribeck velocities that suit the terms of a model.

use rayon::prelude::*;

use super::assembly::Assembled;
use super::baseline::{FALLING, Falling, JointBaseline, stribeck_grid};
use super::golden::golden_section;
use super::problem::{Fitted, Part, Problem};
use super::regression::NU;
use super::term::Term;
use crate::effects::falling;

/// Least amount of the falling part of friction in the data, in equivalent independent rows, for which the Stribeck velocity is fitted.
const LEAST_PRESENCE: f64 = 1.0;
/// Ratio of the ends of the search interval at which a Stribeck velocity counts as found.
const STRIBECK_RATIO: f64 = 1.01;

impl Problem<'_> {
    /// Finds the best Stribeck velocities for the terms, and writes the fitted friction into the motion.
    pub fn settle(&mut self, terms: &[&Term]) -> Option<Fitted> {
        let of_joint = |(joint, baseline): (usize, &JointBaseline)| match baseline.falling() {
            Falling::Given(_) => Some(baseline.clone()),
            Falling::Free(_) => {
                let v_s = self.stribeck_velocity(terms, joint)?;
                Some(baseline.at_stribeck_velocity(&self.motion, joint, v_s))
            }
        };
        self.baseline = self.baseline.par_iter().enumerate().map(of_joint).collect::<Option<_>>()?;
        let fitted = self.fit(terms, Part::Train, NU)?;
        self.adopt(&fitted);
        Some(fitted)
    }

    /// The best Stribeck velocity of a joint for the terms; shared coefficients are fitted to this joint alone.
    fn stribeck_velocity(&self, terms: &[&Term], joint: usize) -> Option<f64> {
        let Assembled { system, .. } = self.system_of(&[joint], terms, Part::Train, false);
        let motion = self.motion.at_rows(&self.rows(joint, Part::Train));
        // The weights change little with the velocity: from those of one fit the others need a few iterations instead of dozens.
        let near = system.solve(NU)?;
        let likelihood = |v_s: f64| {
            let column = falling(&motion, joint, v_s);
            let presence: f64 = column.iter().map(|x| x * x).sum();
            if presence * self.independence[joint] < LEAST_PRESENCE {
                return f64::NEG_INFINITY;
            }
            let mut system = system.clone();
            system.blocks[joint].columns[FALLING].1 = column;
            let solution = system.solve_from(NU, near.weights.clone(), near.scale.clone());
            solution.map_or(f64::NEG_INFINITY, |solution| solution.log_likelihood[joint])
        };
        let grid = stribeck_grid(&self.motion, joint);
        let tried: Vec<f64> = grid.par_iter().map(|v_s| likelihood(*v_s)).collect();
        let best = (0..grid.len()).max_by(|a, b| tried[*a].total_cmp(&tried[*b]))?;
        let (low, high) = (grid[best.saturating_sub(1)], grid[(best + 1).min(grid.len() - 1)]);
        let (low, high) = golden_section([low, high], |low, high| high / low <= STRIBECK_RATIO, likelihood);
        Some(0.5 * (low + high))
    }
}

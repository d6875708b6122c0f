//! The Stribeck velocities that suit the terms of a model.

use rayon::prelude::*;

use super::assembly::Assembled;
use super::baseline::{FALLING, Falling, JointBaseline, stribeck_grid};
use super::golden::golden_section;
use super::problem::{Fitted, Part, Problem};
use super::regression::{NU, Score, Solution, System};
use super::term::Term;
use crate::effects::falling;

/// Least amount of the falling part of friction in the data, in equivalent independent rows, for which the Stribeck velocity is fitted.
const LEAST_PRESENCE: f64 = 1.0;
/// Ratio of the ends of the search interval at which a Stribeck velocity counts as found.
const STRIBECK_RATIO: f64 = 1.01;
/// Most fits of the weights before the best velocity of the grid has to stay the same. Each leaves a third of the way where errors have three degrees
/// of freedom, and the grid spans a factor of 80: it comes within one of its steps in three.
const MOST_ROUNDS: usize = 6;
/// Steps of the grid to either side of its best velocity in which the largest likelihood is searched: weights of a neighbour favour the neighbour.
const STEPS_AROUND: usize = 2;

impl Problem<'_> {
    /// Finds the best Stribeck velocities for the terms, and writes the fitted friction into the motion.
    pub fn settle(&mut self, terms: &[&Term]) -> Option<Fitted> {
        let joints = 0..self.baseline.len();
        self.baseline = joints.into_par_iter().map(|joint| self.suited(terms, joint)).collect::<Option<_>>()?;
        let fitted = self.fit(terms, Part::Train, NU)?;
        self.adopt(&fitted);
        Some(fitted)
    }

    /// The baseline of a joint with the Stribeck velocity that suits the terms best.
    pub fn suited(&self, terms: &[&Term], joint: usize) -> Option<JointBaseline> {
        let baseline = &self.baseline[joint];
        match baseline.falling() {
            Falling::Given(_) => Some(baseline.clone()),
            Falling::Free(_) => {
                let v_s = self.stribeck_velocity(terms, joint)?;
                Some(baseline.at_stribeck_velocity(&self.motion, joint, v_s))
            }
        }
    }

    /// The best Stribeck velocity of a joint for the terms; shared coefficients are fitted to this joint alone.
    fn stribeck_velocity(&self, terms: &[&Term], joint: usize) -> Option<f64> {
        let Assembled { mut system, .. } = self.system_of(&[joint], terms, Part::Train, false);
        let motion = self.motion.at_rows(&self.rows(joint, Part::Train));
        let column = |v_s: f64| {
            let column = falling(&motion, joint, v_s);
            let presence: f64 = column.iter().map(|x| x * x).sum();
            (presence * self.independence[joint] >= LEAST_PRESENCE).then_some(column)
        };
        let grid = stribeck_grid(&self.motion, joint);
        let mut near = system.solve(NU)?;
        let mut best = None;
        for _ in 0..MOST_ROUNDS {
            // At constant weights a velocity costs one column instead of a fit.
            let score = self.without_falling(&system, joint, &near)?;
            let gain = |v_s: &f64| column(*v_s).map_or(f64::NEG_INFINITY, |column| score.gain(&[column]));
            let gains: Vec<f64> = grid.par_iter().map(gain).collect();
            let last = best.replace((0..grid.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b]))?);
            if best == last {
                break;
            }
            system.blocks[joint].columns[FALLING].1 = falling(&motion, joint, grid[best?]);
            near = system.solve_from(NU, near.weights, near.scale)?;
        }
        // The weights change little with the velocity: from those of one fit the others need a few iterations instead of dozens.
        let likelihood = |v_s: f64| {
            let mut system = system.clone();
            system.blocks[joint].columns[FALLING].1 = column(v_s)?;
            let solution = system.solve_from(NU, near.weights.clone(), near.scale.clone())?;
            Some(solution.log_likelihood[joint])
        };
        let best = best?;
        let (low, high) = (grid[best.saturating_sub(STEPS_AROUND)], grid[(best + STEPS_AROUND).min(grid.len() - 1)]);
        let (low, high) = golden_section(
            [low, high],
            |low, high| high / low <= STRIBECK_RATIO,
            |v_s| likelihood(v_s).unwrap_or(f64::NEG_INFINITY),
        );
        Some(0.5 * (low + high))
    }

    /// The score of a falling part in the rows of a joint, at the weights and scale of a fit with another one.
    fn without_falling(&self, system: &System, joint: usize, fitted: &Solution) -> Option<Score> {
        let mut rest = system.clone();
        let (held, _) = rest.blocks[joint].columns.remove(FALLING);
        rest.priors.push((held, 1.0));
        let coefficients = rest.weighted(&fitted.weights, &fitted.scale)?;
        let block = &rest.blocks[joint];
        let priors = rest.priors_per_row(self.independence[joint]);
        Some(Score::new(block, &block.residual(&coefficients), &fitted.weights[joint], fitted.scale[joint], &priors))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::effects::drawn::{LENGTH, MODEL, NOISE, ROBOT, drawn};
    use crate::robot::Model;

    /// Log-likelihood of the whole fit with this Stribeck velocity.
    fn likelihood(problem: &Problem, v_s: f64) -> f64 {
        let mut system = problem.system(&[], Part::Train, false).system;
        system.blocks[0].columns[FALLING].1 = falling(&problem.motion, 0, v_s);
        system.solve(NU).expect("a fit").log_likelihood[0]
    }

    /// The search ends where whole fits are most likely, with one row in ten far off. The planted velocities have standard errors of up to 5 %.
    #[test]
    fn recover_the_velocity_of_the_largest_likelihood() {
        let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a good model");
        for (seed, planted) in [(1, 0.05), (2, 0.2), (3, 0.1)] {
            let mut motion = drawn(&model, seed, None, LENGTH);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let one = &mut motion.joints[0];
            for row in 0..one.v.len() {
                let (v, sign) = (one.v[row], one.v[row].signum());
                let size = if rng.random_bool(0.1) { 10.0 * NOISE } else { NOISE };
                let friction = (2.0 + 1.5 * (-v.abs() / planted).exp()) * sign + 1.3 * v;
                let normal: f64 = (0..12).map(|_| rng.random_range(-0.5..0.5)).sum();
                one.torque[row] = one.rigid[row] + friction + size * normal;
            }
            let held_out = vec![false; motion.rows()];
            let problem = Problem::new(motion, held_out);
            let found = problem.stribeck_velocity(&[], 0).expect("a velocity");
            assert!((found / planted - 1.0).abs() < 0.15, "{planted}: {found}");
            let most = likelihood(&problem, found);
            // Half a percent beside a peak whose width is a standard error of 2 % costs 0.03 nats.
            let beaten =
                stribeck_grid(&problem.motion, 0).into_iter().find(|v_s| likelihood(&problem, *v_s) > most + 0.03);
            assert_eq!(beaten, None, "{planted}: {found}");
        }
    }
}

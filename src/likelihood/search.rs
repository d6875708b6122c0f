//! The search before the steps of a fit: the noise of each joint, gaps and sizes of effects one by one.

use rayon::prelude::*;

use super::objective::Fit;
use super::parameters::Kind;
use crate::error::Result;

/// Steps in which `λ` is sought, its range, and most of the steps at a time.
const NOISE_STEP: f64 = 0.7;
const NOISE_RANGE: [f64; 2] = [-1.5, 7.0];
pub(super) const NOISE_TRIALS: usize = 8;
/// [nat] What a joint has to gain by a step of its `λ`.
const NOISE_GAIN: f64 = 0.5;
/// First step of a search along one size, and the share of a first step at which a search ends.
const SIZE_STEP: f64 = 1.0;
const LAST_STEP: f64 = 0.15;

impl Fit<'_> {
    /// The most probable `λ`, joint by joint, from a first guess.
    pub fn noise(&self, x: &[f64], mut lambda: Vec<f64>, most: usize) -> Result<Vec<f64>> {
        let mut here = self.nats(x, &lambda)?;
        let mut way = vec![0.0; lambda.len()];
        for _ in 0..most {
            let moved = |sign: f64| -> Vec<f64> {
                let step = |(lambda, way): (&f64, &f64)| {
                    // No way back.
                    let step = if *way == -sign { 0.0 } else { sign };
                    (lambda + NOISE_STEP * step).clamp(NOISE_RANGE[0], NOISE_RANGE[1])
                };
                lambda.iter().zip(&way).map(step).collect()
            };
            let mut changed = false;
            let trials = [-1.0, 1.0].map(|sign| (sign, moved(sign)));
            let mut next = lambda.clone();
            for (sign, trial) in trials.into_iter().filter(|(_, trial)| *trial != lambda) {
                let there = self.nats(x, &trial)?;
                for joint in 0..lambda.len() {
                    if there[joint] > here[joint] + NOISE_GAIN && trial[joint] != lambda[joint] {
                        (here[joint], next[joint], way[joint]) = (there[joint], trial[joint], sign);
                        changed = true;
                    }
                }
            }
            if !changed {
                break;
            }
            lambda = next;
        }
        Ok(lambda)
    }

    /// Searches gaps and sizes of effects one by one, and then the noise. Where a gap is off by a count, or much else is wrong, the score is rough: a search
    /// along one line finds its way where a step in all directions does not.
    pub fn search(&self, mut x: Vec<f64>, lambda: Vec<f64>, gap_step: f64) -> Result<(Vec<f64>, Vec<f64>)> {
        let first = |kind: &Kind| match kind {
            Kind::Effect(..) => Some(SIZE_STEP),
            Kind::Gap(_) => Some(gap_step),
            _ => None,
        };
        let mut best = self.height(&x, &lambda);
        // What a hypothesis adds comes first: gaps follow it.
        let lines = self.parameters.iter().enumerate().filter_map(|(k, one)| Some((k, first(&one.kind)?))).rev();
        for (k, first) in lines {
            let mut step: f64 = first;
            while step.abs() > LAST_STEP * first {
                let at = |step: f64| x.iter().enumerate().map(|(i, x)| if i == k { x + step } else { *x }).collect();
                let trials: [Vec<f64>; 2] = [at(step), at(-step)];
                let heights = trials.par_iter().map(|x| self.height(x, &lambda)).collect::<Vec<_>>();
                let way = usize::from(heights[1] > heights[0]);
                if heights[way] > best {
                    best = heights[way];
                    x.clone_from(&trials[way]);
                } else {
                    step *= 0.4;
                }
            }
        }
        let lambda = self.noise(&x, lambda, NOISE_TRIALS)?;
        Ok((x, lambda))
    }
}

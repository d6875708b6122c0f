//! How well a model predicts rows that it was not fitted on, and the evidence that follows.

use rayon::prelude::*;

use crate::diagnose::fit::problem::{FOLDS, Fitted, Part, Problem, Term};
use crate::diagnose::fit::regression::Solution;
use crate::diagnose::options::Rules;

/// How well a model predicts, by joint, in nats as if rows were independent.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// Joints that it is of; what stands for others means nothing.
    joints: Vec<usize>,
    /// On the rows that it was fitted on.
    pub training: Vec<f64>,
    /// On each fold, fitted on the others.
    pub folds: Vec<f64>,
    /// Scale of the training error.
    pub scale: Vec<f64>,
    /// Independent samples per row.
    pub independence: Vec<f64>,
}

impl Prediction {
    /// What speaks for this model against a poorer one. How many rows are independent is judged by the errors of the richer one:
    /// an effect that is not modelled makes errors that never forget. A joint that was not predicted anew says nothing.
    pub fn against(&self, before: &Self) -> Vec<Evidence> {
        let mut evidence = vec![Evidence::default(); self.folds.len()];
        for joint in self.joints.iter().copied() {
            evidence[joint] = Evidence {
                nats: self.independence[joint] * self.gained_elsewhere(before, joint),
                log_scale: (before.scale[joint] / self.scale[joint]).ln(),
            };
        }
        evidence
    }

    /// Gain on rows that were left out, as far as there is one on the rows that were fitted: what goes beyond it is only that
    /// the poorer model, fitted on fewer rows, happens to be far off on the others.
    fn gained_elsewhere(&self, before: &Self, joint: usize) -> f64 {
        let fitted = (self.training[joint] - before.training[joint]).max(0.0);
        (self.folds[joint] - before.folds[joint]).min(fitted)
    }
}

/// Evidence for a term on one joint, from the training data alone.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Evidence {
    /// [nats] gain of likelihood by cross-validation, the choice among shapes paid for.
    pub nats: f64,
    /// [1] logarithm of the ratio of error scales, without over with.
    pub log_scale: f64,
}

impl Evidence {
    /// Whether it supports an effect on one joint.
    pub fn is_enough(&self, rules: &Rules) -> bool {
        rules.support(self.nats, self.log_scale)
    }
}

/// How well the terms predict; `None` where they cannot be fitted.
pub fn predict(problem: &Problem, terms: &[&Term]) -> Option<Prediction> {
    prediction(problem, terms, &problem.fit_loosely(terms, Part::Train)?)
}

/// As [`predict`], with the loose fit of all training rows at hand: of those joints that were fitted.
pub fn prediction(problem: &Problem, terms: &[&Term], fitted: &Fitted) -> Option<Prediction> {
    let mut folds = vec![0.0; problem.baseline.len()];
    let parts: Vec<Option<Vec<f64>>> = (0..FOLDS)
        .into_par_iter()
        .map(|fold| {
            let fitted = problem.fit_near(&fitted.joints, terms, Part::Without(fold), fitted)?;
            Some(problem.likelihood_elsewhere(terms, &fitted, Part::Fold(fold)))
        })
        .collect();
    for part in parts {
        folds.iter_mut().zip(part?).for_each(|(sum, value)| *sum += value);
    }
    let independence = problem.independence_of(fitted);
    let Solution { log_likelihood: training, scale, .. } = &fitted.solution;
    let (joints, training, scale) = (fitted.joints.clone(), training.clone(), scale.clone());
    Some(Prediction { joints, training, folds, scale, independence })
}

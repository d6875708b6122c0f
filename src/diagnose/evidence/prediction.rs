//! Prediction of rows that were not used for the fit, and the evidence from it.

use rayon::prelude::*;

use crate::diagnose::fit::inertial::Treated;
use crate::diagnose::fit::problem::{FOLDS, Fitted, Part, Problem};
use crate::diagnose::fit::regression::Solution;
use crate::diagnose::fit::term::Term;
use crate::diagnose::options::{Inaccuracy, Rules};

/// Log-likelihood of a model's predictions by joint [nats], as if rows were independent.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// Joints with predictions; the entries of other joints are undefined.
    joints: Vec<usize>,
    /// On the rows of the fit.
    pub training: Vec<f64>,
    /// On each fold, fitted to the other folds.
    pub folds: Vec<f64>,
    /// Scale of the training error.
    pub scale: Vec<f64>,
    /// Independent samples per row.
    pub independence: Vec<f64>,
    /// What the prior of the model's deviations loses.
    pub prior_loss: f64,
}

impl Prediction {
    /// The evidence for this model against a simpler one of the same joints. The number of independent rows is taken from the errors of this model, because
    /// an effect that is not modelled makes correlated errors. A joint without a new prediction gives no evidence.
    pub fn against(&self, before: &Self) -> Vec<Evidence> {
        let mut evidence = self.of_rows(before);
        self.add_prior(before, &mut evidence);
        evidence
    }

    /// The evidence from the rows alone.
    fn of_rows(&self, before: &Self) -> Vec<Evidence> {
        let mut evidence = vec![Evidence::default(); self.folds.len()];
        for joint in self.joints.iter().copied() {
            evidence[joint] = Evidence {
                nats: self.independence[joint] * self.gained_elsewhere(before, joint),
                log_scale: (before.scale[joint] / self.scale[joint]).ln(),
                error: self.scale[joint],
            };
        }
        evidence
    }

    /// Adds that deviations of the nominal model are less improbable with this model: once, to the joint that gains most.
    fn add_prior(&self, before: &Self, evidence: &mut [Evidence]) {
        let most = self.joints.iter().copied().max_by(|a, b| evidence[*a].nats.total_cmp(&evidence[*b].nats));
        if let Some(most) = most {
            evidence[most].nats += before.prior_loss - self.prior_loss;
        }
    }

    /// Gain on rows that were left out, limited to the gain on the rows of the fit. More than that only shows that the simpler model,
    /// fitted to fewer rows, is by chance far off on the others.
    fn gained_elsewhere(&self, before: &Self, joint: usize) -> f64 {
        let fitted = (self.training[joint] - before.training[joint]).max(0.0);
        (self.folds[joint] - before.folds[joint]).min(fitted)
    }
}

/// Evidence for a term on one joint, from the training data only.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Evidence {
    /// [nats] Gain of log-likelihood by cross-validation, reduced for the choice among shapes.
    pub nats: f64,
    /// [1] Logarithm of the error scale without the term, divided by that with it, at the same deviations of the nominal model.
    pub log_scale: f64,
    /// [N·m or N] Error scale with the term. Other terms leave other deviations: errors compare with each other, falls do not.
    pub error: f64,
}

impl Evidence {
    /// [1] Logarithm by which the error is larger than with other terms on the same joint.
    pub fn worse_than(&self, other: &Self) -> f64 {
        (self.error / other.error).ln()
    }

    /// Whether it supports an effect on one joint.
    pub fn is_enough(&self, rules: &Rules) -> bool {
        rules.support(self.nats, self.log_scale)
    }
}

/// Predictions of the terms; `None` where they cannot be fitted.
pub fn predict(problem: &Problem, terms: &[&Term]) -> Option<Prediction> {
    prediction(problem, terms, &problem.fit_loosely(terms, Part::Train)?)
}

/// The evidence for terms whose prediction `after` belongs to the loose fit `with`, against the prediction `before` of the terms `without`.
///
/// Deviations of the nominal model may imitate a term, which costs the loss of their prior. The fall of the error by the term is therefore
/// the rise of the error without the term at the same deviations. Evidence from the rows counts where the error exceeds the `inaccuracy` of
/// the laws even though the deviations are fitted again: with errors of scale `s₀` without the term and `s` with it, the torque that they
/// cannot imitate is `√(s₀² − s²)`. Thousands of rows show less than that, but not whose it is.
pub fn weighed(
    problem: &Problem,
    without: &[&Term],
    with: &Fitted,
    [before, after]: [&Prediction; 2],
    inaccuracy: Inaccuracy,
) -> Option<Vec<Evidence>> {
    let mut evidence = after.of_rows(before);
    if with.inertial != Treated::Fixed {
        let held = problem.fit_beside(without, with)?;
        for joint in with.joints.iter().copied() {
            let evidence = &mut evidence[joint];
            let alone = (before.scale[joint].powi(2) - after.scale[joint].powi(2)).max(0.0).sqrt();
            let least = inaccuracy.torque * problem.rms_torque(joint);
            if evidence.log_scale <= inaccuracy.log_scale || alone <= least {
                evidence.nats = evidence.nats.min(0.0);
            }
            evidence.log_scale = (held.solution.scale[joint] / with.solution.scale[joint]).ln();
        }
    }
    after.add_prior(before, &mut evidence);
    Some(evidence)
}

/// As [`predict`], with a given loose fit of all training rows, for the joints of that fit.
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
    Some(Prediction { joints, training, folds, scale, independence, prior_loss: fitted.prior_loss() })
}

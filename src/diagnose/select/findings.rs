//! From the terms of a selection to the entries of a report: parameters, probability, rivals.

use super::candidates::Candidate;
use super::confirm::Confirmed;
use super::selection::Selection;
use super::selection::Taken;
use crate::diagnose::evidence::probability::calibrated;
use crate::diagnose::fit::estimate;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::uncertainty::Uncertainty;
use crate::diagnose::options::{MODEL_ERROR, Options};
use crate::diagnose::result::{FoundEffect, Standing};
use crate::distributions::normal_upper_tail;

/// One entry per term, strongest first.
pub fn found(
    problem: &Problem,
    selection: &Selection,
    confirmed: &Confirmed,
    uncertainty: &Uncertainty,
    options: &Options,
) -> Vec<FoundEffect> {
    let mut entries: Vec<FoundEffect> = Vec::new();
    let mut position = 0;
    for taken in &selection.taken {
        let (confusable_with, probability) = rivals(taken, options);
        for term in &taken.terms {
            let names = term.own_joints().iter().map(|joint| problem.motion.model.joints[*joint].name.clone());
            let parameters = estimate::parameters(problem, term, position, &selection.fitted, uncertainty);
            let (evidence_nats, gain) = (confirmed.strength[position], confirmed.gains[position].clone());
            let at = selection.fitted.term_at[position];
            let own = at..at + term.coefficients();
            let size = uncertainty.size_in_errors(own, &selection.fitted.solution.coefficients);
            let standing = Standing { probability: probability * not_zero(size), evidence_nats, gain };
            let entry = FoundEffect::new(term.effect.about(), names.collect(), parameters, standing);
            entries.push(FoundEffect { effect: term.effect.label(), ..entry.beside(confusable_with.clone()) });
            position += 1;
        }
    }
    entries.sort_by(|a, b| b.evidence_nats.total_cmp(&a.evidence_nats));
    entries
}

/// Probability that a size of `z` standard errors is not zero: `1 − 2 (1 − Φ(z))`.
fn not_zero(z: f64) -> f64 {
    (1.0 - 2.0 * normal_upper_tail(z)).max(0.0)
}

/// Share of the evidence above which a rival cannot be rejected.
const CLOSE: f64 = 0.85;

/// Share of the evidence below which a rival is rejected even if its error is as small.
const FAR: f64 = 0.3;

/// Effects with nearly as much evidence, and the probability that the chosen effect is the right one.
fn rivals(taken: &Taken, options: &Options) -> (Vec<String>, f64) {
    let total: f64 = taken.evidence.iter().map(|evidence| evidence.nats).sum();
    let joints: Vec<usize> = taken.terms.iter().flat_map(|term| term.joints.clone()).collect();
    let own: usize = taken.terms.iter().map(|term| term.coefficients() + term.shape.len()).sum();
    // An inaccurate law costs evidence in proportion to the number of rows; the error that it leaves does not depend on that number.
    let worse = |rival: &Candidate| {
        let on = |joint: &usize| taken.evidence[*joint].log_scale - rival.evidence[*joint].log_scale;
        joints.iter().map(on).fold(f64::NEG_INFINITY, f64::max)
    };
    let close = |rival: &&Candidate| {
        let share = rival.total() / total;
        rival.sensible && (share > CLOSE || share > FAR && worse(rival) < MODEL_ERROR)
    };
    let names = taken.rivals.iter().filter(close).map(|rival| rival.effect().name().to_owned()).collect();
    let probability = probability(total, own, options, taken.rivals.iter().filter(|rival| rival.sensible));
    (names, probability)
}

/// Probability that an effect with this evidence is the true one. Every model is somewhat inaccurate, so differences of evidence count relative
/// to the evidence. A rival is penalised if it has more parameters than the effect. No effect at all is a rival too, with as much evidence
/// as inaccurate laws leave behind.
pub fn probability<'c>(total: f64, own: usize, options: &Options, rivals: impl Iterator<Item = &'c Candidate>) -> f64 {
    let unit = 0.02 * total + 3.0;
    let odds = |difference: f64| (difference / unit).exp();
    let of_rival = |rival: &Candidate| {
        let extra = rival.complexity().saturating_sub(own).min(1) as f64;
        odds(rival.total() - total - extra * (options.rules.tie * total + unit))
    };
    let of_rivals: f64 = rivals.map(of_rival).sum();
    calibrated(of_rivals + odds(options.rules.further - total))
}

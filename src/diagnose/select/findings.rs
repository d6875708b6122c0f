//! From the terms of a selection to the entries of a report: parameters, probability, rivals.

use super::certainty::certainty;
use super::confirm::Confirmed;
use super::selection::Selection;
use crate::diagnose::fit::estimate;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::uncertainty::Uncertainty;
use crate::diagnose::options::Rules;
use crate::diagnose::result::{FoundEffect, Standing};

/// One entry per term, strongest first.
pub fn found(
    problem: &Problem,
    selection: &Selection,
    confirmed: &Confirmed,
    uncertainty: &Uncertainty,
    rules: &Rules,
) -> Vec<FoundEffect> {
    let mut entries: Vec<FoundEffect> = Vec::new();
    let mut position = 0;
    for taken in &selection.taken {
        for term in &taken.terms {
            let names = term.own_joints().iter().map(|joint| problem.motion.model.joints[*joint].name.clone());
            let parameters = estimate::parameters(problem, term, position, &selection.fitted, uncertainty);
            let (evidence_nats, gain) = (confirmed.strength[position], confirmed.gains[position].clone());
            let (confusable_with, probability) =
                certainty(taken, (term, position), &parameters, selection, uncertainty, rules);
            let standing = Standing { probability, evidence_nats, gain };
            let entry = FoundEffect::new(term.effect.about(), names.collect(), parameters, standing);
            entries.push(FoundEffect { effect: term.effect.label(), ..entry.beside(confusable_with) });
            position += 1;
        }
    }
    entries.sort_by(|a, b| b.evidence_nats.total_cmp(&a.evidence_nats));
    entries
}

//! Substitutes: names given to something that the catalogue does not contain.
//!
//! If the true cause is not in the catalogue, the effect nearest to it gains evidence too. A substitute is recognised by comparison with
//! shapes without physics: the columns of a true effect match its torque, so no
//! [pattern](crate::diagnose::evidence::patterns) describes that torque better. If a pattern does, on rows that were not used for its fit and by more
//! than [`CLEARLY`], the name is withdrawn and the structure is reported as unexplained.

use super::selection::{Selection, Taken, terms_of};
use crate::diagnose::evidence::pattern_search::likeliest;
use crate::diagnose::evidence::prediction::{Prediction, predict};
use crate::diagnose::fit::problem::{Part, Problem, Term};

/// [1] Logarithm by which a pattern has to lower the error scale on one joint of the effect: more than the inaccuracy of an effect's law.
/// Patterns in the place of a true effect lowered it by at most 0.04, where they gained evidence at all (30 tuning machines, seeds 1404 to
/// 7000 of `benches/blind`); in the place of a substitute for an effect removed from the catalogue by 0.09 to 2.
const CLEARLY: f64 = 0.1;

/// Withdraws the names that a pattern describes better; `None` where the rest cannot be fitted.
pub fn withdraw(problem: &mut Problem, selection: &mut Selection) -> Option<()> {
    let mut withdrawn = false;
    while let Some(index) = (0..selection.taken.len()).find(|index| stands_in(problem, &selection.taken, *index)) {
        selection.taken.remove(index);
        selection.settle(problem)?;
        withdrawn = true;
    }
    if withdrawn {
        problem.count_independent(&selection.fitted);
    }
    Some(())
}

/// Whether patterns on the joints of an effect predict better than the effect, beside the others.
fn stands_in(problem: &Problem, taken: &[Taken], index: usize) -> bool {
    let all = terms_of(taken);
    let mut others: Vec<&Term> =
        taken.iter().enumerate().filter(|(other, _)| *other != index).flat_map(|(_, taken)| &taken.terms).collect();
    let joints: Vec<usize> = taken[index].terms.iter().flat_map(|term| term.joints.clone()).collect();
    let Some(fitted) = problem.fit_loosely(&others, Part::Train) else { return false };
    let patterns: Vec<_> =
        joints.iter().filter_map(|joint| likeliest(problem, &others, &fitted, *joint, &|_| true)).collect();
    others.extend(patterns.iter().map(|trial| &trial.term));
    let (Some(with_name), Some(with_patterns)) = (predict(problem, &all), predict(problem, &others)) else {
        return false;
    };
    let price: f64 = patterns.iter().map(|trial| (trial.tried as f64).ln()).sum();
    is_clearly_better(&with_patterns, &with_name, &joints, price)
}

/// Whether one model predicts better than another by more than the penalty [nats] for its choice.
fn is_clearly_better(one: &Prediction, other: &Prediction, joints: &[usize], price: f64) -> bool {
    let evidence = one.against(other);
    let nats: f64 = joints.iter().map(|joint| evidence[*joint].nats).sum();
    let most = joints.iter().map(|joint| evidence[*joint].log_scale).fold(f64::NEG_INFINITY, f64::max);
    nats > price && most > CLEARLY
}

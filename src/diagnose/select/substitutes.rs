//! Substitutes: names given to something that the catalogue does not contain.
//!
//! If the true cause is not in the catalogue, the effect nearest to it gains evidence too. A substitute is recognised by comparison with
//! shapes without physics: the columns of a true effect match its torque, so no
//! [pattern](crate::diagnose::evidence::patterns) describes that torque better. If a pattern does, on rows that were not used for its fit and by more
//! than [`CLEARLY`] on the joint where the name explains most, the name is withdrawn and the structure is reported as unexplained. Patterns may
//! also describe something else, on other joints or on the same: a name that lowers the error beside them by more than half as much as without
//! them is kept.

use super::confirm::names;
use super::selection::{Selection, Taken, terms_of};
use crate::diagnose::evidence::pattern_search::likeliest;
use crate::diagnose::evidence::prediction::{Prediction, predict};
use crate::diagnose::fit::problem::{Part, Problem};
use crate::diagnose::fit::term::Term;
use crate::diagnose::result::Withdrawn;

/// [1] Logarithm by which a pattern has to lower the error scale on the joint where the effect lowers it most: more than the inaccuracy of an effect's law.
/// Patterns in the place of a true effect lowered it by at most 0.04, where they gained evidence at all (30 tuning machines, seeds 1404 to
/// 7000 of `benches/blind`); in the place of a substitute for an effect removed from the catalogue by 0.09 to 2.
const CLEARLY: f64 = 0.1;

/// [1] Largest part of the fall of the error's logarithm that a name may keep beside patterns that replace it: half-way between a name that
/// they replace (0) and one that they do not affect (1). Not calibrated; on a recorded arm of six joints two ripples of a motor kept more
/// than the whole fall, since the patterns lower the other errors.
const KEPT: f64 = 0.5;

/// Withdraws the names that a pattern describes better; `None` where the rest cannot be fitted.
pub fn withdraw(problem: &mut Problem, selection: &mut Selection) -> Option<()> {
    let mut withdrawn = false;
    while let Some(index) = (0..selection.taken.len()).find(|index| stands_in(problem, &selection.taken, *index)) {
        let taken = selection.taken.remove(index);
        taken.terms.iter().for_each(|term| problem.bar(term));
        selection.replaced.push(Withdrawn {
            effect: taken.terms[0].effect.label(),
            joints: taken.terms.iter().flat_map(|term| names(problem, term)).collect(),
            reason: "a shape without physics describes its torque better: something that is not in the catalogue"
                .to_owned(),
        });
        selection.settle(problem)?;
        withdrawn = true;
    }
    if withdrawn {
        problem.count_independent(&selection.fitted);
    }
    Some(())
}

/// Whether patterns on the joints of an effect predict better than the effect, beside the others, and leave it little to explain.
fn stands_in(problem: &Problem, taken: &[Taken], index: usize) -> bool {
    let all = terms_of(taken);
    let mut others: Vec<&Term> =
        taken.iter().enumerate().filter(|(other, _)| *other != index).flat_map(|(_, taken)| &taken.terms).collect();
    let joints: Vec<usize> = taken[index].terms.iter().flat_map(|term| term.joints.clone()).collect();
    let Some(fitted) = problem.fit_loosely(&others, Part::Train) else { return false };
    let patterns: Vec<_> =
        joints.iter().filter_map(|joint| likeliest(problem, &others, &fitted, *joint, &|_| true)).collect();
    others.extend(patterns.iter().map(|trial| &trial.term));
    let mut both = all.clone();
    both.extend(patterns.iter().map(|trial| &trial.term));
    let price: f64 = patterns.iter().map(|trial| (trial.tried as f64).ln()).sum();
    let without_any = &others[..others.len() - patterns.len()];
    let replaced = || -> Option<bool> {
        let (with_name, with_patterns) = (predict(problem, &all)?, predict(problem, &others)?);
        let alone = with_name.against(&predict(problem, without_any)?);
        let fall = |joint: &usize| alone[*joint].log_scale;
        let most = joints.iter().copied().max_by(|a, b| fall(a).total_cmp(&fall(b)))?;
        if !is_clearly_better(&with_patterns, &with_name, (&joints, most), price) {
            return Some(false);
        }
        let beside = most_lowered(&predict(problem, &both)?, &with_patterns, &joints);
        Some(beside <= KEPT * fall(&most))
    };
    replaced().unwrap_or(false)
}

/// Largest fall of the error's logarithm on some joints, from one model to a better one.
fn most_lowered(better: &Prediction, other: &Prediction, joints: &[usize]) -> f64 {
    let evidence = better.against(other);
    joints.iter().map(|joint| evidence[*joint].log_scale).fold(f64::NEG_INFINITY, f64::max)
}

/// Whether one model predicts some joints better than another by more than the penalty [nats] for its choice, and the joint `most` clearly.
fn is_clearly_better(one: &Prediction, other: &Prediction, (joints, most): (&[usize], usize), price: f64) -> bool {
    let evidence = one.against(other);
    let nats: f64 = joints.iter().map(|joint| evidence[*joint].nats).sum();
    nats > price && evidence[most].log_scale > CLEARLY
}

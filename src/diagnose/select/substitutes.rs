//! Names that stand in for something that the catalogue lacks.
//!
//! Where what is wrong has no name, the effect that comes nearest to it gains evidence as well. It is told from a cause by what a shape
//! without any physics does in its place: the columns of an effect that is there are those of the torque that it makes, and none of the
//! [patterns](crate::diagnose::evidence::patterns) describes that torque better. Where one does, on rows that it was not fitted on and by more than
//! [`CLEARLY`], the name is withdrawn, and what remains is unexplained.

use super::selection::{Selection, Taken, resettle};
use crate::diagnose::evidence::pattern_search::likeliest;
use crate::diagnose::evidence::prediction::{Prediction, predict};
use crate::diagnose::fit::problem::{Part, Problem, Term};

/// [1] Logarithm by which a pattern has to lower the scale of the error on one joint of the effect at least: what the law of an effect does
/// not get right stays below it. Where a pattern in the place of a cause gained evidence at all, it did so by at most 0.04 (30 tuning
/// machines, seeds 1404 to 7000 of `benches/blind`); in that of stand-ins for an effect taken out of the catalogue by 0.09 to 2.
const CLEARLY: f64 = 0.1;

/// Withdraws the names that a pattern describes better; `None` where the rest cannot be fitted.
pub fn withdraw(problem: &mut Problem, selection: &mut Selection) -> Option<()> {
    let mut withdrawn = false;
    while let Some(index) = (0..selection.taken.len()).find(|index| stands_in(problem, &selection.taken, *index)) {
        selection.taken.remove(index);
        selection.fitted = resettle(problem, &mut selection.taken)?;
        withdrawn = true;
    }
    if withdrawn {
        problem.count_independent(&selection.fitted);
    }
    Some(())
}

/// Whether patterns on the joints of an effect predict better than it does, beside the others.
fn stands_in(problem: &Problem, taken: &[Taken], index: usize) -> bool {
    let all: Vec<&Term> = taken.iter().flat_map(|taken| &taken.terms).collect();
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

/// Whether one model predicts better than another by more than the price [nats] of choosing it.
fn is_clearly_better(one: &Prediction, other: &Prediction, joints: &[usize], price: f64) -> bool {
    let evidence = one.against(other);
    let nats: f64 = joints.iter().map(|joint| evidence[*joint].nats).sum();
    let most = joints.iter().map(|joint| evidence[*joint].log_scale).fold(f64::NEG_INFINITY, f64::max);
    nats > price && most > CLEARLY
}

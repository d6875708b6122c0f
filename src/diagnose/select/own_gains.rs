//! The gain of each effect of a selection on held-out data, see [`gains`](crate::diagnose::residuals::gains).

use rayon::prelude::*;

use super::selection::Selection;
use crate::diagnose::fit::problem::{FOLDS, Fitted, Part, Problem};
use crate::diagnose::fit::regression::NU;
use crate::diagnose::fit::term::Term;
use crate::diagnose::residuals::gains::{Judge, Residuals, TORQUE};
use crate::diagnose::result::EffectGain;
use crate::replay::Gain;
use crate::timeseries::root_mean_square;

/// The quantity in which the gain of an effect is given that the held-out data hardly show.
const ELSEWHERE: &str = "torque, each part of the training data predicted from the others";

/// Gains of the terms of a selection, in the order of [`Selection::terms`]. `strength` ranks them, and the first `given` terms
/// belong to the nominal model. `None` where a part of the terms cannot be fitted.
pub fn of_terms(problem: &Problem, selection: &Selection, given: usize, strength: &[f64]) -> Option<Vec<EffectGain>> {
    let terms = selection.terms();
    let judge = Judge::new(problem, &selection.as_recorded);
    let mut order: Vec<usize> = (given..terms.len()).collect();
    order.sort_by(|a, b| strength[*b].total_cmp(&strength[*a]));
    let all = residuals_with(problem, &terms, &selection.fitted);
    let mut gains: Vec<EffectGain> = terms.iter().map(|_| EffectGain::of(Gain::default(), TORQUE)).collect();
    let mut before: Residuals = selection.nominal.residuals.clone();
    let fits = |position: usize| -> Option<[Residuals; 2]> {
        let so_far = |other: usize| other < given || order[..=position].contains(&other);
        let after = if position + 1 == order.len() { all.clone() } else { fitted_with(problem, &terms, &so_far)? };
        Some([after, fitted_with(problem, &terms, &|other| other != order[position])?])
    };
    let fits = (0..order.len()).into_par_iter().map(fits).collect::<Option<Vec<_>>>()?;
    for (index, [after, without]) in order.iter().zip(fits) {
        let joints = &terms[*index].joints;
        let gain = judge.effect(joints, [&without, &all], [&before, &after]);
        gains[*index] = if gain.shown() || acts_in_held_out(problem, joints, [&without, &all]) {
            gain
        } else {
            let elsewhere = predicted_elsewhere(problem, &terms, *index);
            let elsewhere = elsewhere.map(|[without, with]| judge.compared_in_training(joints, [&without, &with]));
            match elsewhere.filter(|elsewhere| elsewhere.shown) {
                Some(shown) => EffectGain { gain_by_joint: gain.gain_by_joint, ..EffectGain::of(shown, ELSEWHERE) },
                None => gain,
            }
        };
        before = after;
    }
    Some(gains)
}

/// Whether a term acts in the held-out rows of a joint at least a tenth as strongly as in its training rows. A contact that no held-out motion reaches
/// cannot gain there.
fn acts_in_held_out(problem: &Problem, joints: &[usize], [without, with]: [&Residuals; 2]) -> bool {
    /// [1] With a hundredth of its squares, an effect that the training data show by twenty standard errors shows by two.
    const LEAST: f64 = 0.1;
    joints.iter().any(|joint| {
        let acts = |part: Part| {
            let rows = problem.rows(*joint, part);
            root_mean_square(&rows.iter().map(|row| without[*joint][*row] - with[*joint][*row]).collect::<Vec<_>>())
        };
        acts(Part::HeldOut) > LEAST * acts(Part::Train)
    })
}

/// Residuals of the training rows without and with a term, in each fold predicted by a fit to the others.
fn predicted_elsewhere(problem: &Problem, terms: &[&Term], index: usize) -> Option<[Residuals; 2]> {
    let without: Vec<&Term> = (0..terms.len()).filter(|other| *other != index).map(|other| terms[other]).collect();
    let of = |terms: &[&Term]| -> Option<Residuals> {
        let mut all: Residuals = vec![vec![0.0; problem.motion.rows()]; problem.baseline.len()];
        for fold in 0..FOLDS {
            let fitted = problem.fit(terms, Part::Without(fold), NU)?;
            for (joint, all) in all.iter_mut().enumerate() {
                let residual = problem.residual(terms, &fitted, joint);
                problem.rows(joint, Part::Fold(fold)).into_iter().for_each(|row| all[row] = residual[row]);
            }
        }
        Some(all)
    };
    Some([of(&without)?, of(terms)?])
}

/// Whether some terms together gain on held-out data: of two terms whose torques compensate each other, each gains beside the other, but
/// together they gain nothing. The gain has to be significant on rows weighted as for one effect, and there must be no significant loss on
/// all rows.
/// `None` where the other terms cannot be fitted.
pub fn gain_together(problem: &Problem, selection: &Selection, group: &[usize]) -> Option<bool> {
    let terms = selection.terms();
    let judge = Judge::new(problem, &selection.as_recorded);
    let mut joints: Vec<usize> = group.iter().flat_map(|index| terms[*index].joints.clone()).collect();
    joints.sort_unstable();
    joints.dedup();
    let all = residuals_with(problem, &terms, &selection.fitted);
    let without = fitted_with(problem, &terms, &|other| !group.contains(&other))?;
    let lost = judge.unweighted(&joints, [&without, &all]).interval_percent[1] < 0.0;
    Some(judge.compared(&joints, [&without, &all]).shown && !lost)
}

fn residuals_with(problem: &Problem, terms: &[&Term], fitted: &Fitted) -> Residuals {
    (0..problem.baseline.len()).map(|joint| problem.residual(terms, fitted, joint)).collect()
}

fn fitted_with(problem: &Problem, terms: &[&Term], picked: &dyn Fn(usize) -> bool) -> Option<Residuals> {
    let picked: Vec<&Term> = (0..terms.len()).filter(|index| picked(*index)).map(|index| terms[index]).collect();
    let fitted = problem.fit(&picked, Part::Train, NU)?;
    Some(residuals_with(problem, &picked, &fitted))
}

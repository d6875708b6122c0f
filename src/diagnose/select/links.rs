//! Links that are not as accurate as the model states: their gain on held-out data.

use nalgebra::DMatrix;

use super::selection::Selection;
use crate::diagnose::fit::inertial::{NUMBERS, Surprise};
use crate::diagnose::fit::problem::{Part, Problem};
use crate::diagnose::fit::regression::NU;
use crate::diagnose::residuals::gains::{Judge, Residuals};
use crate::diagnose::result::EffectGain;

/// A link with another inertia than the nominal one.
pub struct OtherLink {
    /// Its body, and the evidence that it is not as accurate as stated.
    pub surprise: Surprise,
    /// What the model loses with the nominal inertia of this link.
    pub gain: EffectGain,
}

/// The links of a selection with their gains; `None` where the model cannot be fitted without one.
pub fn other_links(problem: &mut Problem, selection: &Selection) -> Option<Vec<OtherLink>> {
    selection.links.clone().into_iter().map(|surprise| other_link(problem, selection, surprise)).collect()
}

fn other_link(problem: &mut Problem, selection: &Selection, surprise: Surprise) -> Option<OtherLink> {
    let terms = selection.terms();
    let residuals = |problem: &Problem| -> Option<Residuals> {
        let fitted = problem.fit(&terms, Part::Train, NU)?;
        Some((0..problem.baseline.len()).map(|joint| problem.residual(&terms, &fitted, joint)).collect())
    };
    let all = residuals(problem)?;
    let mut change = DMatrix::zeros(NUMBERS * problem.motion.joints.len(), 1);
    let own = problem.changes_of(surprise.body)? * problem.held()?;
    change.view_mut((NUMBERS * surprise.body, 0), (NUMBERS, 1)).copy_from(&own);
    let torque = problem.motion.regressed(&change);
    problem.add_held(&torque, -1.0);
    let without = residuals(problem);
    problem.add_held(&torque, 1.0);
    let without = without?;
    // The link moves its own joint and those below it.
    let joints: Vec<usize> =
        problem.joints().into_iter().filter(|joint| torque[*joint][0].iter().any(|x| *x != 0.0)).collect();
    let judge = Judge::new(problem, &selection.as_recorded);
    let gain = judge.effect(&joints, [&without, &all], [&without, &all]);
    Some(OtherLink { surprise, gain })
}

//! Structure that remains when no effect of the catalogue helps any more: named by its shape, not by a cause.
//!
//! [Patterns](crate::diagnose::evidence::patterns) are tried one after the other beside the effects, joint by joint, and judged as effects are: by what a
//! fit with the pattern gains on training rows that it was not fitted on. The best of them is reported, where it is one that a clean machine
//! would not show. One shape seldom is the whole of what is missing; that it is there says that something is.

use crate::diagnose::evidence::pattern_search::{likeliest, with_term};
use crate::diagnose::evidence::prediction::{Prediction, predict};
use crate::diagnose::fit::problem::{Fitted, Part, Problem, Term};
use crate::diagnose::fit::regression::NU;
use crate::diagnose::options::Rules;
use crate::diagnose::residuals::Residual;
use crate::diagnose::residuals::gains;
use crate::diagnose::result::{FitError, Split, Unexplained};

/// Part of the RMS torque that a pattern has to have: less is what the law of an effect or of friction does not get right. Patterns
/// with evidence enough on 16 clean machines (seeds 1000 to 1015 of `benches/blind`) stay below it.
const LEAST_AMPLITUDE: f64 = 0.01;
/// The same where the pattern gains on what is held out.
const LEAST_CONFIRMED: f64 = 0.005;
/// [%] of the torque held out beyond which nobody would say that a model explains it, whatever its shape: clean machines leave up to 12 %
/// (seeds 1000 to 1003 of `benches/blind`), a textbook's law of friction 4 % of a real carriage's force.
const LEFT: f64 = 40.0;
/// The same in floors of the sensors: less may be their noise.
const ABOVE_FLOOR: f64 = 5.0;

/// The strongest remaining pattern of each joint, where there is one that a clean machine would not show.
///
/// A pattern is sought in the rows of those sessions alone that `within` picks.
pub fn unexplained(
    problem: &Problem,
    terms: &[&Term],
    rules: &Rules,
    within: &(dyn Fn(usize) -> bool + Sync),
) -> Vec<Unexplained> {
    let Some(fitted) = problem.fit_loosely(terms, Part::Train) else { return Vec::new() };
    let Some(before) = predict(problem, terms) else { return Vec::new() };
    let of_joint = |joint| strongest(problem, terms, rules, within, &fitted, &before, joint);
    (0..problem.baseline.len()).filter_map(of_joint).collect()
}

fn strongest(
    problem: &Problem,
    terms: &[&Term],
    rules: &Rules,
    within: &(dyn Fn(usize) -> bool + Sync),
    fitted: &Fitted,
    before: &Prediction,
    joint: usize,
) -> Option<Unexplained> {
    let best = likeliest(problem, terms, fitted, joint, within)?;
    let with = with_term(terms, &best.term);
    let evidence = predict(problem, &with)?.against(before)[joint];
    let nats = evidence.nats - (best.tried as f64).ln();
    if nats <= rules.nats || evidence.log_scale <= rules.log_scale {
        return None;
    }
    let amplitude = amplitude(problem, &with_term(terms, &best.term), fitted, joint)?;
    let rows = problem.rows(joint, Part::Train);
    let torque = &problem.motion.joints[joint].torque;
    let power: f64 = rows.iter().map(|row| torque[*row].powi(2)).sum();
    let least = if gains_on_held_out(problem, terms, &with, joint) { LEAST_CONFIRMED } else { LEAST_AMPLITUDE };
    if amplitude < least * (power / rows.len().max(1) as f64).sqrt() {
        return None;
    }
    let model = &problem.motion.model.joints[joint];
    let pattern = format!("{}, {amplitude:.3} {}", best.words, model.kind.effort_unit());
    Some(Unexplained { joint: model.name.clone(), pattern })
}

/// Whether the last term lowers the error on held-out rows by more than chance.
fn gains_on_held_out(problem: &Problem, without: &[&Term], with: &[&Term], joint: usize) -> bool {
    let residuals = |terms: &[&Term]| -> Option<Vec<Vec<f64>>> {
        let fitted = problem.fit(terms, Part::Train, NU)?;
        Some((0..problem.baseline.len()).map(|joint| problem.residual(terms, &fitted, joint)).collect())
    };
    let (Some(before), Some(after)) = (residuals(without), residuals(with)) else { return false };
    gains::Judge::new(problem, &before).compared(&[joint], [&before, &after]).shown
}

/// What a model whose masses are a guess leaves of the torque: no cause is sought in it.
pub fn unjudged(problem: &Problem, residuals: &[Residual]) -> Vec<Unexplained> {
    let of_joint = |(joint, residual): (usize, &Residual)| {
        let m = &problem.motion.joints[joint];
        let power =
            |values: &[f64]| problem.rows(joint, Part::Train).iter().map(|row| values[*row].powi(2)).sum::<f64>();
        let share = 100.0 * (power(&residual.after) / power(&m.torque).max(1e-300)).sqrt();
        let model = &problem.motion.model.joints[joint];
        let pattern =
            format!("{share:.0} % of the torque; the model's masses are estimated, so no cause is sought in it");
        Unexplained { joint: model.name.clone(), pattern }
    };
    residuals.iter().enumerate().map(of_joint).collect()
}

/// What is left of the torque of joints of which no shape was `said`, where it is too much for an explanation.
pub fn shapeless(fit: &[FitError], said: &[Unexplained]) -> Vec<Unexplained> {
    let too_much = |one: &&FitError| {
        one.split == Split::HeldOut && one.after_percent > LEFT && one.after > ABOVE_FLOOR * one.floor
    };
    let silent = |one: &&FitError| said.iter().all(|known| known.joint != one.joint);
    let words = |one: &FitError| Unexplained {
        joint: one.joint.clone(),
        pattern: format!(
            "{:.0} % of the {}, {:.0} times what the sensors leave, in no shape that repeats (a control loop that shakes the joint looks so)",
            one.after_percent,
            one.quantity,
            one.after / one.floor.max(1e-300)
        ),
    };
    fit.iter().filter(too_much).filter(silent).map(words).collect()
}

/// RMS of what the last term takes of the residual times √2 [N·m or N]: the amplitude of a harmonic.
fn amplitude(problem: &Problem, terms: &[&Term], without: &Fitted, joint: usize) -> Option<f64> {
    let with = problem.fit_near(&problem.coupled(terms, &[joint]), terms, Part::Train, without)?;
    let (before, after) = (&without.solution.residual[joint], &with.solution.residual[joint]);
    let power: f64 = before.iter().zip(after).map(|(before, after)| (before - after).powi(2)).sum();
    Some((2.0 * power / before.len().max(1) as f64).sqrt())
}

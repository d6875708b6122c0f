//! Structure that remains when no further effect of the catalogue helps: described by its shape, not by a cause.
//!
//! [Patterns](crate::diagnose::evidence::patterns) are tried one after the other beside the effects, joint by joint. They are judged like effects, by
//! the gain of the fit with the pattern on training rows that were not used for that fit. The best pattern is reported, if a clean machine
//! would not show it. One shape is seldom all that is missing, but it shows that something is missing.

use crate::diagnose::evidence::pattern_search::{likeliest, with_term};
use crate::diagnose::evidence::prediction::{Prediction, predict};
use crate::diagnose::fit::extrapolation;
use crate::diagnose::fit::pose::rough_coulomb;
use crate::diagnose::fit::problem::{Fitted, Part, Problem};
use crate::diagnose::fit::regression::NU;
use crate::diagnose::fit::term::Term;
use crate::diagnose::options::Rules;
use crate::diagnose::residuals::Residual;
use crate::diagnose::residuals::carried_over::{CarriedOver, LEFT_CLEARLY};
use crate::diagnose::residuals::gains;
use crate::diagnose::result::{FitError, Split, Unexplained};
use crate::diagnose::rows::loads::{self, LeftOver};

/// Least amplitude of a pattern relative to the RMS torque: the inaccuracy of a law of an effect or of friction is smaller. Patterns
/// with enough evidence on 16 clean machines (seeds 1000 to 1015 of `benches/blind`) are below it.
const LEAST_AMPLITUDE: f64 = 0.01;
/// The same for a pattern that gains on held-out data.
const LEAST_CONFIRMED: f64 = 0.005;
/// [%] of the held-out torque above which a residual is unexplained, whatever its shape: clean machines leave up to 12 %
/// (seeds 1000 to 1003 of `benches/blind`), a textbook's law of friction 4 % of a real carriage's force.
const LEFT: f64 = 40.0;
/// Least residual in multiples of the sensors' floor: a smaller one may be their noise.
const ABOVE_FLOOR: f64 = 5.0;

/// Multiples of the floor that no clean machine of `benches/blind` reaches (at most 9, and 4.8 of 24 with seeds from 93000).
pub const FAR_ABOVE_FLOOR: f64 = 10.0;

/// [s] Shortest load that is reported, from the first to the last of its rows: as long as one of them is averaged, so that it shows in two that share no
/// sample. A flank that hits or a joint that sticks and slips loads a single row.
const SHORTEST: f64 = 0.2;

/// The strongest remaining pattern of each joint, if a clean machine would not show it.
///
/// A pattern is sought only in the rows of the sessions that `within` selects.
pub fn unexplained(
    problem: &Problem,
    terms: &[&Term],
    rules: &Rules,
    within: &(dyn Fn(usize) -> bool + Sync),
) -> Vec<Unexplained> {
    let Some(fitted) = problem.fit_loosely(terms, Part::Train) else { return Vec::new() };
    let Some(before) = predict(problem, terms) else { return Vec::new() };
    let of_joint = |joint| strongest(problem, terms, rules, within, &fitted, &before, joint);
    problem.joints().into_iter().filter_map(of_joint).collect()
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

/// Whether the last term lowers the error on held-out rows significantly.
fn gains_on_held_out(problem: &Problem, without: &[&Term], with: &[&Term], joint: usize) -> bool {
    let residuals = |terms: &[&Term]| -> Option<Vec<Vec<f64>>> {
        let fitted = problem.fit(terms, Part::Train, NU)?;
        Some((0..problem.baseline.len()).map(|joint| problem.residual(terms, &fitted, joint)).collect())
    };
    let (Some(before), Some(after)) = (residuals(without), residuals(with)) else { return false };
    gains::Judge::new(problem, &before).compared(&[joint], [&before, &after]).shown
}

/// Residual torque of a model with estimated masses: no cause is sought in it.
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

/// Residual torque of the joints without a pattern in `said`, where it is too large to count as explained, or to be that of the training data.
///
/// A torque that is missing all the time, such as that of a control loop that shakes the joint, shows in the typical residual and in the RMS.
pub fn shapeless(
    problem: &Problem,
    residuals: &[Residual],
    fit: &[FitError],
    said: &[Unexplained],
) -> Vec<Unexplained> {
    let judged = |one: &FitError| -> Option<Unexplained> {
        let joint = problem.motion.model.joints.iter().position(|joint| joint.name == one.joint)?;
        let carried = CarriedOver::to_held_out(problem, joint, &residuals[joint].after)?;
        let CarriedOver { left, percent, times } = carried;
        let floors = left / one.floor.max(1e-300);
        let unseen = carried.is_refuted() && floors > ABOVE_FLOOR;
        let too_much = (percent > LEFT && floors > ABOVE_FLOOR) || (percent > LEFT_CLEARLY && floors > FAR_ABOVE_FLOOR);
        let of_quantity = format!("{percent:.0} % of the {}, {floors:.0} times what the sensors leave", one.quantity);
        let pattern = if unseen {
            format!(
                "{of_quantity} and {times:.0} times what is left of the training data: something acts in the data held out that the others do not show, or those do not determine this joint"
            )
        } else if too_much {
            format!("{of_quantity}, in no shape that repeats (a control loop that shakes the joint looks like this)")
        } else {
            return None;
        };
        Some(Unexplained { joint: one.joint.clone(), pattern })
    };
    let silent = |one: &&FitError| said.iter().all(|known| known.joint != one.joint);
    fit.iter().filter(|one| one.split == Split::HeldOut).filter(silent).filter_map(judged).collect()
}

/// Loads that no floating link and no error of the model makes, on joints without a pattern in `said`: an episode of some seconds is no pattern of all
/// rows, and the typical residual does not contain it.
pub fn pressed(
    problem: &Problem,
    residuals: &[Residual],
    fitted: &Fitted,
    fit: &[FitError],
    said: &[Unexplained],
) -> Vec<Unexplained> {
    let motion = &problem.motion;
    let of_joint = |joint: usize| {
        let model = &motion.model.joints[joint];
        let floor = fit.iter().filter(|one| one.joint == model.name).map(|one| one.floor).fold(0.0, f64::max);
        let error = || extrapolation::errors(problem, fitted, joint);
        let torque = &residuals[joint].after;
        let left_over = LeftOver { torque, error: &error, coulomb: rough_coulomb(problem, joint) };
        let zone = &problem.zones[joint];
        let least = loads::unlike(zone, &left_over, &problem.held_out).max(FAR_ABOVE_FLOOR * floor);
        let loaded = loads::pressed(zone, motion, joint, &left_over, least);
        let (rows, lasts) = loads::lasting(motion, &loaded, SHORTEST);
        let of_data = if rows.iter().all(|(row, _)| problem.held_out[*row]) { " of the data held out" } else { "" };
        let (row, largest) = rows.into_iter().max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()))?;
        let place = motion.joints[joint].q[row];
        let pattern = format!(
            "a torque of up to {:.3} {} for {lasts:.1} s in all{of_data}, most at {place:.3} {}: no gap and no inaccuracy of the model makes as much",
            largest.abs(),
            model.kind.effort_unit(),
            model.kind.position_unit(),
        );
        Some(Unexplained { joint: model.name.clone(), pattern })
    };
    let silent = |joint: &usize| said.iter().all(|known| known.joint != motion.model.joints[*joint].name);
    problem.joints().into_iter().filter(silent).filter_map(of_joint).collect()
}

/// RMS torque that the last term explains, times √2 [N·m or N]: the amplitude of a harmonic.
fn amplitude(problem: &Problem, terms: &[&Term], without: &Fitted, joint: usize) -> Option<f64> {
    let with = problem.fit_near(&problem.coupled(terms, &[joint]), terms, Part::Train, without)?;
    let (before, after) = (&without.solution.residual[joint], &with.solution.residual[joint]);
    let power: f64 = before.iter().zip(after).map(|(before, after)| (before - after).powi(2)).sum();
    Some((2.0 * power / before.len().max(1) as f64).sqrt())
}

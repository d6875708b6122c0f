//! From sessions to a regression problem with rows, held-out part and zones.

use super::extrapolation;
use super::problem::{Part, Problem};
use super::regression;
use crate::diagnose::options::Options;
use crate::diagnose::rows::division::{Division, held_out_rows};
use crate::diagnose::rows::inertia::typical_inertia;
use crate::diagnose::rows::loads::{self, LeftOver};
use crate::diagnose::rows::standstill::Standstill;
use crate::diagnose::rows::widths::FAITHFUL;
use crate::diagnose::rows::zones::Widest;
use crate::diagnose::rows::{observe, zones};
use crate::effects::{Catalogue, Diagnosable, LeftOut};
use crate::error::{Error, Result};
use crate::robot::{Masses, Model};
use crate::timeseries::TimeSeries;

/// The regression problem of sessions, with the zones and held-out rows.
pub fn pose<'m>(
    model: &'m Model,
    sessions: &[&TimeSeries],
    division: Division,
    options: &Options,
) -> Result<Problem<'m>> {
    let motion = observe::observe(model, sessions, &typical_inertia(model), FAITHFUL)?;
    let held_out = held_out_rows(&motion, sessions, division);
    let mut problem = Problem::new(motion, held_out);
    // With estimated masses, the torque is no evidence for an effect.
    problem.name_from(match model.masses {
        Masses::Known => of_wide_rows(&options.catalogue),
        Masses::Estimated => Catalogue::empty(),
    });
    problem.deviate();
    problem.standstill = Standstill::of(&problem.motion, &sessions[..division.trained()]);
    find_zones(&mut problem)?;
    Ok(problem)
}

/// Finds the rigid zones. Where unknown gaps leave too few rows, they are taken for narrower.
fn find_zones(problem: &mut Problem) -> Result<()> {
    for widest in Widest::ALL {
        problem.widest_gap = widest;
        find_zones_of(problem, widest);
        if problem.joints().into_iter().all(|joint| has_many_rows(problem, joint)) {
            break;
        }
    }
    leave_out_still_joints(problem)?;
    add_overwhelmed(problem);
    Ok(())
}

/// Whether the rows of a joint are a good part of those in which it moves.
fn has_many_rows(problem: &Problem, joint: usize) -> bool {
    let moving = problem.motion.joints[joint].direction.iter().zip(&problem.held_out);
    let moving = moving.filter(|(direction, held_out)| **direction != 0.0 && !**held_out).count();
    problem.rows(joint, Part::Train).len() >= FEWEST_ROWS.max((LEAST_SHARE * moving as f64) as usize)
}

/// Finds the rigid zones with a rough Coulomb friction, and again with the torque that a first fit leaves.
fn find_zones_of(problem: &mut Problem, widest: Widest) {
    let coulomb: Vec<f64> = (0..problem.baseline.len()).map(|joint| rough_coulomb(problem, joint)).collect();
    let zones = |problem: &Problem, left_over: Option<&[Vec<f64>]>, margins: &zones::Margins| {
        zones::rigid_zone(&problem.motion, &coulomb, left_over, &problem.held_out, margins, widest)
    };
    problem.zones = zones(problem, None, &zones::RIGID);
    clear_left_out(problem);
    if let Some(fitted) = problem.fit(&[], Part::Train, regression::NU) {
        let of_joint = |joint| problem.residual(&[], &fitted, joint);
        let left_over: Vec<Vec<f64>> = (0..coulomb.len()).map(of_joint).collect();
        problem.zones = zones(problem, Some(&left_over), &zones::RIGID);
        problem.judged = zones(problem, Some(&left_over), &zones::JUDGED);
        clear_left_out(problem);
    }
    for joint in problem.joints() {
        // If a motion never stays long on a flank, judge it on the rows that are fitted.
        problem.floating[joint] =
            [Part::Train, Part::HeldOut].iter().any(|part| problem.judged_rows(joint, *part).len() < FEWEST_ROWS);
        if problem.floating[joint] {
            problem.judged[joint].clone_from(&problem.zones[joint]);
        }
    }
}

/// Adds the rows under an overwhelming load to the zones of the fit.
fn add_overwhelmed(problem: &mut Problem) {
    let Some(fitted) = problem.fit(&[], Part::Train, regression::NU) else { return };
    let with_overwhelmed = |joint: usize| {
        let torque = problem.residual(&[], &fitted, joint);
        let error = || extrapolation::errors(problem, &fitted, joint);
        let left_over = LeftOver { torque: &torque, error: &error, coulomb: rough_coulomb(problem, joint) };
        (joint, loads::with_overwhelmed(&problem.zones[joint], &problem.motion, joint, &left_over, &problem.held_out))
    };
    let zones: Vec<_> = problem.joints().into_iter().map(with_overwhelmed).collect();
    zones.into_iter().for_each(|(joint, zone)| problem.zones[joint] = zone);
}

fn clear_left_out(problem: &mut Problem) {
    let all = 0..problem.baseline.len();
    let left_out: Vec<usize> = all.filter(|joint| problem.motion.joints[*joint].left_out.is_some()).collect();
    left_out.into_iter().for_each(|joint| problem.clear(joint));
}

/// Rows that a joint needs for the fit, and for the error figures.
const FEWEST_ROWS: usize = 30;
/// [1] Part of the rows in which a joint moves that a fit needs: an arm of six joints in ordinary motion kept 1 % with gaps of any width, and its
/// error then hung on a second of the recording.
const LEAST_SHARE: f64 = 0.05;

/// Leaves out joints without the rows to fit their friction to; an error where no other is left.
fn leave_out_still_joints(problem: &mut Problem) -> Result<()> {
    let rows = |problem: &Problem, joint: usize| problem.rows(joint, Part::Train).len();
    let judged = problem.joints();
    let most = judged.iter().copied().max_by_key(|joint| rows(problem, *joint));
    if let Some(joint) = most.filter(|joint| rows(problem, *joint) < FEWEST_ROWS) {
        return Err(Error::TooLittleData {
            quantity: "torque",
            joint: problem.motion.model.joints[joint].name.clone(),
            found: rows(problem, joint),
            unit: "samples of steady contact",
            needed: FEWEST_ROWS,
            advice: "move the joints of the model for some seconds in both directions",
        });
    }
    for joint in judged {
        if rows(problem, joint) < FEWEST_ROWS {
            problem.leave_out(joint, LeftOut::HardlyMoves);
        }
    }
    Ok(())
}

/// Median friction torque while the joint moves, in the training data.
pub fn rough_coulomb(problem: &Problem, joint: usize) -> f64 {
    let m = &problem.motion.joints[joint];
    let moving = (0..problem.motion.rows()).filter(|row| !problem.held_out[*row] && m.direction[*row].abs() > 0.99);
    let mut levels: Vec<f64> = moving.map(|row| (m.torque[row] - m.rigid[row]) * m.direction[row]).collect();
    if levels.is_empty() {
        return 0.0;
    }
    let middle = levels.len() / 2;
    levels.select_nth_unstable_by(middle, f64::total_cmp).1.max(0.0)
}

pub fn nothing_moves(model: &Model) -> Error {
    Error::TooLittleData {
        quantity: "friction",
        joint: model.joints.first().map(|joint| joint.name.clone()).unwrap_or_default(),
        found: 0,
        unit: "directions of motion",
        needed: 2,
        advice: "move every joint in both directions",
    }
}

/// The effects of a catalogue that show in wide rows.
pub fn of_wide_rows(catalogue: &Catalogue) -> Catalogue {
    catalogue.iter().filter(|effect| !effect.diagnosable().is_some_and(needs_narrow_rows)).collect()
}

/// Whether an effect does not show in wide rows, because it repeats at an order that their kernels filter out.
pub fn needs_narrow_rows(effect: &dyn Diagnosable) -> bool {
    effect.harmonic().is_some_and(|harmonic| harmonic.in_narrow_rows.is_some())
}

//! What has changed between a recording of the healthy machine and one of now.
//!
//! ```text
//!   rows of both recordings ─▶ one baseline + effects that were there before   (shared: an error of the model is on both sides)
//!                              + changes, columns that are zero in the rows of the reference ─▶ evidence on rows held out
//!   reversals of each side  ─▶ its gap                                         ─▶ difference against both errors
//! ```
//!
//! A change of what the baseline fits freely cannot be told from its value by one recording; by two it can. Candidates are the terms of
//! friction, the rotor's inertia and every effect of the catalogue, in the rows of now alone. What both sides get wrong alike cancels.

mod changed;
mod gap;
mod inertia;
mod judge;
mod outcome;
mod quantity;
mod robust;
mod select;
mod spread;

use super::candidates::Evidence;
use super::problem::{Part, Problem, Term};
use super::regression::NU;
use super::result::Diagnosis;
use super::selection::{self, Selection, Taken};
use super::standstill::Standstill;
use super::{Options, conclude, nothing_moves, pose, rough_coulomb, timing, views};
use crate::effects::Diagnosable;
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::TimeSeries;
pub use gap::gentlest;
use select::Sides;

/// Names what is another size `now` than in the `reference`, and what is there now and was not before; the model that comes
/// with it is the machine as it is now. `hold_out` are further sessions of now to judge on.
///
/// # Errors
/// As [`diagnose`](super::diagnose), for either recording.
pub fn compare(
    model: &Model,
    reference: &[TimeSeries],
    now: &[TimeSeries],
    hold_out: &[TimeSeries],
    options: &Options,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Diagnosis> {
    progress("smoothing", 0.0);
    let before = aligned(model, &reference.iter().collect::<Vec<_>>());
    let after = aligned(model, &now.iter().chain(hold_out).collect::<Vec<_>>());
    let sessions: Vec<&TimeSeries> = before.iter().chain(&after).collect();
    let trained = before.len() + now.len();
    let sides = Sides { reference: 0..before.len(), now: before.len()..sessions.len() };

    progress("what was there before", 0.1);
    let own: Vec<&TimeSeries> = before.iter().collect();
    let mut healthy = pose(model, &own, own.len(), options)?;
    let were = selection::select(&mut healthy, &options.rules, &mut |_, _| {}).ok_or_else(|| nothing_moves(model))?;

    // Its rows are not needed beside those of both sides.
    drop(healthy);
    progress("fitting both", 0.3);
    let mut problem = pose(model, &sessions, trained, options)?;
    problem.catalogue = select::catalogue(&options.catalogue, &sides);
    problem.standstill = difference_at_rest(&problem, &sessions, before.len());
    problem.settle(&[]).ok_or_else(|| nothing_moves(model))?;
    let shared = shared_terms(&problem, &were);
    drop(were);
    let mut changes = select::select(&mut problem, shared, &options.catalogue, &options.rules, progress)
        .ok_or_else(|| nothing_moves(model))?;
    progress("judging changes", 0.8);
    inertia::drop_inertias(&mut changes);
    select::refresh(&mut problem, &mut changes).ok_or_else(|| nothing_moves(model))?;
    let standings = judge::keep_significant(&mut problem, &mut changes, &options.catalogue, &sides)
        .ok_or_else(|| nothing_moves(model))?;

    changes.estimates =
        select::estimates_beside_companions(&problem, &changes, &sides).ok_or_else(|| nothing_moves(model))?;
    let mut found = outcome::of_regression(&problem, &changes, &standings);
    let coulomb: Vec<f64> = (0..model.joints.len()).map(|joint| rough_coulomb(&problem.motion, joint)).collect();
    if let Some((closer, standings)) = inertia::look_closer(&mut problem, &changes, &coulomb, &sides) {
        found.extend(outcome::of_inertias(&problem, &closer, &standings));
        changes.taken = closer.taken;
    }
    progress("measuring the gap on both sides", 0.85);
    let friction =
        [problem.motion.joints.iter().map(|joint| joint.friction).collect(), outcome::friction_now(&problem, &found)];
    let gaps = if options.backlash {
        gap::both_sides(model, [&sessions[sides.reference.clone()], &sessions[before.len()..trained]], &friction)
    } else {
        [vec![None; model.joints.len()], vec![None; model.joints.len()]]
    };
    found.extend(outcome::of_gaps(model, &gaps));
    found.sort_by(|a, b| b.probability.total_cmp(&a.probability));

    let mut diagnosis = report(model, &sessions, trained, &problem, changes, options, progress)?;
    outcome::complete(&mut diagnosis, &problem, found, &gaps, &options.catalogue);
    Ok(diagnosis)
}

/// Sessions with their currents in step with the motion.
fn aligned(model: &Model, sessions: &[&TimeSeries]) -> Vec<TimeSeries> {
    match timing::late_current(model, sessions) {
        Some(late) => sessions.iter().map(|session| timing::aligned(session, late.lag.value)).collect(),
        None => sessions.iter().map(|session| (*session).clone()).collect(),
    }
}

/// What the current sensors read at rest now, less what they read then.
fn difference_at_rest(problem: &Problem, sessions: &[&TimeSeries], reference: usize) -> Vec<Option<Standstill>> {
    let before = Standstill::of(&problem.motion, &sessions[..reference]);
    let now = Standstill::of(&problem.motion, &sessions[reference..]);
    let difference = |(before, now): (Option<Standstill>, Option<Standstill>)| {
        let (before, now) = (before?, now?);
        Some(Standstill { mean: now.mean - before.mean, std_error: now.std_error.hypot(before.std_error) })
    };
    before.into_iter().zip(now).map(difference).collect()
}

/// What explains both sides: the rotors' inertias, which may be off, and the effects that were there before.
fn shared_terms(problem: &Problem, were: &Selection) -> Vec<Term> {
    let inertia = quantity::rotor_inertia();
    let joints = 0..problem.motion.joints.len();
    let inertias = joints
        .filter(|joint| inertia.applies(&problem.motion, *joint))
        .map(|joint| Term::new(&problem.motion, inertia, &[joint], Vec::new()));
    let effects =
        were.terms().into_iter().map(|term| Term::new(&problem.motion, term.effect, &term.joints, term.shape.clone()));
    inertias.chain(effects).collect()
}

/// The report of the joint fit; `before` in it is the fit without any change.
fn report(
    model: &Model,
    sessions: &[&TimeSeries],
    trained: usize,
    problem: &Problem,
    changes: select::Changes,
    options: &Options,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Diagnosis> {
    let shared: Vec<&Term> = changes.shared.iter().collect();
    let without = problem.fit(&shared, Part::Train, f64::INFINITY).ok_or_else(|| nothing_moves(model))?;
    let unchanged =
        (0..problem.baseline.len()).map(|joint| views::residual(problem, &shared, &without, joint)).collect();
    let fitted = problem.fit(&changes.terms(), Part::Train, NU).ok_or_else(|| nothing_moves(model))?;
    let of_both = changes.shared.into_iter().map(|term| Taken {
        terms: vec![term],
        evidence: vec![Evidence::default(); problem.baseline.len()],
        rivals: Vec::new(),
    });
    let taken = of_both.chain(changes.taken).collect();
    let selection = Selection { taken, first_round: changes.first_round, fitted };
    let data = conclude::Data { model, sessions, trained, late: None, shaken: false, as_recorded: Some(unchanged) };
    let options = Options { backlash: false, ..options.clone() };
    conclude::diagnosis(&data, problem, &selection, &options, progress)
}

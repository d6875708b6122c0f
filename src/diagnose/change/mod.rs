//! Two recordings → what differs between them: a reference of the healthy machine, and a recording of now.
//!
//! ```text
//!   rows of both recordings ─▶ one baseline + effects of the reference         (shared: an error of the model is on both sides)
//!                              + changes, columns that are zero in the rows of the reference ─▶ evidence on folds of the training rows
//!   reversals of each side  ─▶ its gap                                         ─▶ difference against both errors
//! ```
//!
//! A change of a quantity that the baseline fits freely cannot be separated from its value with one recording; with two it can. Candidates are
//! the terms of friction, the rotor's inertia and every effect of the catalogue, in the rows of now only. Errors common to both sides cancel.
//!
//! - `select`: selection of the changes; `quantity`: quantities of the baseline that may change
//! - `judge`: comparison with chance and with natural variation; `spread`: natural variation between sessions
//! - `robust`: standard errors for correlated errors
//! - `inertia`: changes of rotor inertias; `gap`: changes of gaps; `delays`: changes of a late current
//! - `consequences`: changes that follow from a new effect; `outcome`: the report, and the models in the reference and now

mod consequences;
mod delays;
mod gap;
mod inertia;
mod judge;
mod outcome;
mod quantity;
mod robust;
mod select;
mod spread;

use std::borrow::Cow;

use crate::diagnose::conclude::unexplained;
use crate::diagnose::evidence::prediction::Evidence;
use crate::diagnose::fit::pose::{nothing_moves, pose, rough_coulomb};
use crate::diagnose::fit::problem::{Part, Problem};
use crate::diagnose::fit::regression::NU;
use crate::diagnose::fit::term::Term;
use crate::diagnose::instruments::current_lag::Aligned;
use crate::diagnose::instruments::{ON_ROWS_OF_TWO, current_lag};
use crate::diagnose::mistakes::guessed;
use crate::diagnose::options::Options;
use crate::diagnose::result::{Change, Diagnosis, Findings, Parts};
use crate::diagnose::rows::division::Division;
use crate::diagnose::rows::measured::{as_measured, complete};
use crate::diagnose::rows::standstill::Standstill;
use crate::diagnose::select::confirm;
use crate::diagnose::select::selection;
use crate::diagnose::select::selection::{Nominal, Selection, Taken};
use crate::diagnose::select::{naming, substitutes};
use crate::diagnose::{conclude, mistakes};
use crate::effects::applied;
use crate::effects::{Catalogue, Diagnosable};
use crate::error::Result;
use crate::robot::{Masses, Model};
use crate::timeseries::TimeSeries;
use gap::SideGap;
use select::{Changes, Sides};

/// Reports quantities that differ between `reference` and `now`, and effects that are new. The model in the result is the machine as it is now.
/// `hold_out` are further sessions of now, used for judging only.
///
/// # Errors
/// As [`diagnose`](crate::diagnose::diagnose), for either recording.
pub fn compare(
    model: &Model,
    reference: &[TimeSeries],
    now: &[TimeSeries],
    hold_out: &[TimeSeries],
    options: &Options,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Diagnosis> {
    let given = applied(model, &options.catalogue)?;
    let model = &given.model;
    let recorded: Vec<&TimeSeries> = reference.iter().chain(now).chain(hold_out).collect();
    let division = Division::of(&recorded, recorded.len() - hold_out.len(), options.held_out_share);
    let (usable, dead) = mistakes::without_dead_channels(model, &recorded);
    let usable: Vec<&TimeSeries> = usable.iter().map(AsRef::as_ref).collect();
    let (reference, now) = usable.split_at(reference.len());
    let (now, hold_out) = now.split_at(now.len() - hold_out.len());
    let seen = as_measured(model, &usable);
    let mut diagnosis = compare_as_measured(&seen, reference, [now, hold_out], division, options, progress)?;
    diagnosis.dead_channels = dead;
    diagnosis.method.listed_effects = conclude::listed_effects(&given);
    complete(&mut diagnosis.baseline_model, model);
    complete(&mut diagnosis.extended_model, model);
    Ok(diagnosis)
}

/// The comparison with a model as the recordings see it.
fn compare_as_measured(
    model: &Model,
    reference: &[&TimeSeries],
    [now, hold_out]: [&[&TimeSeries]; 2],
    division: Division,
    options: &Options,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Diagnosis> {
    let today = [now, hold_out].concat();
    let of_before = division.for_sessions(reference.len(), reference.len());
    let of_after = division.for_sessions(now.len(), now.len() + hold_out.len());
    let given = model;
    let model = &*guessed::with_constants(given, reference, of_before);
    let mut suspected = mistakes::suspected_by_part(model, reference, of_before);
    suspected.extend(mistakes::suspected_by_part(model, &today, of_after));
    if !suspected.is_empty() {
        return Ok(mistakes::diagnosis(given, suspected, true, options));
    }
    progress("smoothing", 0.0);
    let before = Side::new(model, reference.to_vec(), of_before, options)?;
    let after = Side::new(model, today, of_after, options)?;
    let earlier = delays::changed(model, [&before.late, &after.late]);
    let (before, after) = (before.sessions, after.sessions);
    let sessions: Vec<&TimeSeries> = before.iter().chain(&after).map(AsRef::as_ref).collect();
    let sides = Sides { reference: 0..before.len(), now: before.len()..sessions.len() };

    progress("finding the effects of the reference", 0.1);
    let own: Vec<&TimeSeries> = before.iter().map(AsRef::as_ref).collect();
    let were = effects_of(model, &own, of_before, options)?;
    progress("fitting both recordings", 0.3);
    let mut problem = posed(model, &sessions, division, &sides, options)?;
    let shared = shared_terms(&problem, &were);
    drop(were);
    let (changes, mut found) =
        changes(&mut problem, shared, &sides, options, progress).ok_or_else(|| nothing_moves(model))?;
    progress("measuring the gap on both sides", 0.85);
    let gaps = gaps(&problem, &found, [&own, &sessions[before.len()..division.trained()]], options);
    found.extend(outcome::of_gaps(model, &gaps));
    found.sort_by(|a, b| b.standing.total_cmp(&a.standing));

    let both = Both { model, sessions: &sessions, division, sides: &sides, earlier };
    let mut parts = report(both, &mut problem, changes, options, progress)?;
    consequences::withdraw(&mut parts, &problem, &mut found);
    outcome::complete(&mut parts, &problem, found, &gaps);
    Ok(parts.assembled())
}

/// Effects in a recording of the healthy machine.
fn effects_of(model: &Model, sessions: &[&TimeSeries], division: Division, options: &Options) -> Result<Selection> {
    let mut healthy = pose(model, sessions, division, options)?;
    let mut found = || {
        let mut selection = selection::select(&mut healthy, &options.rules, &mut |_, _| {})?;
        substitutes::withdraw(&mut healthy, &mut selection)?;
        naming::name(&mut healthy, &mut selection, [&options.rules, &options.rules])?;
        Some(selection)
    };
    found().ok_or_else(|| nothing_moves(model))
}

/// Both recordings as one problem, in which changes are sought that wide rows show; without inertias where masses are estimated.
fn posed<'m>(
    model: &'m Model,
    sessions: &[&TimeSeries],
    division: Division,
    sides: &Sides,
    options: &Options,
) -> Result<Problem<'m>> {
    let mut problem = pose(model, sessions, division, options)?;
    problem.causes = select::causes(&problem.catalogue, model.masses, sides);
    problem.catalogue = Catalogue::empty();
    problem.standstill = difference_at_rest(&problem, sessions, sides.reference.len());
    problem.settle(&[]).ok_or_else(|| nothing_moves(model))?;
    Ok(problem)
}

/// The changes that evidence supports and that exceed the natural variation between sessions; `None` where nothing can be fitted.
fn changes(
    problem: &mut Problem,
    shared: Vec<Term>,
    sides: &Sides,
    options: &Options,
    progress: &mut dyn FnMut(&str, f64),
) -> Option<(Changes, Vec<Change>)> {
    let mut changes = select::select(problem, shared, &options.rules, progress)?;
    progress("judging changes", 0.8);
    inertia::drop_inertias(&mut changes);
    select::refresh(problem, &mut changes)?;
    let standings = judge::keep_significant(problem, &mut changes, sides)?;
    changes.estimates = select::estimates_beside_companions(problem, &changes, sides)?;
    let mut found = outcome::of_regression(problem, &changes, &standings);
    let coulomb: Vec<f64> = (0..problem.baseline.len()).map(|joint| rough_coulomb(problem, joint)).collect();
    if problem.motion.model.masses == Masses::Known
        && let Some((closer, standings)) = inertia::look_closer(problem, &changes, &coulomb, sides)
    {
        found.extend(outcome::of_inertias(problem, &closer, &standings));
        changes.taken = closer.taken;
    }
    Some((changes, found))
}

/// The gap of each joint in both recordings, with the friction of each.
fn gaps(
    problem: &Problem,
    found: &[Change],
    sessions: [&[&TimeSeries]; 2],
    options: &Options,
) -> [Vec<Option<SideGap>>; 2] {
    let model = problem.motion.model;
    if !options.backlash {
        return [vec![None; model.joints.len()], vec![None; model.joints.len()]];
    }
    let before = problem.motion.joints.iter().map(|joint| joint.friction).collect();
    gap::both_sides(model, sessions, &[before, outcome::friction_now(problem, found)])
}

/// One of the two recordings, with its currents in step with the motion.
struct Side<'s> {
    sessions: Vec<Cow<'s, TimeSeries>>,
    late: Option<Aligned>,
}

impl<'s> Side<'s> {
    fn new(model: &Model, recorded: Vec<&'s TimeSeries>, division: Division, options: &Options) -> Result<Self> {
        let late = match model.masses {
            Masses::Known => current_lag::align(model, &recorded, division, options)?,
            Masses::Estimated => None,
        };
        let mut late = late.filter(|late| !late.sessions.is_empty());
        let sessions = match &mut late {
            Some(late) => std::mem::take(&mut late.sessions).into_iter().map(Cow::Owned).collect(),
            None => recorded.into_iter().map(Cow::Borrowed).collect(),
        };
        Ok(Self { sessions, late })
    }
}

/// Readings of the current sensors at rest now, minus those in the reference.
fn difference_at_rest(problem: &Problem, sessions: &[&TimeSeries], reference: usize) -> Vec<Option<Standstill>> {
    let before = Standstill::of(&problem.motion, &sessions[..reference]);
    let now = Standstill::of(&problem.motion, &sessions[reference..]);
    let difference = |(before, now): (Option<Standstill>, Option<Standstill>)| {
        let (before, now) = (before?, now?);
        Some(Standstill { mean: now.mean - before.mean, std_error: now.std_error.hypot(before.std_error) })
    };
    before.into_iter().zip(now).map(difference).collect()
}

/// Terms of both sides: the rotors' inertias, whose nominal values may be wrong, and the effects of the reference.
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

/// Both recordings, and what was found before their rows were computed.
struct Both<'b> {
    model: &'b Model,
    sessions: &'b [&'b TimeSeries],
    division: Division,
    sides: &'b Sides,
    earlier: Findings,
}

/// The report of the joint fit; `before` in it is the fit without changes.
fn report(
    both: Both,
    problem: &mut Problem,
    changes: Changes,
    options: &Options,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Parts> {
    let Both { model, sessions, division, sides, earlier } = both;
    let shared: Vec<&Term> = changes.shared.iter().collect();
    let without = problem.fit(&shared, Part::Train, f64::INFINITY).ok_or_else(|| nothing_moves(model))?;
    problem.hold(&changes.estimates.fitted);
    let unchanged: Vec<Vec<f64>> =
        (0..problem.baseline.len()).map(|joint| problem.residual(&shared, &without, joint)).collect();
    let fitted = problem.fit(&changes.terms(), Part::Train, NU).ok_or_else(|| nothing_moves(model))?;
    let given = changes.shared.len();
    let of_both = changes.shared.into_iter().map(|term| Taken {
        terms: vec![term],
        evidence: vec![Evidence::default(); problem.baseline.len()],
        rivals: Vec::new(),
    });
    let taken = of_both.chain(changes.taken).collect();
    let nominal = Nominal {
        residuals: unchanged.clone(),
        friction: problem.motion.joints.iter().map(|joint| joint.friction).collect(),
        rotors: problem.rotors(&fitted),
    };
    let first_round = changes.first_round;
    let (replaced, residues) = (Vec::new(), Vec::new());
    let mut selection = Selection { taken, first_round, fitted, nominal, as_recorded: unchanged, replaced, residues };
    let is_effect = |term: &Term| quantity::find(term.effect.name()).is_none();
    let confirmed =
        confirm::confirm(problem, &mut selection, given, &is_effect, None).ok_or_else(|| nothing_moves(model))?;
    let data = conclude::Data { model, sessions, division, earlier, instruments: &ON_ROWS_OF_TWO, shaken: false };
    let options = Options { backlash: false, ..options.clone() };
    let mut parts = conclude::conclude(&data, problem, &selection, &confirmed, &options, progress)?;
    // A residual in both recordings is an error of the model and no change; a shape only in the recording of now is a change.
    let now = |session: usize| sides.now.contains(&session);
    parts.findings.unexplained = unexplained::unexplained(problem, &selection.terms(), &options.rules, &now);
    parts.findings.unexplained.extend(data.earlier.unexplained);
    Ok(parts)
}

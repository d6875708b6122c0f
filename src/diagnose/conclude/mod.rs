//! Selection and instruments → the parts of a diagnosis: parameters, gains, gaps, residual plots, models.
//!
//! Takes a confirmed selection, runs the instruments that need a fit, and gives the parts of a diagnosis.
//! - `gaps`: gaps that the model file does not give
//! - `link_load`: whether an effect prevents the measurement of a gap
//! - `delay`: the delay of currents, from currents in step
//! - `implausible`: a nominal model that would have to be less accurate than it states
//! - `remaining`: what no effect explains, in words; it calls `odd_sessions`: sessions that differ from the others, `unexplained`: structure, and
//!   `undecided`: effects that could explain it, with too little evidence
//! - `extend`: the baseline model and the extended model
//! - `records`: candidates and method for the report

pub mod delay;
/// The models that come with a diagnosis.
pub mod extend;
mod gaps;
mod implausible;
mod link_load;
mod odd_sessions;
mod records;
mod remaining;
mod undecided;
/// Structure that no effect explains.
pub mod unexplained;

pub use records::listed_effects;
use std::collections::BTreeMap;

use crate::diagnose::fit::estimate;
use crate::diagnose::fit::pose::nothing_moves;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::term::Term;
use crate::diagnose::fit::torque_scale::TorqueScale;
use crate::diagnose::fit::uncertainty::Uncertainty;
use crate::diagnose::instruments::two_encoders::Encoders;
use crate::diagnose::instruments::{FittedRows, Instrument, removal};
use crate::diagnose::options::Options;
use crate::diagnose::residuals::Residual;
use crate::diagnose::residuals::errors;
use crate::diagnose::residuals::{floor, maps, shares, spectra};
use crate::diagnose::result::{BaselineEstimate, Findings, FoundEffect, Measured, Parts};
use crate::diagnose::rows::division::Division;
use crate::diagnose::rows::inertia::typical_inertia;
use crate::diagnose::select::confirm::Confirmed;
use crate::diagnose::select::findings::found;
use crate::diagnose::select::selection::Selection;
use crate::effects::{Catalogue, Scope};
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::TimeSeries;
use extend::Identified;
use gaps::MeasuredGap;
use link_load::Loaded;
use remaining::Remaining;

/// Inputs of the conclusion, beside the problem.
pub struct Data<'d> {
    /// The nominal machine.
    pub model: &'d Model,
    /// Sessions as in the problem, with a late current corrected.
    pub sessions: &'d [&'d TimeSeries],
    /// Division into training and held-out data.
    pub division: Division,
    /// What was named or withdrawn before the problem was built.
    pub earlier: Findings,
    /// The instruments to run beside the fit.
    pub instruments: &'d [&'d dyn for<'s> Instrument<FittedRows<'s>>],
    /// Whether a fast torque was removed: its remainder shakes the joints at their reversals, so no reversal is judged.
    pub shaken: bool,
}

/// Computes all parts of a diagnosis.
///
/// # Errors
/// The baseline cannot be fitted by plain least squares.
pub fn conclude(
    data: &Data,
    problem: &Problem,
    selection: &Selection,
    confirmed: &Confirmed,
    options: &Options,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Parts> {
    progress("estimating parameters", 0.85);
    let Data { model, sessions, division, .. } = *data;
    let terms = selection.terms();
    let residuals = residuals(problem, &terms, selection);
    let uncertainty = Uncertainty::new(problem, &terms, &selection.fitted).ok_or_else(|| nothing_moves(model))?;
    let mut findings = Findings {
        effects: found(problem, selection, confirmed, &uncertainty, &options.rules),
        withdrawn: confirmed.withdrawn.clone(),
        unexplained: Vec::new(),
    };
    delay::refine(data, problem, selection, &mut findings.effects, options);
    findings.merge(data.earlier.clone());
    let left: Vec<Vec<f64>> = residuals.iter().map(|residual| residual.after.clone()).collect();
    let scene = FittedRows { problem, sessions, division, options, left: &left, shaken: data.shaken };
    let mut encoders = Encoders::default();
    progress("measuring what torque does not show", 0.88);
    for instrument in data.instruments {
        let reading = instrument.measure(&scene)?;
        findings.merge(reading.findings);
        encoders = reading.encoders.unwrap_or(encoders);
    }
    progress("measuring the gap", 0.9);
    let gaps = gaps(data, problem, selection, &findings.effects, &encoders.gaps, options);
    gaps::blur(&mut findings.effects, model, &gaps, &options.catalogue);
    in_true_torque(problem, &mut findings.effects, &uncertainty, &options.catalogue);
    findings.effects.sort_by(|a, b| b.evidence_nats.total_cmp(&a.evidence_nats));
    progress("drawing residuals", 0.95);
    let floor = floor::floor(problem, sessions, &typical_inertia(model));
    let fit = errors::fit_errors(problem, &residuals, &floor);
    let remaining = Remaining { problem, selection, sessions, residuals: &residuals, floor: &floor, fit: &fit };
    findings.unexplained = remaining.unexplained(std::mem::take(&mut findings.unexplained), &options.rules);
    let [baseline_model, extended_model] =
        models(problem, selection, &findings, &gaps, &encoders.other_gaps, &options.catalogue);
    let method = records::method(problem, sessions, division);
    Ok(Parts {
        candidates: records::records(problem, selection, &findings.withdrawn, options),
        findings,
        fit: fit.into_iter().chain(encoders.fit).collect(),
        baseline: baseline(problem, selection, &uncertainty, sessions, &gaps),
        two_encoders: encoders.joints,
        shares: shares::shares(problem, &residuals, &floor),
        maps: maps::maps(problem, &residuals, &floor),
        order_spectrum: spectra::by_order(problem, &residuals, &floor),
        frequency_spectrum: spectra::by_frequency(problem, &residuals, &floor),
        extended_model,
        baseline_model,
        series: errors::series(problem, sessions, &residuals),
        ..Parts::new(model, method, &options.catalogue)
    })
}

/// Converts the parameters of effects of a joint from torque as the nominal model computes it to true torque.
fn in_true_torque(problem: &Problem, effects: &mut [FoundEffect], uncertainty: &Uncertainty, catalogue: &Catalogue) {
    let of_joint = |found: &&mut FoundEffect| {
        catalogue.find(&found.effect).is_some_and(|effect| effect.about().scope == Scope::Joint)
    };
    for found in effects.iter_mut().filter(of_joint) {
        let first = |name: &String| problem.motion.model.joints.iter().position(|joint| joint.name == *name);
        let Some(joint) = found.joints.first().and_then(first) else { continue };
        let scale = TorqueScale::of(problem, joint, uncertainty);
        found.parameters.values_mut().for_each(|measured| scale.correct(measured));
    }
}

/// The gap of each joint. The estimate assumes that only friction, inertia and gravity act while the gap is crossed, so the torque of effects is
/// removed first, or they are put into the model's gravity.
fn gaps(
    data: &Data,
    problem: &Problem,
    selection: &Selection,
    effects: &[FoundEffect],
    seen: &[Option<Measured>],
    options: &Options,
) -> Vec<MeasuredGap> {
    if !options.backlash {
        return vec![MeasuredGap::default(); data.model.joints.len()];
    }
    let trained = &data.sessions[..data.division.trained()];
    let without = removal::without(problem, selection, trained, &|_| true);
    let mut gaps = gaps::measured(data.model, &without.iter().collect::<Vec<_>>(), problem, selection, seen);
    drop(without);
    let held = gaps.iter().any(|gap| gap.held);
    if let Some(loaded) = Loaded::new(data.model, effects, &options.catalogue).filter(|_| held) {
        let without = removal::without(problem, selection, trained, &|term| !loaded.contains(term));
        gaps::measure_held(&mut gaps, &loaded, &without.iter().collect::<Vec<_>>(), problem, selection);
    }
    gaps
}

/// The nominal model with the fitted baseline, and the same with the effects. Without effects both have the same friction.
fn models(
    problem: &Problem,
    selection: &Selection,
    findings: &Findings,
    gaps: &[MeasuredGap],
    other_gaps: &[(usize, f64)],
    catalogue: &Catalogue,
) -> [Model; 2] {
    let (model, factors) = problem.deviating_model();
    let friction: Vec<_> = problem.motion.joints.iter().map(|joint| joint.friction).collect();
    let shares: Vec<_> = gaps.iter().map(|gap| gap.link_share).collect();
    let gaps: Vec<_> = gaps.iter().map(MeasuredGap::value).collect();
    let rotors = problem.rotors(&selection.fitted);
    let judged = problem.joints();
    let after = Identified {
        judged: &judged,
        factors: &factors,
        friction: &friction,
        rotors: &rotors,
        gaps: &gaps,
        shares: &shares,
    };
    let before = match findings.effects.is_empty() {
        true => after,
        false => Identified { friction: &selection.nominal.friction, rotors: &selection.nominal.rotors, ..after },
    };
    let baseline = extend::with_baseline(&model, &before);
    let extended = extend::with_baseline(&model, &after);
    let mut extended = extend::with_effects(&model, &extended, &findings.effects, catalogue);
    for (joint, gap) in other_gaps {
        extended.joints[*joint].backlash = Some(*gap);
    }
    [baseline, extended]
}

fn residuals(problem: &Problem, terms: &[&Term], selection: &Selection) -> Vec<Residual> {
    let of_joint = |(joint, before): (usize, &Vec<f64>)| Residual {
        before: before.clone(),
        after: problem.residual(terms, &selection.fitted, joint),
    };
    selection.as_recorded.iter().enumerate().map(of_joint).collect()
}

fn baseline(
    problem: &Problem,
    selection: &Selection,
    uncertainty: &Uncertainty,
    sessions: &[&TimeSeries],
    gaps: &[MeasuredGap],
) -> BTreeMap<String, BaselineEstimate> {
    let mut estimates = BTreeMap::new();
    for joint in problem.joints() {
        let model = &problem.motion.model.joints[joint];
        let mut friction = estimate::friction(problem, joint, &selection.fitted, uncertainty);
        let scale = TorqueScale::of(problem, joint, uncertainty);
        friction.values_mut().for_each(|measured| scale.correct(measured));
        let torque_offset = estimate::offsets(problem, joint, &selection.fitted, uncertainty, sessions);
        let MeasuredGap { measured: backlash, left_out: backlash_left_out, .. } = gaps[joint].clone();
        let rotor_inertia = estimate::rotor_inertia(problem, joint, &selection.fitted, uncertainty);
        let estimate = BaselineEstimate { friction, rotor_inertia, backlash, backlash_left_out, torque_offset };
        estimates.insert(model.name.clone(), estimate);
    }
    estimates
}

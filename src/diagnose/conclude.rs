//! From a selection to a diagnosis: parameters, gains, rivals, views.

use std::collections::BTreeMap;

use super::candidates::Candidate;
use super::confirm::{self, Confirmed};
use super::division::Division;
use super::estimate;
use super::gaps::Gap;
use super::probability::calibrated;
use super::problem::{Problem, Term};
use super::result::{
    BaselineEstimate, CandidateRecord, Diagnosis, EffectGain, FoundEffect, Measured, Method, Unexplained, Verdict,
    Withdrawn,
};
use super::selection::{MODEL_ERROR, Selection, Taken};
use super::uncertainty::Uncertainty;
use super::views::{self, Residual};
use super::{
    Options, command, extend, floor, gaps, maps, mended, reversal, shares, slip, spectra, two_encoders,
    typical_inertia, unexplained,
};
use crate::error::Result;
use crate::robot::{Masses, Model};
use crate::timeseries::TimeSeries;

/// What a diagnosis is made of, beside the problem.
pub struct Data<'d> {
    /// The nominal machine.
    pub model: &'d Model,
    /// Sessions as the problem has them, a late current mended.
    pub sessions: &'d [&'d TimeSeries],
    /// Which part of them was trained on.
    pub division: Division,
    /// What was named, or withdrawn, before the problem was posed.
    pub earlier: Earlier,
    /// Whether a fast torque was taken out: what is left of it shakes the joints where they turn around, and no turn is judged.
    pub shaken: bool,
}

/// What was found before the rows of the problem were made.
#[derive(Debug, Clone, Default)]
pub struct Earlier {
    /// Effects whose action is not in the rows any more.
    pub effects: Vec<FoundEffect>,
    /// Effects without a gain.
    pub withdrawn: Vec<Withdrawn>,
    /// What no effect of the catalogue explains.
    pub unexplained: Vec<Unexplained>,
}

/// Puts everything together.
///
/// # Errors
/// The baseline cannot be fitted by plain least squares.
pub fn diagnosis(
    data: &Data,
    problem: &Problem,
    selection: &Selection,
    confirmed: &Confirmed,
    options: &Options,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Diagnosis> {
    progress("estimating parameters", 0.85);
    let Data { model, sessions, division, .. } = *data;
    let trained = division.trained();
    let terms = selection.terms();
    let residuals = residuals(problem, &terms, selection);
    let uncertainty =
        Uncertainty::new(problem, &terms, &selection.fitted).ok_or_else(|| super::nothing_moves(model))?;
    let mut effects = found(problem, selection, confirmed, &uncertainty, options);
    let mut withdrawn = confirmed.withdrawn.clone();
    let mut add = |effects: &mut Vec<FoundEffect>, seen: Vec<FoundEffect>| {
        let (named, without_gain) = confirm::part(seen, &options.catalogue);
        withdrawn.extend(without_gain);
        merge(effects, named);
    };
    add(&mut effects, data.earlier.effects.clone());
    add(&mut effects, unanswered(problem, data, options));
    let (steps, unconfirmed) = slip::found(problem, sessions, division);
    add(&mut effects, steps);
    progress("comparing encoders", 0.88);
    let encoders = two_encoders::found(problem, sessions, options);
    add(&mut effects, encoders.effects);
    progress("measuring the gap", 0.9);
    let gaps = if options.backlash {
        // Rotor and link cross the gap under friction and inertia alone: what was named would push them.
        let mended = mended::without(problem, selection, &sessions[..trained], &|_| true);
        gaps::measured(model, &mended.iter().collect::<Vec<_>>(), problem, selection, &encoders.gaps)
    } else {
        vec![Gap::default(); model.joints.len()]
    };
    let gap_values: Vec<_> = gaps.iter().map(|gap| gap.measured.as_ref().map(|gap| gap.value)).collect();
    gaps::blur(&mut effects, model, &gap_values, &options.catalogue);
    if !data.shaken {
        add(&mut effects, at_turns(data, problem, &residuals));
    }
    effects.sort_by(|a, b| b.evidence_nats.total_cmp(&a.evidence_nats));
    withdrawn.extend(data.earlier.withdrawn.iter().cloned());
    let friction: Vec<_> = problem.motion.joints.iter().map(|joint| joint.friction).collect();
    let shares: Vec<_> = gaps.iter().map(|gap| gap.link_share).collect();
    let nominal = if effects.is_empty() { &friction } else { &selection.nominal.friction };
    let baseline_model = extend::with_baseline(model, nominal, &gap_values, &shares);
    let extended_model = extend::with_baseline(model, &friction, &gap_values, &shares);
    let mut extended_model = extend::with_effects(model, &extended_model, &effects, &options.catalogue);
    for (joint, gap) in &encoders.other_gaps {
        extended_model.joints[*joint].backlash = Some(*gap);
    }
    let mut unexplained = match model.masses {
        Masses::Known => unexplained::unexplained(problem, &terms, &options.rules, &|_| true),
        Masses::Estimated => unexplained::unjudged(problem, &residuals),
    };
    unexplained.extend(data.earlier.unexplained.iter().cloned());
    unexplained.extend(encoders.unexplained);
    unexplained.extend(unconfirmed);
    progress("drawing residuals", 0.95);
    let floor = floor::floor(problem, sessions, &typical_inertia(model));
    let fit = views::fit_errors(problem, &residuals, &floor);
    unexplained.extend(unexplained::shapeless(&fit, &unexplained));
    Ok(Diagnosis {
        schema: Diagnosis::SCHEMA,
        versions: BTreeMap::from([
            ("lostmotion", env!("CARGO_PKG_VERSION")),
            ("rapier3d", crate::plant::RAPIER_VERSION),
        ]),
        verdict: Verdict::of(!effects.is_empty(), !unexplained.is_empty()),
        mistakes: Vec::new(),
        changes: None,
        candidates: records(problem, selection, &withdrawn, options),
        effects,
        withdrawn,
        fit: fit.into_iter().chain(encoders.fit).collect(),
        replay: Vec::new(),
        baseline: baseline(problem, selection, &uncertainty, sessions, &gaps),
        unexplained,
        two_encoders: encoders.joints,
        method: method(problem, sessions, division, options),
        shares: shares::shares(problem, &residuals, &floor),
        maps: maps::maps(problem, &residuals, &floor),
        order_spectrum: spectra::by_order(problem, &residuals, &floor),
        frequency_spectrum: spectra::by_frequency(problem, &residuals, &floor),
        extended_model,
        baseline_model,
        catalogue: options.catalogue.clone(),
        series: views::series(problem, sessions, &residuals),
    })
}

fn residuals(problem: &Problem, terms: &[&Term], selection: &Selection) -> Vec<Residual> {
    let of_joint = |(joint, before): (usize, &Vec<f64>)| Residual {
        before: before.clone(),
        after: views::residual(problem, terms, &selection.fitted, joint),
    };
    selection.as_recorded.iter().enumerate().map(of_joint).collect()
}

/// The effect that commands without a current are, joint by joint; its gain is that of the current inside the band.
fn unanswered(problem: &Problem, data: &Data, options: &Options) -> Vec<FoundEffect> {
    let found = problem.catalogue.diagnosable().find(|effect| effect.of_dead_band(0.0).is_some());
    let Some(effect) = found else { return Vec::new() };
    let about = effect.about();
    let of_joint = |(index, joint): (usize, &crate::robot::JointModel)| {
        let band = command::dead_band(data.model, index, data.sessions, data.division)?;
        if band.nats <= options.rules.nats {
            return None;
        }
        let values = effect.of_dead_band(band.width.value)?;
        let specs = about.parameters.iter().zip(values);
        let measured = |value: f64, unit: &'static str| Measured { value, std_error: band.width.std_error, unit };
        Some(FoundEffect {
            effect: about.name.to_owned(),
            joints: vec![joint.name.clone()],
            kind: about.kind,
            parameters: specs
                .map(|(spec, value)| (spec.name.to_owned(), measured(value, spec.unit_for(joint.kind))))
                .collect(),
            probability: probability(band.nats, about.parameters.len(), options, std::iter::empty()),
            evidence_nats: band.nats,
            gain: EffectGain::of(band.gain, "current within the band"),
            confusable_with: Vec::new(),
            separate_by: about.separate_by.to_owned(),
        })
    };
    data.model.joints.iter().enumerate().filter_map(of_joint).collect()
}

/// Adds what an instrument sees more directly than the torque along the motion does; what both see is one effect.
fn merge(effects: &mut Vec<FoundEffect>, seen: Vec<FoundEffect>) {
    for mut effect in seen {
        if let Some(known) =
            effects.iter().position(|known| known.effect == effect.effect && known.joints[0] == effect.joints[0])
        {
            let known = effects.remove(known);
            for (name, measured) in known.parameters {
                effect.parameters.entry(name).or_insert(measured);
            }
            effect.probability = effect.probability.max(known.probability);
            effect.evidence_nats = effect.evidence_nats.max(known.evidence_nats);
        }
        effects.push(effect);
    }
}

/// One entry for each term, strongest first.
pub fn found(
    problem: &Problem,
    selection: &Selection,
    confirmed: &Confirmed,
    uncertainty: &Uncertainty,
    options: &Options,
) -> Vec<FoundEffect> {
    let mut entries: Vec<FoundEffect> = Vec::new();
    let mut position = 0;
    for taken in &selection.taken {
        let (confusable_with, probability) = rivals(taken, options);
        for term in &taken.terms {
            let about = term.effect.about();
            entries.push(FoundEffect {
                effect: about.name.to_owned(),
                joints: term.joints.iter().map(|joint| problem.motion.model.joints[*joint].name.clone()).collect(),
                kind: about.kind,
                parameters: estimate::parameters(problem, term, position, &selection.fitted, uncertainty),
                probability,
                evidence_nats: confirmed.strength[position],
                gain: confirmed.gains[position].clone(),
                separate_by: separate_by(about.separate_by, &confusable_with),
                confusable_with: confusable_with.clone(),
            });
            position += 1;
        }
    }
    entries.sort_by(|a, b| b.evidence_nats.total_cmp(&a.evidence_nats));
    entries
}

/// The experiment that tells an effect from its rivals, by name where there are any.
fn separate_by(experiment: &str, rivals: &[String]) -> String {
    if rivals.is_empty() { experiment.to_owned() } else { format!("against {}: {experiment}", rivals.join(", ")) }
}

/// Share of the evidence at which a rival cannot be rejected.
const CLOSE: f64 = 0.85;
/// Share of the evidence below which a rival is rejected whatever it leaves.
const FAR: f64 = 0.3;
/// Effects whose evidence came close, and the probability that the right one was taken.
fn rivals(taken: &Taken, options: &Options) -> (Vec<String>, f64) {
    let total: f64 = taken.evidence.iter().map(|evidence| evidence.nats).sum();
    let joints: Vec<usize> = taken.terms.iter().flat_map(|term| term.joints.clone()).collect();
    let own: usize = taken.terms.iter().map(|term| term.coefficients() + term.shape.len()).sum();
    // A law that is not quite right costs evidence in proportion to the rows; what it leaves of the error costs the same whatever their number.
    let worse = |rival: &Candidate| {
        let on = |joint: &usize| taken.evidence[*joint].log_scale - rival.evidence[*joint].log_scale;
        joints.iter().map(on).fold(f64::NEG_INFINITY, f64::max)
    };
    let close = |rival: &&Candidate| {
        let share = rival.total() / total;
        rival.sensible && (share > CLOSE || share > FAR && worse(rival) < MODEL_ERROR)
    };
    let names = taken.rivals.iter().filter(close).map(|rival| rival.effect().name().to_owned()).collect();
    let probability = probability(total, own, options, taken.rivals.iter().filter(|rival| rival.sensible));
    (names, probability)
}

/// Probability that an effect of this evidence is what is named: the evidence is that of a model which is never quite right, so that
/// differences count relative to it; a rival pays for parameters that it needs beyond those of the effect. Nothing is a rival too, with
/// as much as laws that are not quite right leave behind.
fn probability<'c>(total: f64, own: usize, options: &Options, rivals: impl Iterator<Item = &'c Candidate>) -> f64 {
    let unit = 0.02 * total + 3.0;
    let odds = |difference: f64| (difference / unit).exp();
    let of_rival = |rival: &Candidate| {
        let extra = rival.complexity().saturating_sub(own).min(1) as f64;
        odds(rival.total() - total - extra * (options.rules.tie * total + unit))
    };
    let of_rivals: f64 = rivals.map(of_rival).sum();
    calibrated(of_rivals + odds(options.rules.further - total))
}

/// The effects that the turns of the joints tell of. A gap that was measured as if there were none may stand for what they do.
fn at_turns(data: &Data, problem: &Problem, residuals: &[Residual]) -> Vec<FoundEffect> {
    let left: Vec<Vec<f64>> = residuals.iter().map(|residual| residual.after.clone()).collect();
    reversal::found(problem, data.sessions, &left)
}

fn baseline(
    problem: &Problem,
    selection: &Selection,
    uncertainty: &Uncertainty,
    sessions: &[&TimeSeries],
    gaps: &[Gap],
) -> BTreeMap<String, BaselineEstimate> {
    let mut estimates = BTreeMap::new();
    for (joint, model) in problem.motion.model.joints.iter().enumerate() {
        let friction = estimate::friction(problem, joint, &selection.fitted, uncertainty);
        let torque_offset = estimate::offsets(problem, joint, &selection.fitted, uncertainty, sessions);
        let Gap { measured: backlash, left_out: backlash_left_out, .. } = gaps[joint].clone();
        estimates.insert(model.name.clone(), BaselineEstimate { friction, backlash, backlash_left_out, torque_offset });
    }
    estimates
}

fn records(
    problem: &Problem,
    selection: &Selection,
    withdrawn: &[Withdrawn],
    options: &Options,
) -> Vec<CandidateRecord> {
    let named = |candidate: &Candidate| {
        selection.taken.iter().any(|taken| taken.terms[0].effect.name() == candidate.effect().name())
    };
    let record = |candidate: &Candidate| {
        let joints = candidate.joints();
        let rules = &options.rules;
        let (total, log_scale) = (candidate.total(), candidate.log_scale());
        let named = named(candidate);
        let not_confirmed = withdrawn.iter().find(|one| one.effect == candidate.effect().name());
        let reason = if named {
            format!("evidence {total:.0} nats alone")
        } else if let Some(withdrawn) = not_confirmed {
            withdrawn.reason.clone()
        } else if !candidate.sensible {
            "its parameters would lie outside their ranges".to_owned()
        } else if !rules.support(total, log_scale) {
            format!("evidence {total:.1} nats, {:.1} % of the error: below what is asked", 100.0 * log_scale)
        } else {
            format!("evidence {total:.0} nats alone, superfluous beside what was named")
        };
        CandidateRecord {
            effect: candidate.effect().name().to_owned(),
            joints: joints.iter().map(|joint| problem.motion.model.joints[*joint].name.clone()).collect(),
            gain_percent: 100.0 * (1.0 - (-log_scale).exp()),
            threshold_percent: 100.0 * (1.0 - (-rules.log_scale).exp()),
            named,
            reason,
        }
    };
    selection.first_round.iter().map(record).collect()
}

fn method(problem: &Problem, sessions: &[&TimeSeries], division: Division, options: &Options) -> Method {
    let widths = &problem.motion.half_width;
    let half_width = [widths.iter().copied().fold(f64::INFINITY, f64::min), widths.iter().copied().fold(0.0, f64::max)];
    let rigid: Vec<String> = problem
        .zones
        .iter()
        .zip(&problem.motion.model.joints)
        .map(|(zone, joint)| {
            let share = zone.iter().filter(|rigid| **rigid).count() as f64 / zone.len().max(1) as f64;
            format!("{}: {:.0} % of the rows", joint.name, 100.0 * share)
        })
        .collect();
    let held_out = if division.by_session() {
        sessions[division.trained()..].iter().map(|session| session.name.as_str()).collect::<Vec<_>>().join(", ")
    } else {
        format!("the last {:.0} % of each session", 100.0 * options.held_out_share)
    };
    Method {
        filter: "biweight kernel without phase shift, the same on torque and motion, as narrow as the encoder allows".to_owned(),
        half_width,
        zones: format!(
            "left out: 0.1 s before to 0.2 s after reversals, 0.1 s before to 0.15 s after a change of flank (0.4 and 0.3 s of what errors are judged on), joints with a gap only and no longer than it takes; fitted: {}",
            rigid.join(", ")
        ),
        baseline: "Coulomb, Stribeck and viscous friction, both directions alike; the gap; the zero of a recorded torque, one a session; masses and inertias stay as the model file gives them".to_owned(),
        held_out,
    }
}

//! From a selection to a diagnosis: parameters, gains, rivals, views.

use std::collections::BTreeMap;

use super::baseline::JointBaseline;
use super::candidates::{Candidate, Evidence};
use super::estimate;
use super::gaps::Gap;
use super::probability::calibrated;
use super::problem::{Part, Problem, Term};
use super::regression::NU;
use super::result::{BaselineEstimate, CandidateRecord, Diagnosis, FoundEffect, Measured, Method, Verdict};
use super::selection::{Selection, Taken, evidence_beside};
use super::timing::Late;
use super::uncertainty::Uncertainty;
use super::views::{self, Residual};
use super::{
    Options, command, extend, floor, gaps, maps, mended, reversal, shares, slip, spectra, two_encoders,
    typical_inertia, unexplained,
};
use crate::effects::SymmetricFriction;
use crate::error::Result;
use crate::robot::{Masses, Model};
use crate::timeseries::TimeSeries;

/// What a diagnosis is made of, beside the problem.
pub struct Data<'d> {
    /// The nominal machine.
    pub model: &'d Model,
    /// Sessions as the problem has them, a late current mended.
    pub sessions: &'d [&'d TimeSeries],
    /// How many of them were trained on.
    pub trained: usize,
    /// How late the current was, where that was noticeable.
    pub late: Option<Late>,
    /// Whether a fast torque was taken out: what is left of it shakes the joints where they turn around, and no turn is judged.
    pub shaken: bool,
    /// Residuals of the nominal model before that was mended.
    pub as_recorded: Option<Vec<Vec<f64>>>,
}

/// Puts everything together.
///
/// # Errors
/// The baseline cannot be fitted by plain least squares.
pub fn diagnosis(
    data: &Data,
    problem: &Problem,
    selection: &Selection,
    options: &Options,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Diagnosis> {
    progress("estimating parameters", 0.85);
    let Data { model, sessions, trained, .. } = *data;
    let terms = selection.terms();
    let residuals = residuals(problem, &terms, selection, data);
    let uncertainty =
        Uncertainty::new(problem, &terms, &selection.fitted).ok_or_else(|| super::nothing_moves(model))?;
    let mut effects = found(problem, selection, &uncertainty, options);
    effects.extend(delayed(problem, data));
    effects.extend(unanswered(problem, data, options));
    effects.extend(slip::found(problem, sessions));
    progress("comparing encoders", 0.88);
    let encoders = two_encoders::found(problem, sessions, options);
    merge(&mut effects, encoders.effects);
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
        effects.extend(at_turns(data, problem, &residuals));
    }
    let friction: Vec<_> = problem.motion.joints.iter().map(|joint| joint.friction).collect();
    let shares: Vec<_> = gaps.iter().map(|gap| gap.link_share).collect();
    let nominal = if effects.is_empty() { None } else { nominal_friction(problem) };
    let nominal = nominal.unwrap_or_else(|| friction.clone());
    let baseline_model = extend::with_baseline(model, &nominal, &gap_values, &shares);
    let extended_model = extend::with_baseline(model, &friction, &gap_values, &shares);
    let mut extended_model = extend::with_effects(model, &extended_model, &effects, &options.catalogue);
    for (joint, gap) in &encoders.other_gaps {
        extended_model.joints[*joint].backlash = Some(*gap);
    }
    let mut unexplained = match model.masses {
        Masses::Known => unexplained::unexplained(problem, &terms, &options.rules),
        Masses::Estimated => unexplained::unjudged(problem, &residuals),
    };
    unexplained.extend(encoders.unexplained);
    progress("drawing residuals", 0.95);
    let floor = floor::floor(problem, sessions, &typical_inertia(model));
    let fit = views::fit_errors(problem, &residuals, &floor);
    unexplained.extend(unexplained::shapeless(&fit, &unexplained));
    let verdict = match (effects.is_empty(), unexplained.is_empty()) {
        (false, _) => Verdict::EffectsFound,
        (true, false) => Verdict::Unexplained,
        (true, true) => Verdict::NothingFound,
    };
    Ok(Diagnosis {
        schema: Diagnosis::SCHEMA,
        versions: BTreeMap::from([
            ("lostmotion", env!("CARGO_PKG_VERSION")),
            ("rapier3d", crate::plant::RAPIER_VERSION),
        ]),
        verdict,
        changes: None,
        candidates: records(problem, selection, options),
        effects,
        fit: fit.into_iter().chain(encoders.fit).collect(),
        replay: Vec::new(),
        baseline: baseline(problem, selection, &uncertainty, sessions, &gaps),
        unexplained,
        two_encoders: encoders.joints,
        method: method(problem, sessions, trained, options),
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

/// Residuals of the nominal model with its free parameters fitted by plain least squares, which is the best that it can do in RMS.
pub fn nominal_residuals(problem: &Problem) -> Option<Vec<Vec<f64>>> {
    let fitted = problem.fit(&[], Part::Train, f64::INFINITY)?;
    Some((0..problem.baseline.len()).map(|joint| views::residual(problem, &[], &fitted, joint)).collect())
}

/// Friction of the nominal model as [`nominal_residuals`] has it: fitted without the effects, as far as it can stand in for them.
fn nominal_friction(problem: &Problem) -> Option<Vec<SymmetricFriction>> {
    let fitted = problem.fit(&[], Part::Train, f64::INFINITY)?;
    let of_joint = |(baseline, at): (&JointBaseline, &usize)| {
        baseline.friction(&fitted.solution.coefficients.as_slice()[*at..*at + baseline.len()])
    };
    Some(problem.baseline.iter().zip(&fitted.baseline_at).map(of_joint).collect())
}

fn residuals(problem: &Problem, terms: &[&Term], selection: &Selection, data: &Data) -> Vec<Residual> {
    let nominal = data.as_recorded.clone().or_else(|| nominal_residuals(problem));
    (0..problem.baseline.len())
        .map(|joint| {
            let after = views::residual(problem, terms, &selection.fitted, joint);
            let before = nominal.as_ref().map_or_else(|| after.clone(), |nominal| nominal[joint].clone());
            Residual { before, after }
        })
        .collect()
}

/// The effect that a noticeable lag of the current is, with its gain on held-out data beside the nominal model.
fn delayed(problem: &Problem, data: &Data) -> Option<FoundEffect> {
    let (late, recorded) = (data.late?, data.as_recorded.as_ref()?);
    let effects = &mut problem.catalogue.diagnosable();
    let (effect, values) = effects.find_map(|effect| Some((effect, effect.of_lag(late.lag.value)?)))?;
    let about = effect.about();
    let mended = nominal_residuals(problem)?;
    let power = |residuals: &[Vec<f64>]| -> f64 {
        let of_joint = |joint: usize| {
            let rows = problem.judged_rows(joint, Part::HeldOut);
            rows.iter().map(|row| residuals[joint][*row].powi(2)).sum::<f64>()
        };
        (0..residuals.len()).map(of_joint).sum()
    };
    let parameters = about.parameters.iter().zip(values).filter(|(_, value)| *value > 0.0);
    Some(FoundEffect {
        effect: about.name.to_owned(),
        joints: data.model.joints.iter().map(|joint| joint.name.clone()).collect(),
        kind: about.kind,
        parameters: parameters
            .map(|(spec, value)| {
                (spec.name.to_owned(), Measured { value, std_error: late.lag.std_error, unit: spec.unit })
            })
            .collect(),
        probability: late.probability,
        gain_percent: 100.0 * (1.0 - (power(&mended) / power(recorded).max(1e-300)).sqrt()),
        confusable_with: Vec::new(),
        separate_by: about.separate_by.to_owned(),
    })
}

/// The effect that commands without a current are, joint by joint; its gain is that of the current inside the band.
fn unanswered(problem: &Problem, data: &Data, options: &Options) -> Vec<FoundEffect> {
    let found = problem.catalogue.diagnosable().find(|effect| effect.of_dead_band(0.0).is_some());
    let Some(effect) = found else { return Vec::new() };
    let about = effect.about();
    let (train, held_out) = data.sessions.split_at(data.trained);
    let of_joint = |(index, joint): (usize, &crate::robot::JointModel)| {
        let band = command::dead_band(data.model, index, train, held_out, options.held_out_share)?;
        let rules = &options.rules;
        if band.training <= rules.nats || band.held_out <= 0.0 {
            return None;
        }
        let total = band.training + band.held_out;
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
            probability: probability(total, about.parameters.len(), options, std::iter::empty()),
            gain_percent: 100.0 * (1.0 - band.error[1] / band.error[0].max(1e-300)),
            confusable_with: Vec::new(),
            separate_by: about.separate_by.to_owned(),
        })
    };
    data.model.joints.iter().enumerate().filter_map(of_joint).collect()
}

/// Adds what two encoders name: they see it more directly than torque does, and an effect of the measurement is one effect.
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
        }
        effects.push(effect);
    }
}

/// One entry for each term, strongest first.
pub fn found(
    problem: &Problem,
    selection: &Selection,
    uncertainty: &Uncertainty,
    options: &Options,
) -> Vec<FoundEffect> {
    let terms = selection.terms();
    let mut entries: Vec<(f64, FoundEffect)> = Vec::new();
    let mut position = 0;
    for (index, taken) in selection.taken.iter().enumerate() {
        let evidence = evidence_beside(problem, &selection.taken, index).unwrap_or_else(|| taken.evidence.clone());
        let (confusable_with, probability) = rivals(taken, options);
        for term in &taken.terms {
            let about = term.effect.about();
            let strength: f64 = term.joints.iter().map(|joint| evidence[*joint].total()).sum();
            let entry = FoundEffect {
                effect: about.name.to_owned(),
                joints: term.joints.iter().map(|joint| problem.motion.model.joints[*joint].name.clone()).collect(),
                kind: about.kind,
                parameters: estimate::parameters(problem, term, position, &selection.fitted, uncertainty),
                probability,
                gain_percent: gain(problem, &terms, position, selection),
                separate_by: separate_by(about.separate_by, &confusable_with),
                confusable_with: confusable_with.clone(),
            };
            entries.push((strength, entry));
            position += 1;
        }
    }
    entries.sort_by(|a, b| b.0.total_cmp(&a.0));
    entries.into_iter().map(|(_, entry)| entry).collect()
}

/// The experiment that tells an effect from its rivals, by name where there are any.
fn separate_by(experiment: &str, rivals: &[String]) -> String {
    if rivals.is_empty() { experiment.to_owned() } else { format!("against {}: {experiment}", rivals.join(", ")) }
}

/// Share of the evidence at which a rival cannot be rejected.
const CLOSE: f64 = 0.85;
/// Share of the evidence below which a rival is rejected whatever it leaves.
const FAR: f64 = 0.3;
/// [1] Logarithm of the error scale that the laws of the catalogue get wrong themselves: a rival that leaves less than this more on every
/// joint of the effect cannot be rejected. On 85 tuning machines (seeds 2000 to 7101 of `benches/blind`) the truth was never further
/// than 0.10 behind what was named.
const MODEL_ERROR: f64 = 0.12;

/// Effects whose evidence came close, and the probability that the right one was taken.
fn rivals(taken: &Taken, options: &Options) -> (Vec<String>, f64) {
    let total: f64 = taken.evidence.iter().map(Evidence::total).sum();
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

/// [%] by which a term lowers the RMS error of its joints on what is held out.
fn gain(problem: &Problem, terms: &[&Term], index: usize, selection: &Selection) -> f64 {
    let others: Vec<&Term> =
        terms.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, term)| *term).collect();
    let Some(without) = problem.fit(&others, Part::Train, NU) else { return 0.0 };
    let (mut before, mut after) = (0.0, 0.0);
    for joint in &terms[index].joints {
        let rows = problem.judged_rows(*joint, Part::HeldOut);
        let power = |values: Vec<f64>| rows.iter().map(|row| values[*row].powi(2)).sum::<f64>();
        before += power(views::residual(problem, &others, &without, *joint));
        after += power(views::residual(problem, terms, &selection.fitted, *joint));
    }
    if before > 0.0 { 100.0 * (1.0 - (after / before).sqrt()) } else { 0.0 }
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

fn records(problem: &Problem, selection: &Selection, options: &Options) -> Vec<CandidateRecord> {
    let named = |candidate: &Candidate| {
        selection.taken.iter().any(|taken| taken.terms[0].effect.name() == candidate.effect().name())
    };
    let record = |candidate: &Candidate| {
        let joints = candidate.joints();
        let rules = &options.rules;
        let (total, log_scale) = (candidate.total(), candidate.log_scale());
        let named = named(candidate);
        let reason = if named {
            format!("evidence {total:.0} nats alone")
        } else if !candidate.sensible {
            "its parameters would lie outside their ranges".to_owned()
        } else if total <= rules.nats || log_scale <= rules.log_scale {
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

fn method(problem: &Problem, sessions: &[&TimeSeries], trained: usize, options: &Options) -> Method {
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
    let held_out = if sessions.len() > trained {
        sessions[trained..].iter().map(|session| session.name.as_str()).collect::<Vec<_>>().join(", ")
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

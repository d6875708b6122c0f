//! From the changes to a report: each with its value in the reference and now, and the models of the machine at both times.

use super::gap::SideGap;
use super::judge::probability;
use super::quantity;
use super::quantity::MachineQuantity;
use super::select::{Changes, SURE};
use crate::diagnose::conclude::extend::{self, Identified};
use crate::diagnose::fit::cause::changed;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::term::Term;
use crate::diagnose::result::{Change, FoundEffect, Measured, Parts};
use crate::distributions::NORMAL_975;
use crate::effects::{Catalogue, Effect, Scope, SymmetricFriction};
use crate::robot::{EffectEntry, Model};

/// [1] Relative natural variation of the gap from day to day: one standard deviation.
const NATURAL_GAP: f64 = 0.02;
/// [1] Relative error of a rotor's nominal inertia: one standard deviation.
const NOMINAL: f64 = 0.3;

/// A changed quantity of the regression.
struct ChangedTerm {
    quantity: &'static MachineQuantity,
    joint: usize,
    /// Position among the terms.
    term: usize,
    standing: f64,
}

fn found(changes: &Changes, standings: &[f64]) -> Vec<ChangedTerm> {
    let first = changes.shared.len();
    let of_term = |(index, term): (usize, &&Term)| {
        let quantity = quantity::find(term.effect.name())?;
        Some(ChangedTerm { quantity, joint: term.joints[0], term: first + index, standing: standings[index] })
    };
    changes.terms()[first..].iter().enumerate().filter_map(of_term).collect()
}

/// One entry per changed quantity, with its value now. Beside the other terms of friction, the 95 % interval of a change may contain zero: something has
/// changed, but not surely this, and it is left out.
pub fn of_regression(problem: &Problem, changes: &Changes, standings: &[f64]) -> Vec<Change> {
    let all = found(changes, standings);
    let entries = all.iter().map(|one| change(problem, changes, one, &all));
    entries.filter(|entry| entry.change_percent.value.abs() > NORMAL_975 * entry.change_percent.std_error).collect()
}

/// The entries of the inertias alone, which are the last terms. Their errors are at least the natural variation, because that is the
/// difference between two motions for the same inertia.
pub fn of_inertias(problem: &Problem, changes: &Changes, standings: &[f64]) -> Vec<Change> {
    let others = changes.terms().len() - changes.shared.len() - standings.len();
    let standings: Vec<f64> = std::iter::repeat_n(0.0, others).chain(standings.iter().copied()).collect();
    let mut entries = of_regression(problem, changes, &standings);
    entries.retain(|entry| entry.quantity == quantity::rotor_inertia().name());
    for entry in &mut entries {
        let natural = quantity::rotor_inertia().natural;
        entry.change_percent.std_error = entry.change_percent.std_error.hypot(100.0 * natural);
        entry.now.std_error = entry.now.std_error.hypot(natural * entry.reference.value);
    }
    entries
}

fn change(problem: &Problem, changes: &Changes, one: &ChangedTerm, all: &[ChangedTerm]) -> Change {
    let ChangedTerm { quantity, joint, .. } = *one;
    let estimates = &changes.estimates;
    let model = &problem.motion.model.joints[joint];
    let unit = quantity.unit(model.kind);
    let (mut reference, slopes) = quantity.reference(problem, joint);
    let first = estimates.fitted.baseline_at[joint];
    let mut gradient: Vec<(usize, f64)> = slopes.iter().map(|(k, slope)| (first + k, *slope)).collect();
    let mut of_reference = estimates.std_error(&gradient);
    if !quantity.is_of_baseline()
        && let Some(shared) = shared_inertia(changes, joint)
    {
        // Error of the nominal inertia, as far as the data are more accurate than the model file.
        let error = estimates.std_error(&[(estimates.fitted.term_at[shared], 1.0)]);
        let prior = (NOMINAL * reference).powi(2);
        let trust = prior / (prior + error * error);
        gradient = vec![(estimates.fitted.term_at[shared], trust)];
        of_reference = (trust * error * error).sqrt();
        reference = (reference + trust * estimates.coefficient(shared, 0)).max(0.1 * reference);
    }
    let own = |other: &&ChangedTerm| {
        other.joint == joint && (std::ptr::eq(other.quantity, quantity) || quantity.follows(other.quantity))
    };
    let parts: Vec<usize> = all.iter().filter(own).map(|other| other.term).collect();
    let delta: f64 = parts.iter().map(|term| estimates.coefficient(*term, 0)).sum();
    let steps = parts.iter().map(|term| (estimates.fitted.term_at[*term], 1.0));
    let now: Vec<(usize, f64)> = gradient.iter().copied().chain(steps.clone()).collect();
    // Derivatives of Δ/r: 1/r by Δ, −Δ/r² by r.
    let relative: Vec<(usize, f64)> = gradient
        .iter()
        .map(|(at, slope)| (*at, -slope * delta / (reference * reference)))
        .chain(steps.map(|(at, slope)| (at, slope / reference)))
        .collect();
    Change {
        quantity: changes.terms()[one.term].effect.name().to_owned(),
        joint: model.name.clone(),
        reference: Measured { value: reference, std_error: of_reference, unit },
        now: Measured { value: reference + delta, std_error: estimates.std_error(&now), unit },
        change_percent: Measured {
            value: 100.0 * delta / reference,
            std_error: 100.0 * estimates.std_error(&relative),
            unit: "%",
        },
        standing: one.standing,
        probability: probability(one.standing),
    }
}

/// Position of the shared term that fits a rotor's inertia on both sides.
fn shared_inertia(changes: &Changes, joint: usize) -> Option<usize> {
    let own = |term: &Term| term.joints == [joint] && quantity::find(term.effect.name()).is_some();
    changes.shared.iter().position(own)
}

/// Gaps that differ between the sides.
pub fn of_gaps(model: &Model, [before, now]: &[Vec<Option<SideGap>>; 2]) -> Vec<Change> {
    let one = |(joint, (before, now)): (usize, (&Option<SideGap>, &Option<SideGap>))| {
        let (before, now) = ((*before)?, (*now)?);
        let model = &model.joints[joint];
        let unit = model.kind.position_unit();
        let delta = now.value - before.value;
        let own = before.repeatability.hypot(now.repeatability);
        // If there was hardly a gap in the reference, the larger of both gives the scale of the natural variation.
        let standing = delta.abs() / own.hypot(NATURAL_GAP * before.value.max(now.value)).max(1e-300);
        let least = 0.25 * model.encoder_step();
        let base = before.value.max(least).max(1e-12);
        let ratio = now.value / base;
        (standing > SURE && delta.abs() > least && before.compares(&now)).then(|| Change {
            quantity: "backlash".to_owned(),
            joint: model.name.clone(),
            reference: Measured { value: before.value, std_error: before.std_error, unit },
            now: Measured { value: now.value, std_error: now.std_error, unit },
            change_percent: Measured {
                value: 100.0 * delta / base,
                // The natural variation is no change of the machine, but it is part of the difference.
                std_error: 100.0 * now.std_error.hypot(ratio * before.std_error).hypot(NATURAL_GAP * now.value) / base,
                unit: "%",
            },
            standing,
            probability: probability(standing),
        })
    };
    before.iter().zip(now).enumerate().filter_map(one).collect()
}

/// Friction of each joint as it is now.
pub fn friction_now(problem: &Problem, changes: &[Change]) -> Vec<SymmetricFriction> {
    let value = |joint: usize, name: &str| {
        let name_of_joint = &problem.motion.model.joints[joint].name;
        changes.iter().find(|one| one.quantity == name && one.joint == *name_of_joint).map(|one| one.now.value)
    };
    let law = |joint: usize| {
        let law = problem.motion.joints[joint].friction;
        let coulomb = value(joint, "coulomb").unwrap_or(law.coulomb);
        SymmetricFriction {
            coulomb,
            breakaway: value(joint, "breakaway").unwrap_or(law.breakaway + coulomb - law.coulomb),
            stribeck_velocity: value(joint, "stribeck_velocity").unwrap_or(law.stribeck_velocity).max(1e-9),
            viscous: value(joint, "viscous").unwrap_or(law.viscous),
        }
    };
    (0..problem.motion.joints.len()).map(law).collect()
}

/// A new effect. The friction beside it is that of the reference, which was fitted without the effect.
fn entry(found: &FoundEffect, catalogue: &Catalogue) -> EffectEntry {
    let scope = catalogue.find(&found.effect).map(|effect| effect.about().scope);
    let joint = if scope == Some(Scope::Joint) { found.joints.first().cloned() } else { None };
    let parameters = found.parameters.iter().map(|(name, measured)| (name.clone(), measured.value)).collect();
    EffectEntry { effect: found.effect.clone(), joint, parameters }
}

/// Takes the effects of the reference out of the findings, and gives the new ones the names of the catalogue.
fn take_old(parts: &mut Parts) -> Vec<FoundEffect> {
    let (new, old): (Vec<FoundEffect>, Vec<FoundEffect>) =
        std::mem::take(&mut parts.findings.effects).into_iter().partition(|found| changed(&found.effect).is_some());
    let plain = |name: &str| changed(name).unwrap_or(name).to_owned();
    let of_catalogue = |found: &FoundEffect| quantity::find(&plain(&found.effect)).is_none();
    parts.findings.effects = new.into_iter().filter(of_catalogue).collect();
    for found in &mut parts.findings.effects {
        found.effect = plain(&found.effect);
    }
    for withdrawn in &mut parts.findings.withdrawn {
        withdrawn.effect = plain(&withdrawn.effect);
    }
    old.into_iter().filter(of_catalogue).collect()
}

/// Writes one value of each change into a model that has the friction of that time already.
fn write(changes: &[Change], model: &mut Model, value: impl Fn(&Change) -> f64) {
    for change in changes {
        let Some(joint) = model.joints.iter().position(|joint| joint.name == change.joint) else { continue };
        match quantity::find(&change.quantity) {
            Some(quantity) if !quantity.is_of_baseline() => quantity.write(model, joint, value(change)),
            None if change.quantity == "backlash" => model.joints[joint].backlash = Some(value(change)),
            _ => {}
        }
    }
}

/// Separates new effects from those of the reference, renames the candidates, and writes
/// the models of the machine in the reference and now.
pub fn complete(parts: &mut Parts, problem: &Problem, changes: Vec<Change>, [before, now]: &[Vec<Option<SideGap>>; 2]) {
    let (model, factors) = problem.deviating_model();
    let old = take_old(parts);
    let catalogue = &parts.catalogue;
    let values = |side: &[Option<SideGap>]| side.iter().map(|gap| gap.map(|gap| gap.value)).collect::<Vec<_>>();
    let shares: Vec<Option<f64>> = now.iter().zip(before).map(|(now, was)| now.or(*was)?.link_share).collect();
    let judged = problem.joints();
    let friction: Vec<SymmetricFriction> = problem.motion.joints.iter().map(|joint| joint.friction).collect();
    let rotors: Vec<Option<f64>> = parts.baseline_model.joints.iter().map(|joint| joint.rotor_inertia).collect();
    let (gaps_were, gaps_are, friction_is) = (values(before), values(now), friction_now(problem, &changes));
    let then = Identified {
        judged: &judged,
        factors: &factors,
        friction: &friction,
        rotors: &rotors,
        gaps: &gaps_were,
        shares: &shares,
    };
    let today = Identified { friction: &friction_is, gaps: &gaps_are, ..then };
    let was = extend::with_baseline(&model, &then);
    let mut was = extend::with_effects(&model, &was, &old, catalogue);
    let is = extend::with_baseline(&model, &today);
    let mut is = extend::with_effects(&model, &is, &old, catalogue);
    is.effects.extend(parts.findings.effects.iter().map(|found| entry(found, catalogue)));
    write(&changes, &mut was, |change| change.reference.value);
    write(&changes, &mut is, |change| change.now.value);
    for (index, joint) in model.joints.iter().enumerate() {
        let Some(estimate) = parts.baseline.get_mut(&joint.name) else { continue };
        for change in changes.iter().filter(|change| change.joint == joint.name) {
            if let Some(value) = estimate.friction.get_mut(change.quantity.as_str()) {
                *value = change.now.clone();
            }
        }
        estimate.backlash = now[index].map(|gap| Measured {
            value: gap.value,
            std_error: gap.std_error,
            unit: joint.kind.position_unit(),
        });
    }
    parts.baseline_model = was;
    parts.extended_model = is;
    parts.changes = Some(changes);
}

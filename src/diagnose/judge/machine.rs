//! The machine with the most probable set, and its place in a diagnosis.

use std::collections::BTreeMap;

use super::contest::Contender;
use crate::diagnose::result::{
    Diagnosis, EffectGain, FoundEffect, JudgedEffect, JudgedMachine, JudgedName, Measured, Standing, Verdict,
    Withdrawn, is_supported,
};
use crate::effects::Catalogue;
use crate::gearhead::FrictionLaw;
use crate::robot::{EffectEntry, JointModel};
use crate::timeseries::Estimate;

/// The machine with the most probable set, which may have no effect; `None` where an effect of it is not supported, or an effect that the regression named is not
/// in it: where the two disagree, neither changes the other's result. Contenders are in falling order of their scores.
pub fn most_probable(
    diagnosis: &Diagnosis,
    baseline: &Contender,
    order: &[&Contender],
    probabilities: &[f64],
    names: &[JudgedName],
    catalogue: &Catalogue,
) -> Option<JudgedMachine> {
    let best = (0..order.len()).max_by(|a, b| probabilities[*a].total_cmp(&probabilities[*b]))?;
    let best = order[best];
    let entries = best.fitted.effects();
    if !regression(diagnosis).iter().all(|named| entries.iter().any(|one| same(one, named))) {
        return None;
    }
    let has = |one: &Contender, entry: &EffectEntry| one.fitted.effects().iter().any(|own| same(own, entry));
    let effect = |entry: &EffectEntry| -> Option<JudgedEffect> {
        let with = order.iter().zip(probabilities).filter(|(one, _)| has(one, entry));
        let probability = with.map(|(_, probability)| probability).sum::<f64>().min(1.0);
        let without = order.iter().find(|one| !has(one, entry))?;
        Some(JudgedEffect {
            effect: entry.effect.clone(),
            joint: entry.joint.clone(),
            parameters: parameters(best, entry, catalogue)?,
            probability: Some(probability).filter(|probability| is_supported(*probability))?,
            gain_nats: best.nats - without.nats,
            confusable_with: names.iter().find(|name| name.effect == entry.effect)?.confusable_with.clone(),
            without: without.fitted.model(),
        })
    };
    let extended = best.fitted.model();
    let estimates = extended.joints.iter().map(|joint| (joint.name.clone(), estimates(best, joint)));
    Some(JudgedMachine {
        baseline: baseline.fitted.model(),
        effects: entries.iter().map(effect).collect::<Option<_>>()?,
        estimates: estimates.collect(),
        extended,
    })
}

/// Puts a machine in the place of what the regression found; `gains`: of its effects, one by one, on data held out. Where one of them has no gain, nothing is
/// changed, and the effects without one are listed as withdrawn. Without an effect, the machine is the nominal one with its friction, gaps and inaccurate values
/// fitted to every sample.
pub fn adopt(diagnosis: &mut Diagnosis, machine: JudgedMachine, gains: &[EffectGain]) {
    let JudgedMachine { baseline, extended, effects, estimates } = machine;
    let all = || effects.iter().zip(gains);
    if all().any(|(_, gain)| !gain.shown()) {
        diagnosis.withdrawn.extend(all().filter(|(_, gain)| !gain.shown()).map(|(one, gain)| Withdrawn {
            effect: one.effect.clone(),
            joints: one.joint.iter().cloned().collect(),
            reason: format!(
                "every sample together supports it ({:.0} %), but it lowers no error on data held out ({})",
                100.0 * one.probability,
                gain.gain_of
            ),
        }));
        return;
    }
    let named = regression(diagnosis);
    for (one, gain) in all() {
        match named.iter().position(|entry| entry.effect == one.effect && entry.joint == one.joint) {
            Some(index) => diagnosis.effects[index].parameters.extend(one.parameters.clone()),
            None => add(diagnosis, one, gain),
        }
    }
    diagnosis.effects.sort_by(|a, b| b.evidence_nats.total_cmp(&a.evidence_nats));
    for (joint, estimates) in estimates {
        let Some(own) = diagnosis.baseline.get_mut(&joint) else { continue };
        for (name, measured) in estimates {
            match name {
                "backlash" => own.backlash = Some(measured),
                name => _ = own.friction.insert(name, measured),
            }
        }
    }
    if !effects.is_empty() {
        diagnosis.verdict = Verdict::EffectsFound;
        diagnosis.baseline_model = baseline;
    }
    diagnosis.extended_model = extended;
    diagnosis.judgement.iter_mut().for_each(|judgement| judgement.adopted = true);
}

/// Adds an effect that the regression did not name.
fn add(diagnosis: &mut Diagnosis, one: &JudgedEffect, gain: &EffectGain) {
    let Some(about) = diagnosis.catalogue.find(&one.effect).map(|effect| effect.about()) else { return };
    let all = || diagnosis.baseline_model.joints.iter().map(|joint| joint.name.clone()).collect();
    let joints = one.joint.as_ref().map_or_else(all, |joint| vec![joint.clone()]);
    let standing = Standing { probability: one.probability, evidence_nats: one.gain_nats, gain: gain.clone() };
    let found = FoundEffect::new(about, joints, one.parameters.clone(), standing).beside(one.confusable_with.clone());
    diagnosis.withdrawn.retain(|other| other.effect != found.effect || other.joints != found.joints);
    for record in diagnosis.candidates.iter_mut().filter(|record| record.effect == found.effect) {
        record.named = true;
        record.reason = "named by the score of every sample".to_owned();
    }
    diagnosis.effects.push(found);
}

/// What the regression named, in the order of the diagnosis.
fn regression(diagnosis: &Diagnosis) -> Vec<EffectEntry> {
    let [before, after] = [&diagnosis.baseline_model.effects, &diagnosis.extended_model.effects];
    after.get(before.len()..).unwrap_or(&[]).to_vec()
}

fn same(one: &EffectEntry, other: &EffectEntry) -> bool {
    one.effect == other.effect && one.joint == other.joint
}

/// Parameters of an effect as they were fitted; `None` where the errors are not known.
fn parameters(best: &Contender, entry: &EffectEntry, catalogue: &Catalogue) -> Option<BTreeMap<String, Measured>> {
    let about = catalogue.find(&entry.effect)?.about();
    let model = best.fitted.model();
    let kind = entry.joint.as_ref().and_then(|name| model.joints.iter().find(|joint| joint.name == *name));
    let of_joint = entry.joint.as_ref().map_or_else(String::new, |joint| format!("{joint}."));
    let measured = |(name, value): (&String, &f64)| {
        let spec = about.parameters.iter().find(|spec| spec.name == *name)?;
        let unit = kind.map_or(spec.unit, |joint| spec.unit_for(joint.kind));
        let fitted = estimate(best, &format!("{of_joint}{}.{name}", entry.effect));
        let std_error = fitted.map_or(0.0, |fitted| fitted.std_error);
        std_error.is_finite().then(|| (name.clone(), Measured { value: *value, std_error, unit }))
    };
    entry.parameters.iter().map(measured).collect()
}

/// Friction and gap of a joint as they were fitted, where their errors are known.
fn estimates(best: &Contender, joint: &JointModel) -> BTreeMap<&'static str, Measured> {
    let fitted = |name: &str| estimate(best, &format!("{}.{name}", joint.name)).filter(|one| one.std_error.is_finite());
    let (kind, effort) = (joint.kind, joint.kind.effort_unit());
    let mut all: Vec<(&'static str, Option<Estimate>, &'static str)> =
        vec![("backlash", fitted("backlash"), kind.position_unit())];
    if let Some(FrictionLaw::Exponential(_)) = joint.friction.map(|friction| friction.law) {
        let coulomb = fitted("coulomb");
        // F_S = F_C (1 + r), errors of both independent.
        let breakaway = coulomb.zip(fitted("rise")).map(|(coulomb, rise)| Estimate {
            value: coulomb.value * (1.0 + rise.value),
            std_error: (coulomb.std_error * (1.0 + rise.value)).hypot(coulomb.value * rise.std_error),
        });
        all.extend([
            ("coulomb", coulomb, effort),
            ("breakaway", breakaway, effort),
            ("stribeck_velocity", fitted("stribeck_velocity"), kind.velocity_unit()),
            ("viscous", fitted("viscous"), kind.damping_unit()),
        ]);
    }
    all.into_iter().filter_map(|(name, fitted, unit)| Some((name, Measured::of(fitted?, unit)))).collect()
}

/// A fitted parameter by its name.
fn estimate(best: &Contender, name: &str) -> Option<Estimate> {
    best.fitted.estimates.iter().find(|(own, _)| own == name).map(|(_, estimate)| *estimate)
}

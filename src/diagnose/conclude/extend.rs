//! The nominal model with the fitted baseline, and the same with the effects that were found.

use std::collections::BTreeMap;

use crate::diagnose::result::{FoundEffect, Measured};
use crate::effects::{Catalogue, Scope, SymmetricFriction};
use crate::gearhead::{Exponential, Friction, FrictionLaw};
use crate::robot::{EffectEntry, Model};

/// Share of friction behind the gear where it is unknown.
const LINK_SHARE: f64 = 0.1;

/// Results of a fit for the joints of a model, one entry per joint.
#[derive(Debug, Clone, Copy)]
pub struct Identified<'f> {
    /// Joints that were judged: the others stay as they are.
    pub judged: &'f [usize],
    /// True torque relative to that of the nominal model, in which friction was fitted.
    pub factors: &'f [f64],
    /// Symmetric friction.
    pub friction: &'f [SymmetricFriction],
    /// [kg·m²] Rotors whose inertia the model file does not give.
    pub rotors: &'f [Option<f64>],
    /// [rad or m] Gaps that the model file does not give.
    pub gaps: &'f [Option<f64>],
    /// Shares of friction behind the gear.
    pub shares: &'f [Option<f64>],
}

/// The nominal model with what was identified; a rotor and a gap in the model file stay.
pub fn with_baseline(model: &Model, identified: &Identified) -> Model {
    let Identified { judged, factors, friction, rotors, gaps, shares } = *identified;
    let mut model = model.clone();
    for index in (0..model.joints.len()).filter(|index| judged.contains(index)) {
        let joint = &mut model.joints[index];
        let law = friction[index];
        let side = Exponential {
            coulomb: law.coulomb.max(0.0),
            breakaway: law.breakaway.max(0.0),
            stribeck_velocity: law.stribeck_velocity,
            viscous: law.viscous.max(0.0),
        };
        let link_share = joint.friction.map(|friction| friction.link_share).or(shares[index]).unwrap_or(LINK_SHARE);
        let given = joint.friction.is_some();
        let mut law = FrictionLaw::Exponential([side; 2]);
        scale(&mut law, factors[index], given);
        joint.backlash = joint.backlash.or(gaps[index]);
        joint.rotor_inertia = joint.rotor_inertia.or(rotors[index].map(|inertia| inertia * factors[index]));
        model.set_friction(index, Friction { law, link_share });
    }
    model
}

/// The baseline model with the found effects added. Friction and rotors that were fitted in a torque with a wrong scale are corrected.
///
/// Parameters of the effects in `found` are in true torque, except for the scale that effects in `found` correct.
pub fn with_effects(nominal: &Model, baseline: &Model, found: &[FoundEffect], catalogue: &Catalogue) -> Model {
    let mut model = baseline.clone();
    let factors: Vec<f64> = model.joints.iter().map(|joint| torque_factor(&joint.name, found, catalogue)).collect();
    for ((joint, nominal), factor) in model.joints.iter_mut().zip(&nominal.joints).zip(&factors) {
        if let Some(friction) = &mut joint.friction {
            scale(&mut friction.law, *factor, nominal.friction.is_some());
        }
        if nominal.rotor_inertia.is_none() {
            joint.rotor_inertia = joint.rotor_inertia.map(|inertia| inertia * factor);
        }
    }
    for effect in found {
        let scope = catalogue.find(&effect.effect).map(|effect| effect.about().scope);
        let joint = if scope == Some(Scope::Joint) { effect.joints.first().cloned() } else { None };
        let index = joint.as_ref().and_then(|name| model.joints.iter().position(|joint| joint.name == *name));
        let factor = index.map_or(1.0, |index| factors[index]);
        let value = |measured: &Measured| {
            let is_torque = measured.unit.starts_with('N');
            measured.value * if is_torque { factor } else { 1.0 }
        };
        let parameters: BTreeMap<String, f64> =
            effect.parameters.iter().map(|(name, measured)| (name.clone(), value(measured))).collect();
        model.effects.push(EffectEntry { effect: effect.effect.clone(), joint, parameters });
    }
    model
}

/// True torque of a joint relative to the torque computed from its current with the nominal model.
fn torque_factor(joint: &str, found: &[FoundEffect], catalogue: &Catalogue) -> f64 {
    let of_effect = |effect: &FoundEffect| {
        let known = catalogue.find(&effect.effect)?;
        let value = |name: &str| effect.parameters.get(name).map_or(0.0, |measured| measured.value);
        let values: Vec<f64> = known.about().parameters.iter().map(|spec| value(spec.name)).collect();
        Some(known.diagnosable()?.torque_factor(&values))
    };
    found.iter().filter(|effect| effect.joints.iter().any(|name| name == joint)).filter_map(of_effect).product()
}

/// Corrects friction that was fitted in a torque too small by `factor`; a falling part given by the nominal model was not fitted and stays.
fn scale(law: &mut FrictionLaw, factor: f64, falling_given: bool) {
    if let FrictionLaw::Exponential(sides) = law {
        for side in sides {
            let falling = (side.breakaway - side.coulomb) * if falling_given { 1.0 } else { factor };
            side.coulomb *= factor;
            side.viscous *= factor;
            side.breakaway = side.coulomb + falling;
        }
    }
}

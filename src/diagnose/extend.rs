//! The nominal model with the fitted baseline, and with the effects that were found.

use std::collections::BTreeMap;

use super::result::FoundEffect;
use crate::effects::{Catalogue, Scope, SymmetricFriction};
use crate::gearhead::{Exponential, Friction, FrictionLaw};
use crate::robot::{EffectEntry, Model};

/// Share of friction behind the gear where nothing is known of it.
const LINK_SHARE: f64 = 0.1;

/// The nominal model with symmetric friction and gaps as fitted; what the model file gives of the gap stays.
pub fn with_baseline(
    model: &Model,
    friction: &[SymmetricFriction],
    gaps: &[Option<f64>],
    shares: &[Option<f64>],
) -> Model {
    let mut model = model.clone();
    for (index, joint) in model.joints.iter_mut().enumerate() {
        let law = friction[index];
        let side = Exponential {
            coulomb: law.coulomb.max(0.0),
            breakaway: law.breakaway.max(0.0),
            stribeck_velocity: law.stribeck_velocity,
            viscous: law.viscous.max(0.0),
        };
        let link_share = joint.friction.map(|friction| friction.link_share).or(shares[index]).unwrap_or(LINK_SHARE);
        joint.friction = Some(Friction { law: FrictionLaw::Exponential([side; 2]), link_share });
        joint.backlash = joint.backlash.or(gaps[index]);
    }
    model
}

/// The same with the effects that were found appended to its list.
pub fn with_effects(baseline: &Model, found: &[FoundEffect], catalogue: &Catalogue) -> Model {
    let mut model = baseline.clone();
    for effect in found {
        let scope = catalogue.find(&effect.effect).map(|effect| effect.about().scope);
        let joint = if scope == Some(Scope::Joint) { effect.joints.first().cloned() } else { None };
        let parameters: BTreeMap<String, f64> =
            effect.parameters.iter().map(|(name, measured)| (name.clone(), measured.value)).collect();
        model.effects.push(EffectEntry { effect: effect.effect.clone(), joint, parameters });
    }
    model
}

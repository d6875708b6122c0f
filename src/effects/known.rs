//! Effects that a model file already lists: those that are numbers of the model are applied to it before its rest is judged by torque.

use super::Catalogue;
use crate::error::Result;
use crate::robot::{EffectEntry, Model};

/// A model without a list of effects.
#[derive(Debug, Clone, PartialEq)]
pub struct Applied {
    /// The model, with the effects that alter its bodies, rotors, motors, gears or gravity applied to these numbers.
    pub model: Model,
    /// The entries that were applied.
    pub in_numbers: Vec<EffectEntry>,
    /// The others: they act while the machine moves, or are part of its friction.
    pub others: Vec<EffectEntry>,
}

/// Applies the effects that a model lists, as far as they are numbers of it.
///
/// # Errors
/// The parameters of an effect are refused.
pub fn applied(given: &Model, catalogue: &Catalogue) -> Result<Applied> {
    let model = Model { effects: Vec::new(), ..given.clone() };
    let mut applied = Applied { model, in_numbers: Vec::new(), others: Vec::new() };
    for entry in &given.effects {
        let joint = entry.joint.as_deref().and_then(|name| given.robot.joint_index(name));
        let mut model = applied.model.clone();
        let actions = catalogue.find(&entry.effect).map(|effect| effect.install(&mut model, joint, &entry.parameters));
        let is_number = actions.transpose()?.is_some_and(|actions| actions.is_empty());
        if is_number && has_friction_of(&model, &applied.model) {
            applied.model = model;
            applied.in_numbers.push(entry.clone());
        } else {
            applied.others.push(entry.clone());
        }
    }
    let pairs = given.robot.bodies.iter().zip(&applied.model.robot.bodies).enumerate();
    let changed: Vec<usize> =
        pairs.filter(|(_, (before, after))| before.inertia != after.inertia).map(|(body, _)| body).collect();
    applied.model.write_inertias(&changed);
    Ok(applied)
}

fn has_friction_of(model: &Model, other: &Model) -> bool {
    model.joints.iter().zip(&other.joints).all(|(one, other)| one.friction == other.friction)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(effect: &str, joint: Option<&str>, parameters: &[(&str, f64)]) -> EffectEntry {
        let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        EffectEntry { effect: effect.to_owned(), joint: joint.map(str::to_owned), parameters }
    }

    #[test]
    fn property_numbers_are_applied_and_what_acts_is_left() {
        let mut given = Model::load(std::path::Path::new("robots/scara/model.toml")).expect("a model");
        let joint = given.joints[0].name.clone();
        let on_joint = |effect: &str, parameter: &str| entry(effect, Some(&joint), &[(parameter, 0.1)]);
        given.effects = vec![
            entry("payload", None, &[("mass", 0.5), ("x", 0.1)]),
            on_joint("coulomb_asymmetry", "asymmetry"),
            on_joint("rotor_inertia", "error"),
        ];
        let found = applied(&given, &Catalogue::default()).expect("effects that exist");
        assert!(found.model.effects.is_empty());
        assert_eq!(found.in_numbers, [given.effects[0].clone(), given.effects[2].clone()]);
        assert_eq!(found.others, [given.effects[1].clone()]);
        let rotors = [&found.model, &given].map(|model| model.joints[0].rotor_inertia.expect("a rotor"));
        assert!((rotors[0] - 1.1 * rotors[1]).abs() < 1e-12);
        // The load is in the text of the URDF that the model would write.
        let masses = [&found.model, &given].map(|model| model.robot.bodies.last().expect("a body").inertia.mass);
        assert!((masses[0] - masses[1] - 0.5).abs() < 1e-9, "{masses:?}");
        assert_ne!(found.model.urdf_text, given.urdf_text);
    }
}

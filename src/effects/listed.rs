//! The list `[[effects]]` of a model file: its entries are installed in a machine, or applied to the model as far as they are numbers of it, before its rest is
//! judged by torque.

use super::{Action, Catalogue, Scope};
use crate::error::{Error, Place, Result};
use crate::robot::{EffectEntry, Model};
use crate::toml_input::nearest;

/// Installs an entry of the list, the `number`th, counted from 1; gives the actions that run while the machine moves.
///
/// # Errors
/// There is no such effect or joint, or its parameters are refused.
pub fn install_listed(
    model: &mut Model,
    number: usize,
    entry: &EffectEntry,
    catalogue: &Catalogue,
) -> Result<Vec<Action>> {
    let refused = |key: &str, value: &str, expected: String| {
        Error::input(&model.source, Place::File, format!("effects[{number}].{key}"), value, expected)
    };
    let effect = catalogue.find(&entry.effect).ok_or_else(|| {
        let near = nearest(&entry.effect, catalogue.iter().map(|effect| effect.name()));
        let hint = near.map_or_else(String::new, |near| format!(", such as {near}"));
        refused("effect", &entry.effect, format!("a name of `lostmotion list effects`{hint}"))
    })?;
    let named = entry.joint.as_deref();
    let joint = named.map(|name| {
        let names = || model.joints.iter().map(|joint| joint.name.as_str()).collect::<Vec<_>>().join(", ");
        let index = model.joints.iter().position(|joint| joint.name == name);
        index.ok_or_else(|| refused("joint", name, format!("a joint of the model: {}", names())))
    });
    let joint = joint.transpose()?;
    if let (Scope::Machine, Some(name)) = (effect.about().scope, named) {
        let expected = format!("no joint: {} acts on the whole machine", entry.effect);
        return Err(refused("joint", name, expected));
    }
    effect.install(model, joint, &entry.parameters).map_err(|error| numbered(error, number, &entry.effect))
}

/// Converts an effect's error about `effects.NAME.parameter` to an error about an entry of the list.
fn numbered(error: Error, number: usize, effect: &str) -> Error {
    let Error::Input(mut fault) = error else { return error };
    if let Some(name) = fault.key.strip_prefix(&format!("effects.{effect}.")) {
        fault.key = format!("effects[{number}].{name}");
    } else if !fault.key.starts_with("effects") {
        fault.expected = format!("{} (effects[{number}])", fault.expected);
    }
    Error::Input(fault)
}

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
/// As [`install_listed`].
pub fn applied(given: &Model, catalogue: &Catalogue) -> Result<Applied> {
    let model = Model { effects: Vec::new(), ..given.clone() };
    let mut applied = Applied { model, in_numbers: Vec::new(), others: Vec::new() };
    for (number, entry) in (1..).zip(&given.effects) {
        let mut model = applied.model.clone();
        let acting = install_listed(&mut model, number, entry, catalogue);
        let acting = acting.map_err(|error| given.places.locate(error))?;
        if acting.is_empty() && has_friction_of(&model, &applied.model) {
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

    #[test]
    fn property_an_unknown_name_is_refused_with_its_number_and_a_hint() {
        let mut given = Model::load(std::path::Path::new("robots/scara/model.toml")).expect("a model");
        given.effects = vec![entry("payload", None, &[("mass", 0.5)]), entry("paylod", None, &[])];
        let error = applied(&given, &Catalogue::default()).expect_err("no such effect").to_string();
        assert!(error.contains("effects[2].effect") && error.contains("such as payload"), "{error}");
    }
}

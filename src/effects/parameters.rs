//! The parameters of an effect from a model file, checked against its specification.

use std::collections::BTreeMap;
use std::path::Path;

use super::About;
use crate::error::{Error, Place, Result};
use crate::robot::Model;
use crate::toml_input::nearest;

/// Checked parameters of one effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    values: BTreeMap<&'static str, f64>,
}

impl Parameters {
    /// Checks names and ranges, and fills in defaults.
    ///
    /// # Errors
    /// A parameter is missing, unknown, not finite or out of its range.
    pub fn check(about: &About, model: &Model, given: &BTreeMap<String, f64>) -> Result<Self> {
        let fault = |name: &str, value: String, expected: String| {
            Err(Error::input(&model.source, Place::File, format!("effects.{}.{name}", about.name), value, expected))
        };
        if let Some((name, value)) =
            given.iter().find(|(name, _)| about.parameters.iter().all(|spec| spec.name != **name))
        {
            let known: Vec<_> = about.parameters.iter().map(|spec| spec.name).collect();
            let near = nearest(name, known.iter().copied());
            let expected =
                near.map_or_else(|| format!("one of {}", known.join(", ")), |near| format!("the key `{near}`"));
            return fault(name, value.to_string(), format!("{expected} (unknown key)"));
        }
        let mut values = BTreeMap::new();
        for spec in about.parameters {
            let Some(value) = given.get(spec.name).copied().or(spec.default) else {
                return fault(spec.name, String::new(), format!("{}, {} (missing)", spec.range(), spec.meaning));
            };
            // Not `value < spec.min`, so that NaN counts as out of range too.
            if !(value >= spec.min && value <= spec.max) {
                return fault(spec.name, value.to_string(), spec.range());
            }
            values.insert(spec.name, value);
        }
        Ok(Self { values })
    }

    /// The value of a parameter of the specification; 0 for an unknown name.
    pub fn get(&self, name: &str) -> f64 {
        self.values.get(name).copied().unwrap_or(0.0)
    }
}

/// The joint that an effect of one joint needs.
///
/// # Errors
/// No joint is given, or there is no joint of that index.
pub fn need_joint(about: &About, model: &Model, joint: Option<usize>) -> Result<usize> {
    joint.filter(|index| *index < model.joints.len()).ok_or_else(|| {
        let names: Vec<_> = model.joints.iter().map(|joint| joint.name.as_str()).collect();
        let expected = format!("the joint it acts on: {}", names.join(", "));
        Error::input(&model.source, Place::File, format!("effects.{}.joint", about.name), "", expected)
    })
}

/// The friction of a joint, to be changed.
///
/// # Errors
/// The friction of the joint is unknown.
pub fn need_friction<'m>(
    about: &About,
    model: &'m mut Model,
    joint: usize,
) -> Result<&'m mut crate::gearhead::Friction> {
    let Model { source, joints, .. } = model;
    let joint = &mut joints[joint];
    let key = format!("joints.{}.friction", joint.name);
    joint.friction.as_mut().ok_or_else(|| {
        let expected = format!("the friction that `{}` alters: `lostmotion identify` finds it", about.name);
        Error::input(source, Place::File, key, "", expected)
    })
}

/// A value of the model file that an effect changes.
///
/// # Errors
/// The model file does not give it.
pub fn need<'m, T>(about: &About, file: &Path, key: String, value: Option<&'m mut T>) -> Result<&'m mut T> {
    value.ok_or_else(|| {
        let expected = format!("the nominal value that `{}` changes (missing)", about.name);
        Error::input(file, Place::File, key, "", expected)
    })
}

/// The error of a parameter that is in its range but inconsistent with the machine.
pub fn misfit(about: &About, model: &Model, name: &str, value: f64, expected: String) -> Error {
    Error::input(&model.source, Place::File, format!("effects.{}.{name}", about.name), value, expected)
}

//! Viscous friction differs between the two directions of motion.
//!
//! `F_V → F_V⁺` for v > 0, `F_V⁻` for v < 0. Against the symmetric law with `F_V = (F_V⁺ + F_V⁻)/2` the motor has to add
//! `(F_V⁺ − F_V⁻)/2 · |v|`, with the same sign in both directions and growing with speed.
//! Left out: lubricant that changes with temperature.
//! Reference: A. Janot, M. Gautier, M. Brunot (2019), Data set and reference models of EMPS.

use std::collections::BTreeMap;

use super::parameters::{need_friction, need_joint};
use super::{About, Action, Diagnosable, Effect, Kind, Motion, ParameterSpec, Parameters, Scope};
use crate::error::Result;
use crate::gearhead::FrictionLaw;
use crate::robot::Model;

static ABOUT: About = About {
    name: "viscous_asymmetry",
    summary: "Viscous friction differs between the two directions of motion.",
    equation: "F_V → F_V⁺ for v > 0, F_V⁻ for v < 0",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("positive", "F_V⁺", "N·m·s/rad", "viscous friction for v > 0").between(0.0, 1e9),
        ParameterSpec::new("negative", "F_V⁻", "N·m·s/rad", "viscous friction for v < 0").between(0.0, 1e9),
    ],
    signature: "the slope of torque against velocity differs between the directions; nothing at low speed",
    look_alikes: &["coulomb_asymmetry", "quadratic_drag"],
    separate_by: "constant speeds over the whole range in both directions: an asymmetry of Coulomb friction does not grow with speed",
    reference: "A. Janot, M. Gautier, M. Brunot (2019), Data set and reference models of EMPS",
};

/// Viscous friction differs between the two directions of motion.
pub struct ViscousAsymmetry;

impl Effect for ViscousAsymmetry {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        let viscous = [given.get("positive"), given.get("negative")];
        match &mut need_friction(&ABOUT, model, joint)?.law {
            FrictionLaw::Exponential(law) => {
                for (side, value) in law.iter_mut().zip(viscous) {
                    side.viscous = value;
                }
            }
            FrictionLaw::TwoLines(law) => {
                for (side, value) in law.iter_mut().zip(viscous) {
                    side.b1 += value - side.b2;
                    side.b2 = value;
                }
            }
        }
        Ok(Vec::new())
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for ViscousAsymmetry {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        vec![motion.column(joint, |m, row| m.v[row].abs())]
    }

    fn parameters(&self, motion: &Motion, joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        let viscous = motion.joints[joint].friction.viscous;
        vec![viscous + coefficients[0], viscous - coefficients[0]]
    }
}

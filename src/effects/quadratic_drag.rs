//! Drag that grows with the square of speed, by lubricant or air.
//!
//! The rotor is braked by `c v |v|`; the motor has to add it. It shows as a curvature of torque against velocity, odd in velocity.
//! Left out: dependence on temperature.
//! Reference: R. Stribeck's law extended as in M. R. Popović, A. A. Goldenberg (1998), Modeling of friction using spectral analysis.

use std::collections::BTreeMap;

use super::parameters::need_joint;
use super::{
    About, Action, Diagnosable, Effect, JointAction, JointState, Kind, Motion, ParameterSpec, Parameters, Scope,
};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "quadratic_drag",
    summary: "Drag that grows with the square of speed.",
    equation: "τ = −c v |v| on the rotor",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[ParameterSpec::new("coefficient", "c", "N·m·s²/rad²", "drag at the joint per square of joint speed")
        .between(0.0, 1e6)],
    signature: "torque against velocity bends upwards, in both directions alike",
    look_alikes: &["viscous_asymmetry", "load_dependent_friction"],
    separate_by: "high constant speeds in random order, both directions, without load",
    reference: "M. R. Popović, A. A. Goldenberg (1998), Modeling of friction using spectral analysis",
};

/// Drag that grows with the square of speed.
pub struct QuadraticDrag;

struct Drag(f64);

impl JointAction for Drag {
    fn motor_torque(&self, state: &JointState) -> f64 {
        -self.0 * state.motor_velocity * state.motor_velocity.abs()
    }
}

impl Effect for QuadraticDrag {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let c = Parameters::check(&ABOUT, model, given)?.get("coefficient");
        Ok(vec![Action::Joint(need_joint(&ABOUT, model, joint)?, Box::new(Drag(c)))])
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for QuadraticDrag {
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        vec![motion.column(joint, |m, row| m.v[row] * m.v[row].abs())]
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0]]
    }
}

//! A torque at a fixed frequency in time: a pump, a fan, a converter, a machine next door.
//!
//! The rotor feels `a sin(2π f t + φ)`, `t` since the start of the session, whatever the joint does.
//! Left out: a disturbance that acts on the link, or that shakes the base.
//! Reference: G. F. Franklin, J. D. Powell, M. Workman (1998), Digital Control of Dynamic Systems, ch. 8.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::parameters::need_joint;
use super::{
    About, Action, Diagnosable, Effect, JointAction, JointState, Kind, Motion, ParameterSpec, Parameters, Scope,
};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "periodic_disturbance",
    summary: "A torque at a frequency that is fixed in time.",
    equation: "τ = a sin(2π f t + φ) on the rotor",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("amplitude", "a", "N·m", "amplitude at the joint, the ratio included").between(0.0, 1e6),
        ParameterSpec::new("frequency", "f", "Hz", "frequency").between(0.0, 500.0),
        ParameterSpec::new("phase", "φ", "rad", "phase at the start of the session").between(-TAU, TAU).or(0.0),
    ],
    signature: "a line at one frequency, at every speed the same and at rest as well",
    look_alikes: &["cogging", "torque_ripple"],
    separate_by: "several constant speeds: what belongs to an angle changes its frequency, this does not",
    reference: "G. F. Franklin, J. D. Powell, M. Workman (1998), Digital Control of Dynamic Systems, ch. 8",
};

/// A torque at a fixed frequency.
pub struct PeriodicDisturbance;

struct Hum {
    amplitude: f64,
    /// `2π f` [rad/s].
    omega: f64,
    phase: f64,
}

impl JointAction for Hum {
    fn motor_torque(&self, state: &JointState) -> f64 {
        self.amplitude * (self.omega * state.time + self.phase).sin()
    }

    fn fastest(&self, _speed: f64) -> f64 {
        self.omega
    }
}

impl Effect for PeriodicDisturbance {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let hum =
            Hum { amplitude: given.get("amplitude"), omega: TAU * given.get("frequency"), phase: given.get("phase") };
        Ok(vec![Action::Joint(need_joint(&ABOUT, model, joint)?, Box::new(hum))])
    }
    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for PeriodicDisturbance {
    /// Rows that average over tens of milliseconds do not show it.
    fn applies(&self, _motion: &Motion, _joint: usize) -> bool {
        false
    }

    fn of_line(&self, frequency: f64, amplitude: f64, phase: f64) -> Option<Vec<f64>> {
        Some(vec![amplitude, frequency, phase])
    }

    fn columns(&self, _motion: &Motion, _joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        Vec::new()
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], _coefficients: &[f64]) -> Vec<f64> {
        Vec::new()
    }
}

//! A torque at a fixed frequency in time: from a pump, a fan, a converter, or another machine.
//!
//! The rotor feels `a sin(2π f t + φ)`, `t` since the start of the session, for any motion of the joint.
//! Left out: a disturbance that acts on the link, or that moves the base.
//! Reference: G. F. Franklin, J. D. Powell, M. Workman (1998), Digital Control of Dynamic Systems, ch. 8.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::parameters::need_joint;
use super::{
    About, Action, Claim, Effect, JointAction, JointState, Kind, ParameterSpec, Parameters, Phenomenon, Scope,
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
    signature: "a line at one frequency, the same at every speed and at rest",
    look_alikes: &["cogging", "torque_ripple"],
    separate_by: "several constant speeds: a torque that depends on an angle changes its frequency, this one does not",
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

    fn claims(&self, phenomenon: &Phenomenon) -> Option<Claim> {
        match phenomenon {
            Phenomenon::Line { frequency, amplitude, phase } => {
                Some(vec![("amplitude", *amplitude), ("frequency", *frequency), ("phase", *phase)])
            }
            _ => None,
        }
    }
}

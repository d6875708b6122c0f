//! Viscous friction falls while the lubricant warms up.
//!
//! `F_V → F_V (1 + a e^{−t/T})`, `t` since the start of the session: a cold gear is stiffer by `a`, and forgets it within a few `T`.
//! The motor has to add `a F_V e^{−t/T} v`.
//! Left out: heat that the motion itself makes, Coulomb friction that changes with temperature.
//! Reference: A. C. Bittencourt, P. Axelsson (2014), Modeling and experiment design for identification of wear in a robot joint under
//! load and temperature uncertainties based on friction data.

use std::collections::BTreeMap;

use super::parameters::{need_friction, need_joint};
use super::{About, Action, Effect, JointAction, JointState, Kind, ParameterSpec, Parameters, Scope};
use crate::error::Result;
use crate::gearhead::Direction;
use crate::robot::Model;

static ABOUT: About = About {
    name: "thermal_friction_drift",
    summary: "Viscous friction falls while the lubricant warms up.",
    equation: "F_V → F_V (1 + a e^{−t/T}), t since the start of the session",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("excess", "a", "1", "part by which viscous friction is larger at the start")
            .between(0.0, 20.0),
        ParameterSpec::new("time_constant", "T", "s", "time over which the excess falls to a third").at_least(1e-3),
    ],
    signature: "the viscous part of friction falls over minutes, whatever the motion",
    look_alikes: &["quadratic_drag", "viscous_asymmetry", "load_dependent_friction"],
    separate_by: "repeat the same motion later in the session, and the speeds in random order",
    reference: "A. C. Bittencourt, P. Axelsson (2014), Modeling and experiment design for identification of wear in a robot joint",
};

/// Viscous friction falls with time.
pub struct ThermalFrictionDrift;

struct Drift {
    /// `a F_V` [N·m·s/rad or N·s/m] by direction.
    excess: [f64; 2],
    time_constant: f64,
}

impl JointAction for Drift {
    fn dry_friction(&self, state: &JointState, level: f64) -> f64 {
        let v = state.motor_velocity;
        let excess = self.excess[Direction::of(v).index()];
        level + excess * (-state.time / self.time_constant).exp() * v.abs()
    }
}

impl Effect for ThermalFrictionDrift {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        let law = need_friction(&ABOUT, model, joint)?.law;
        let excess = [Direction::Positive, Direction::Negative].map(|side| given.get("excess") * law.viscous(side));
        Ok(vec![Action::Joint(joint, Box::new(Drift { excess, time_constant: given.get("time_constant") }))])
    }
}

//! Viscous friction falls while the lubricant gets warm.
//!
//! `F_V → F_V (1 + a e^{−t/T})`, `t` since the start of the session: in a cold gear it is larger by `a`, which decays within a few `T`.
//! The motor has to add `a F_V e^{−t/T} v`; every session starts cold again. The logarithm of `T` is scanned.
//! Left out: heat from the motion itself, Coulomb friction that changes with temperature.
//! Reference: A. C. Bittencourt, P. Axelsson (2014), Modeling and experiment design for identification of wear in a robot joint under
//! load and temperature uncertainties based on friction data.

use std::collections::BTreeMap;

use super::parameters::{need_friction, need_joint};
use super::{
    About, Action, Diagnosable, Effect, JointAction, JointState, Kind, Motion, ParameterSpec, Parameters, Scope,
};
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
        ParameterSpec::new("time_constant", "T", "s", "time over which the excess falls to a third").between(1e-3, 1e7),
    ],
    signature: "the viscous part of friction falls over minutes, whatever the motion",
    look_alikes: &["quadratic_drag", "viscous_asymmetry", "load_dependent_friction"],
    separate_by: "repeat the same motion later in the session, and the speeds in random order",
    reference: "A. C. Bittencourt, P. Axelsson (2014), Modeling and experiment design for identification of wear in a robot joint",
};

/// [s] Shortest time constant that is tried; a shorter drift ends within the first moves.
const FASTEST: f64 = 3.0;
/// [s] Longest time constant that is tried.
const SLOWEST: f64 = 600.0;
/// Factor between neighbouring time constants of the scan: `v e^{−t/T}` is correlated by 0.98 with that of its neighbour.
const SCAN_STEP: f64 = 1.6;

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

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for ThermalFrictionDrift {
    fn shapes(&self, motion: &Motion, _joint: usize) -> Vec<Vec<f64>> {
        let length = (0..motion.rows()).map(|row| motion.since_start(row)).fold(0.0, f64::max);
        // A drift slower than the longest session is a straight line, so its time constant cannot be determined.
        let slowest = length.clamp(FASTEST, SLOWEST);
        let steps = ((slowest / FASTEST).ln() / SCAN_STEP.ln()) as usize;
        (0..=steps).map(|step| vec![FASTEST.ln() + step as f64 * SCAN_STEP.ln()]).collect()
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        let time_constant = shape[0].exp();
        vec![motion.column(joint, |m, row| m.v[row] * (-motion.since_start(row) / time_constant).exp())]
    }

    fn parameters(&self, motion: &Motion, joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0] / motion.joints[joint].friction.viscous, shape[0].exp()]
    }
}

//! The torque constant varies with the angle of the motor shaft: commutation and winding are not ideal.
//!
//! `K_t → K_t (1 + a sin(n θ_m + φ))`: the rotor feels `a K i sin(n θ_m + φ)` in addition to `K i`, `K = ratio · K_t`.
//! Its amplitude is proportional to the current, unlike that of cogging. A conversion of the current to torque with the mean constant
//! gives `τ_m = τ − a τ_m sin(n θ_m + φ)` where the rotor feels `τ`: exact in the measured torque.
//! Left out: the same ripple of the back-EMF, which the current loop compensates as long as it has enough voltage.
//! Reference: T. M. Jahns, W. L. Soong (1996), Pulsating torque minimization techniques for permanent magnet AC motor drives.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::parameters::need_joint;
use super::{
    About, Action, Diagnosable, Effect, Harmonic, JointAction, JointState, Kind, Motion, ParameterSpec, Parameters,
    Scope,
};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "torque_ripple",
    summary: "The torque per ampere varies with the angle of the motor shaft.",
    equation: "K_t → K_t (1 + a sin(n θ_m + φ))",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("amplitude", "a", "1", "amplitude relative to the mean torque constant").between(0.0, 1.0),
        ParameterSpec::new("order", "n", "1", "periods per turn of the motor shaft").between(0.0, 10_000.0),
        ParameterSpec::new("phase", "φ", "rad", "phase at θ_m = 0").between(-TAU, TAU).or(0.0),
    ],
    signature: "a ripple at a whole order of the motor angle, in proportion to the current",
    look_alikes: &["cogging", "position_dependent_friction", "transmission_error"],
    separate_by: "pass the same angles slowly under several loads: the amplitude follows the current, that of cogging stays",
    reference: "T. M. Jahns, W. L. Soong (1996), Pulsating torque minimization techniques for permanent magnet AC motor drives",
};

/// Highest order that is tried.
const HIGHEST_ORDER: usize = 48;

/// The torque constant varies with the angle of the motor shaft.
pub struct TorqueRipple;

struct Ripple {
    /// `a K` [N·m/A or N/A].
    amplitude: f64,
    /// `n · ratio`.
    order: f64,
    phase: f64,
}

impl JointAction for Ripple {
    fn motor_torque(&self, state: &JointState) -> f64 {
        self.amplitude * state.current * (self.order * state.motor_position + self.phase).sin()
    }

    fn fastest(&self, speed: f64) -> f64 {
        self.order * speed
    }
}

impl Effect for TorqueRipple {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let index = need_joint(&ABOUT, model, joint)?;
        let joint = &model.joints[index];
        let ripple = Ripple {
            amplitude: given.get("amplitude") * joint.torque_per_ampere(),
            order: given.get("order") * joint.gear_ratio,
            phase: given.get("phase"),
        };
        Ok(vec![Action::Joint(index, Box::new(ripple))])
    }
    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for TorqueRipple {
    fn applies(&self, motion: &Motion, joint: usize) -> bool {
        motion.range(joint) * motion.model.joints[joint].gear_ratio > TAU
    }

    fn shapes(&self, _motion: &Motion, _joint: usize) -> Vec<Vec<f64>> {
        (1..=HIGHEST_ORDER).map(|order| vec![order as f64]).collect()
    }

    fn refines(&self) -> bool {
        false
    }

    fn harmonic(&self) -> Option<Harmonic> {
        Some(Harmonic {
            order: |motion, joint, shape| shape[0] * motion.model.joints[joint].gear_ratio,
            several: true,
            in_narrow_rows: None,
        })
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        motion.harmonic(joint, shape[0] * motion.model.joints[joint].gear_ratio, |m, row| -m.torque[row]).into()
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        // a sin(x + φ) = a sin φ · cos x + a cos φ · sin x
        vec![coefficients[0].hypot(coefficients[1]), shape[0], coefficients[0].atan2(coefficients[1])]
    }
}

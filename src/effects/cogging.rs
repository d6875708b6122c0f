//! A torque of the motor that varies with its angle and does not depend on current: cogging of slots and magnets, or a screw with runout.
//!
//! The rotor feels `τ_c sin(n θ_m + φ)`, `θ_m` the angle of the motor shaft, `n` periods per turn; the motor has to compensate it.
//! It does not change its sign with the direction of motion, and its amplitude does not depend on current or speed.
//! Left out: more than one harmonic (each is a separate effect).
//! Reference: D. Hanselman (2006), Brushless Permanent Magnet Motor Design, ch. 10.

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
    name: "cogging",
    summary: "A torque that varies with the angle of the motor shaft, whatever the current.",
    equation: "τ = τ_c sin(n θ_m + φ) on the rotor",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("amplitude", "τ_c", "N·m", "amplitude at the joint, the ratio included").between(0.0, 1e6),
        ParameterSpec::new("order", "n", "1", "periods per turn of the motor shaft").between(0.0, 10_000.0),
        ParameterSpec::new("phase", "φ", "rad", "phase at θ_m = 0").between(-TAU, TAU).or(0.0),
    ],
    signature: "a ripple at a whole order of the motor angle, in both directions alike, also at low current",
    look_alikes: &["position_dependent_friction", "cable_spring"],
    separate_by: "pass the same angles slowly in both directions and with another load: cogging changes its sign in neither case",
    reference: "D. Hanselman (2006), Brushless Permanent Magnet Motor Design, ch. 10",
};

/// Highest order that is tried.
const HIGHEST_ORDER: usize = 48;

/// A torque that varies with the angle of the motor shaft.
pub struct Cogging;

struct Ripple {
    amplitude: f64,
    order: f64,
    phase: f64,
    gear_ratio: f64,
}

impl JointAction for Ripple {
    fn motor_torque(&self, state: &JointState) -> f64 {
        self.amplitude * (self.order * self.gear_ratio * state.motor_position + self.phase).sin()
    }

    fn fastest(&self, speed: f64) -> f64 {
        self.order * self.gear_ratio * speed
    }
}

impl Effect for Cogging {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        let ripple = Ripple {
            amplitude: given.get("amplitude"),
            order: given.get("order"),
            phase: given.get("phase"),
            gear_ratio: model.joints[joint].gear_ratio,
        };
        Ok(vec![Action::Joint(joint, Box::new(ripple))])
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for Cogging {
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
        motion.harmonic(joint, shape[0] * motion.model.joints[joint].gear_ratio, |_, _| -1.0).into()
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        // τ_c sin(x + φ) = τ_c sin φ · cos x + τ_c cos φ · sin x
        vec![coefficients[0].hypot(coefficients[1]), shape[0], coefficients[0].atan2(coefficients[1])]
    }
}

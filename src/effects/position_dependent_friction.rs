//! Coulomb friction varies with the position of the joint: a bent shaft, uneven preload, a worn spot.
//!
//! `F_C → F_C (1 + a cos(n q + φ))`, `q` the joint position on the motor side. Its torque changes its sign with the direction of motion,
//! while a cogging torque does not.
//! Left out: variations with more than one harmonic.
//! Reference: M. Gautier et al. (2013); R. Waiboer, R. Aarts, B. Jonker (2005), Velocity dependence of joint friction in robotic
//! manipulators with gear transmissions.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use super::parameters::{need_friction, need_joint};
use super::{
    About, Action, Diagnosable, Effect, Harmonic, JointAction, JointState, Kind, Motion, ParameterSpec, Parameters,
    Scope,
};
use crate::error::Result;
use crate::gearhead::{Direction, FrictionLaw};
use crate::robot::Model;

static ABOUT: About = About {
    name: "position_dependent_friction",
    summary: "Coulomb friction varies with the position of the joint.",
    equation: "F_C → F_C (1 + a cos(n q + φ))",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("amplitude", "a", "1", "relative variation of Coulomb friction").between(0.0, 0.95),
        ParameterSpec::new("order", "n", "1/rad", "periods in 2π of joint position").between(0.0, 1e5),
        ParameterSpec::new("phase", "φ", "rad", "phase at q = 0").between(-TAU, TAU).or(0.0),
    ],
    signature: "a torque that varies with the position and changes its sign with the direction of motion",
    look_alikes: &["cogging", "load_dependent_friction", "cable_spring"],
    separate_by: "pass the same positions slowly in both directions: half the difference of the torques is friction, half the sum is not",
    reference: "R. Waiboer, R. Aarts, B. Jonker (2005), Velocity dependence of joint friction in robotic manipulators with gear transmissions",
};

/// Coulomb friction varies with the position of the joint.
pub struct PositionDependentFriction;

struct Map {
    /// Coulomb friction `[positive, negative]`.
    coulomb: [f64; 2],
    a: f64,
    n: f64,
    phi: f64,
}

impl JointAction for Map {
    fn dry_friction(&self, state: &JointState, level: f64) -> f64 {
        let coulomb = self.coulomb[Direction::of(state.motor_velocity).index()];
        (level + coulomb * self.a * (self.n * state.motor_position + self.phi).cos()).max(0.0)
    }

    fn fastest(&self, speed: f64) -> f64 {
        self.n * speed
    }
}

impl Effect for PositionDependentFriction {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        let coulomb = match need_friction(&ABOUT, model, joint)?.law {
            FrictionLaw::Exponential(law) => law.map(|side| side.coulomb),
            FrictionLaw::TwoLines(law) => law.map(|side| side.a2),
        };
        let map = Map { coulomb, a: given.get("amplitude"), n: given.get("order"), phi: given.get("phase") };
        Ok(vec![Action::Joint(joint, Box::new(map))])
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for PositionDependentFriction {
    fn shapes(&self, motion: &Motion, joint: usize) -> Vec<Vec<f64>> {
        let range = motion.range(joint);
        // Two orders that differ by π/range are half a period apart over the whole range; one third of that step is fine enough.
        // Highest order: three periods per motor turn.
        let step = PI / (3.0 * range.max(1e-9));
        let highest = 3.2 * motion.model.joints[joint].gear_ratio;
        // Below about a third of a period the wave is a parabola, which many curves resemble.
        let lowest = TAU * 0.35 / range.max(1e-9);
        let count = (((highest - lowest) / step) as usize).min(2000);
        (0..count).map(|index| vec![lowest + step * index as f64]).collect()
    }

    fn harmonic(&self) -> Option<Harmonic> {
        Some(Harmonic { order: |_, _, shape| shape[0], several: true, in_narrow_rows: None })
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        motion.harmonic(joint, shape[0], |m, row| m.friction.coulomb * m.direction[row]).into()
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        // a cos(n q + φ) = a cos φ · cos n q − a sin φ · sin n q
        vec![coefficients[0].hypot(coefficients[1]), shape[0], (-coefficients[1]).atan2(coefficients[0])]
    }
}

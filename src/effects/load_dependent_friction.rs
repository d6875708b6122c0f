//! Friction that grows with the torque through the gear: tooth and bearing losses.
//!
//! `F → F + μ |T| sgn v`, `T` the torque through the gear, on rotor and link in the shares of the friction law.
//! In the data, `T` is the torque that the links need for the measured motion, with the part of friction that acts behind the gear.
//! That share `s` is unknown and therefore scanned. Friction by load behind the gear adds to the load: with the link torque `L` and
//! the other friction `F`, `T sgn v = L sgn v + s (F + μ |T|)`. While the motor drives the link, `|T| = |L + s F sgn v|/(1 − s μ)`, and the
//! coefficient of `|L + s F sgn v|` is `c = μ/(1 − s μ)`. Where the link drives the motor it is `μ/(1 + s μ)`, which is left out.
//! Left out: a coefficient that differs between the two cases.
//! Reference: A. C. Bittencourt, S. Gunnarsson (2012), Static friction in a robot joint: modeling and identification of load and temperature effects.

use std::collections::BTreeMap;

use super::parameters::need_joint;
use super::{
    About, Action, Diagnosable, Effect, JointAction, JointState, Kind, Motion, ParameterSpec, Parameters, Scope,
};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "load_dependent_friction",
    summary: "Friction grows with the torque through the gear.",
    equation: "F → F + μ |T| sgn v, T the torque through the gear",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[ParameterSpec::new("coefficient", "μ", "1", "friction per torque through the gear").between(0.0, 1.0)],
    signature: "friction is larger where the joint accelerates or carries weight, in the direction of motion",
    look_alikes: &["payload", "position_dependent_friction", "quadratic_drag"],
    separate_by: "repeat the same motion with a known extra load on the link, and move both with and against it",
    reference: "A. C. Bittencourt, S. Gunnarsson (2012), Static friction in a robot joint",
};

/// Friction that grows with the torque through the gear.
pub struct LoadDependentFriction;

struct Load(f64);

impl JointAction for Load {
    fn dry_friction(&self, state: &JointState, level: f64) -> f64 {
        level + self.0 * state.gear_torque.abs()
    }
}

impl Effect for LoadDependentFriction {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let mu = Parameters::check(&ABOUT, model, given)?.get("coefficient");
        Ok(vec![Action::Joint(need_joint(&ABOUT, model, joint)?, Box::new(Load(mu)))])
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for LoadDependentFriction {
    fn shapes(&self, motion: &Motion, joint: usize) -> Vec<Vec<f64>> {
        match motion.model.joints[joint].friction {
            Some(friction) => vec![vec![friction.link_share]],
            None => vec![vec![0.0], vec![0.2], vec![0.4], vec![0.6]],
        }
    }

    fn refines(&self) -> bool {
        false
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        let link_share = shape[0];
        vec![motion.column(joint, |m, row| {
            let friction = m.friction.dry(m.v[row]) * m.direction[row] + m.friction.viscous * m.v[row];
            (m.link_torque[row] + link_share * friction).abs() * m.direction[row]
        })]
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        let (c, link_share) = (coefficients[0], shape[0]);
        vec![c / (1.0 + link_share * c)]
    }
}

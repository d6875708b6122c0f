//! The gear is much softer than in the model: a flexspline, a belt, a worn coupling.
//!
//! Outside the gap `T = k p + d ṗ` with this `k` instead of the nominal one; `d` changes in the same proportion, because the
//! relaxation time `d/k` is a property of the material. Rotor and link wind up by `T/k` against each other, and oscillate at
//! `ω = √(k (1/J + W))`, `W` the link's mobility.
//! Left out: stiffness that grows with torque.
//! Reference: M. W. Spong (1987), Modeling and control of elastic joint robots.

use std::collections::BTreeMap;

use super::parameters::need_joint;
use super::{About, Action, Claim, Effect, Kind, ParameterSpec, Parameters, Phenomenon, Scope};
use crate::error::Result;
use crate::gearhead::rigid::RELAXATION;
use crate::robot::Model;

static ABOUT: About = About {
    name: "joint_compliance",
    summary: "The gear between rotor and link is softer than the model says.",
    equation: "T = k p + d ṗ outside the gap, d/k as nominal",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("stiffness", "k", "N·m/rad", "stiffness of the gear outside its gap").between(1e-6, 1e11)
    ],
    signature: "a wind-up in proportion to torque, a resonance, and a reversal that is softer than a gap",
    look_alikes: &["position_dependent_backlash", "presliding", "sensor_delay"],
    separate_by: "load the joint against a stop or with a weight: the wind-up is proportional to torque, a gap is not",
    reference: "M. W. Spong (1987), Modeling and control of elastic joint robots",
};

/// The gear is softer.
pub struct JointCompliance;

impl Effect for JointCompliance {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let k = Parameters::check(&ABOUT, model, given)?.get("stiffness");
        let joint = need_joint(&ABOUT, model, joint)?;
        let joint = &mut model.joints[joint];
        joint.gear_damping = match joint.gear_stiffness {
            Some(nominal) => joint.gear_damping.map(|damping| damping * (k / nominal)),
            None => joint.gear_damping.or(Some(RELAXATION * k)),
        };
        joint.gear_stiffness = Some(k);
        Ok(Vec::new())
    }

    fn claims(&self, phenomenon: &Phenomenon) -> Option<Claim> {
        match phenomenon {
            Phenomenon::WindUp { stiffness } => Some(vec![("stiffness", *stiffness)]),
            _ => None,
        }
    }
}

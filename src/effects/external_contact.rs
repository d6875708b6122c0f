//! The link runs up against something that the model does not know of: a cover, a cable duct, the workpiece.
//!
//! Beyond the angle `q_c` the link feels `−(k p + c ṗ)`, `p = q − q_c`, as long as that pushes it back; on the other side
//! (`side = −1`) below the angle. Touching and leaving are located events, as those of an end stop.
//! Left out: friction along the surface, and what the contact does to other joints.
//! Reference: S. Haddadin, A. De Luca, A. Albu-Schäffer (2017), Robot collisions: a survey on detection, isolation, and identification.

use std::collections::BTreeMap;

use super::parameters::{misfit, need_joint};
use super::{About, Action, Effect, Kind, ParameterSpec, Parameters, Scope, Stop};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "external_contact",
    summary: "The link runs up against something in one range of its angle.",
    equation: "τ = −(k p + c ṗ) on the link, p = q − q_c > 0, never pulling",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("angle", "q_c", "rad (joint)", "position of the link at which it touches"),
        ParameterSpec::new("stiffness", "k", "N·m/rad", "torque per angle beyond it").between(1e-6, 1e6),
        ParameterSpec::new("damping", "c", "N·m·s/rad", "torque per velocity beyond it").at_least(0.0).or(0.0),
        ParameterSpec::new("side", "s", "1", "+1: it stops motion beyond the angle; −1: below it")
            .between(-1.0, 1.0)
            .or(1.0),
    ],
    signature: "torque rises beyond an angle of one joint, in both directions of motion, on one side only",
    look_alikes: &["cable_spring", "coupling_slip", "position_dependent_friction"],
    separate_by: "pass the angle from both sides, with other joints elsewhere: what stands in the room moves against the joint's angle",
    reference: "S. Haddadin, A. De Luca, A. Albu-Schäffer (2017), Robot collisions: a survey on detection, isolation, and identification",
};

/// The link runs up against something.
pub struct ExternalContact;

impl Effect for ExternalContact {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        let side = given.get("side");
        if side.abs() != 1.0 {
            return Err(misfit(&ABOUT, model, "side", side, "+1 or −1".to_owned()));
        }
        let (place, stiffness, damping) = (given.get("angle"), given.get("stiffness"), given.get("damping"));
        Ok(vec![Action::Stop(joint, Stop { side, place, stiffness, damping })])
    }
}

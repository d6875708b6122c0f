//! The link runs up against something that the model does not know of: a cover, a cable duct, the workpiece.
//!
//! Beyond the angle `q_c` the link feels `−(k p + c ṗ)`, `p = q − q_c`, as long as that pushes it back; on the other side
//! (`side = −1`) below the angle. Touching and leaving are located events, as those of an end stop.
//! The motor has to add `k p` while it presses: a torque that grows beyond one angle and is nothing on the other side of it, in both
//! directions of motion. A part of the range has to be free, else it is a cable. The damping is too small a part of the torque to be told.
//! On a machine with gaps a diagnosis leaves out what happens around reversals: a contact that a joint only grazes to turn around there
//! is missed. While the joint presses, its gear is loaded on one flank, and the rows count.
//! Where the link touches the rotor tells to half a gap only: `q = θ − side · b/2` while it presses, from a zero that lies somewhere in the gap.
//! Left out: friction along the surface, and what the contact does to other joints.
//! Reference: S. Haddadin, A. De Luca, A. Albu-Schäffer (2017), Robot collisions: a survey on detection, isolation, and identification.

use std::collections::BTreeMap;

use super::parameters::{misfit, need_joint};
use super::{About, Action, Diagnosable, Effect, Kind, Motion, ParameterSpec, Parameters, Scope, Stop};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "external_contact",
    summary: "The link runs up against something in one range of its angle.",
    equation: "τ = −(k p + c ṗ) on the link, p = q − q_c > 0, never pulling",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("angle", "q_c", "rad (joint)", "position of the link at which it touches")
            .between(-1e3, 1e3),
        ParameterSpec::new("stiffness", "k", "N·m/rad", "torque per angle beyond it").between(1e-6, 1e6),
        ParameterSpec::new("damping", "c", "N·m·s/rad", "torque per velocity beyond it").between(0.0, 1e6).or(0.0),
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

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

/// Positions that are scanned on either side.
const SCANNED: usize = 16;
/// Parts of the range that have to lie free of the contact, and beyond its angle.
const FREE: f64 = 0.3;
const TOUCHED: f64 = 0.04;
/// Part of Coulomb friction that a contact has to press with where it is deepest: one that presses less cannot be felt through a joint
/// whose friction changes by as much along its travel.
const PRESSING: f64 = 0.3;

impl Diagnosable for ExternalContact {
    fn loads_link(&self) -> bool {
        true
    }

    fn shapes(&self, motion: &Motion, joint: usize) -> Vec<Vec<f64>> {
        let q = &motion.joints[joint].q;
        let (low, high) =
            q.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| (low.min(*q), high.max(*q)));
        let range = high - low;
        if !range.is_finite() || range <= 0.0 {
            return Vec::new();
        }
        let part = |step: usize| FREE + (1.0 - TOUCHED - FREE) * step as f64 / (SCANNED - 1) as f64;
        let above = (0..SCANNED).map(|step| vec![low + part(step) * range, 1.0]);
        let below = (0..SCANNED).rev().map(|step| vec![high - part(step) * range, -1.0]);
        above.chain(below).collect()
    }

    /// The side is a choice.
    fn refined_shapes(&self, _shape: &[f64]) -> usize {
        1
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        let (place, side) = (shape[0], shape[1]);
        vec![motion.column(joint, |m, row| side * (side * (m.q[row] - place)).max(0.0))]
    }

    /// Where it presses with less than that part of friction, it is friction that varies along the way.
    fn is_itself(&self, motion: &Motion, joint: usize, shape: &[f64], coefficients: &[f64]) -> bool {
        let (place, side) = (shape[0], shape[1]);
        let m = &motion.joints[joint];
        let deepest = m.q.iter().map(|q| side * (q - place)).fold(0.0, f64::max);
        coefficients[0] * deepest > PRESSING * m.friction.coulomb
    }

    fn angles_of_link(&self) -> &'static [&'static str] {
        &["angle"]
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        let (place, side) = (shape[0], shape[1]);
        vec![place, coefficients[0], 0.0, side]
    }
}

//! The link touches something that is not in the model: a cover, a cable duct, the workpiece.
//!
//! Beyond the angle `q_c` the link feels `−(k p + c ṗ)`, `p = q − q_c`, as long as that pushes it back; with
//! `side = −1`, below the angle. Touching and leaving are located events, like those of an end stop.
//! The motor has to add `k p` during contact: a torque that grows beyond one angle and is zero on the other side of it, in both
//! directions of motion. A part of the range has to be free, otherwise it is a cable. The damping torque is too small to be identified.
//! On a machine with gaps a diagnosis leaves out rows around reversals, so it misses a contact that a joint touches only briefly while it
//! reverses. During a longer contact the gear is loaded on one flank, and the rows count.
//! The rotor's angle shows the position of the contact only to half a gap: `q = θ − side · b/2` during contact, with a zero somewhere in the gap.
//! Left out: friction along the surface, and the effect of the contact on other joints.
//! Reference: S. Haddadin, A. De Luca, A. Albu-Schäffer (2017), Robot collisions: a survey on detection, isolation, and identification.

use std::collections::BTreeMap;

use super::parameters::{misfit, need_joint};
use super::{About, Action, Diagnosable, Effect, Kind, Motion, ParameterSpec, Parameters, Scope, Stop};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "external_contact",
    summary: "The link touches something in a part of its range.",
    equation: "τ = −(k p + c ṗ) on the link, p = q − q_c > 0, never pulling",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("angle", "q_c", "rad (joint)", "position of the link at which it touches")
            .between(-1e3, 1e3),
        ParameterSpec::new("stiffness", "k", "N·m/rad", "torque per angle beyond it").between(1e-6, 1e6).as_size(),
        ParameterSpec::new("damping", "c", "N·m·s/rad", "torque per velocity beyond it").between(0.0, 1e6).or(0.0),
        ParameterSpec::new("side", "s", "1", "+1: it stops motion beyond the angle; −1: below it")
            .between(-1.0, 1.0)
            .or(1.0),
    ],
    signature: "torque rises beyond an angle of one joint, in both directions of motion, on one side only",
    look_alikes: &["cable_spring", "coupling_slip", "position_dependent_friction"],
    separate_by: "pass the angle from both sides, and with other joints in other positions: an obstacle that stands in the room is then touched at another angle",
    reference: "S. Haddadin, A. De Luca, A. Albu-Schäffer (2017), Robot collisions: a survey on detection, isolation, and identification",
};

/// The link touches something.
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

/// Number of positions that are scanned on either side.
const SCANNED: usize = 16;
/// Least part of the range that is free of the contact, and least part beyond its angle.
const FREE: f64 = 0.3;
const TOUCHED: f64 = 0.04;
/// Least torque of a contact at its deepest point, relative to Coulomb friction: a weaker contact cannot be separated from a friction
/// that changes by as much along the range.
const PRESSING: f64 = 0.3;

impl Diagnosable for ExternalContact {
    fn loads_link(&self) -> bool {
        true
    }

    fn shapes(&self, motion: &Motion, joint: usize) -> Vec<Vec<f64>> {
        let q = motion.link(joint);
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

    /// The side is a discrete choice.
    fn refined_shapes(&self, _shape: &[f64]) -> usize {
        1
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        let (place, side) = (shape[0], shape[1]);
        vec![motion.link(joint).iter().map(|q| side * (side * (q - place)).max(0.0)).collect()]
    }

    /// A contact with less torque than that part of friction is position-dependent friction.
    fn is_itself(&self, motion: &Motion, joint: usize, shape: &[f64], coefficients: &[f64]) -> bool {
        let (place, side) = (shape[0], shape[1]);
        let deepest = motion.link(joint).iter().map(|q| side * (q - place)).fold(0.0, f64::max);
        coefficients[0] * deepest > PRESSING * motion.joints[joint].friction.coulomb
    }

    fn angles_of_link(&self) -> &'static [&'static str] {
        &["angle"]
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        let (place, side) = (shape[0], shape[1]);
        vec![place, coefficients[0], 0.0, side]
    }
}

//! Masses of moving bodies: the sum of a body's links, the nearest possible inertia if the sum is impossible, joints that move no mass.
//!
//! Links fixed to each other are summed first. Only the sum enters the equations of motion, so only the sum must be physically
//! possible; inertias of links that do not move have no effect and are not checked.

use nalgebra::Matrix3;

use super::Urdf;
use super::description::Link;
use crate::error::Result;
use crate::robot::remark::Remark;
use crate::robot::tree::{Inertia, Robot};
use crate::units::JointKind;

/// [kg] Least mass, that of a speck of dust. A smaller mass counts as zero.
const LEAST_MASS: f64 = 1e-9;

/// [kg·m²] Least moment of inertia about a joint: that mass at a tenth of a millimetre from the axis.
const LEAST_MOMENT: f64 = 1e-17;

/// A link and its inertia in the frame of its body.
pub(super) struct Part<'a> {
    pub link: &'a Link,
    pub inertia: Inertia,
    /// Whether it has an element `<inertia>`; without one its tensor is zero.
    pub has_tensor: bool,
}

impl Urdf<'_> {
    /// Inertia of a moving body of these parts; the first one is the link that its joint moves.
    ///
    /// # Errors
    /// A mass is negative.
    pub(super) fn body_inertia(&self, parts: &[Part<'_>], remarks: &mut Vec<Remark>) -> Result<Inertia> {
        for Part { link, inertia, has_tensor } in parts {
            if inertia.mass < 0.0 {
                return Err(self.text.error("link", &link.name, "mass", inertia.mass, "a mass ≥ 0 [kg]"));
            }
            if !has_tensor && inertia.mass > 0.0 {
                let text = "no <inertia>: its mass counts as that of a point";
                remarks.push(self.text.remark("link", &link.name, "inertial", text));
            }
        }
        let sum = parts.iter().fold(Inertia::zero(), |sum, part| sum.joined(&part.inertia));
        let sum = if sum.mass < LEAST_MASS { Inertia { mass: 0.0, ..sum } } else { sum };
        let used = sum.physical();
        // An inertia that is impossible only by rounding is corrected without a remark.
        if used != sum && sum.fault().is_some() {
            remarks.push(self.replaced(parts, &sum, &used));
        } else {
            remarks.extend(parts.iter().filter_map(|part| self.odd(part, parts.len() > 1)));
        }
        Ok(used)
    }

    /// The remark that a body gets another tensor. It is placed at the first of its links whose own inertia is impossible.
    fn replaced(&self, parts: &[Part<'_>], sum: &Inertia, used: &Inertia) -> Remark {
        let faulty = parts.iter().find(|part| part.inertia.fault().is_some());
        let name = faulty.or(parts.first()).map_or("", |part| part.link.name.as_str());
        let whole = if parts.len() > 1 { " of it and the links fixed to it" } else { "" };
        let fault = sum.fault().unwrap_or_default();
        let [given, nearest] = [sum, used].map(|inertia| written(&inertia.tensor));
        let text = format!(
            "no rigid body has the inertia{whole}, {given} about the centre of mass: {fault}. \
             The nearest one that a body of this mass has is used: {nearest} kg·m²"
        );
        self.text.remark("link", name, "inertia", &text)
    }

    /// The remark on a link whose own inertia is impossible, in a body whose sum is possible.
    fn odd(&self, part: &Part<'_>, together: bool) -> Option<Remark> {
        let fault = part.inertia.fault()?;
        let whole = if together { ", summed with the links fixed to it" } else { "" };
        let text = format!("no rigid body has its inertia: {fault}. It is used as it stands{whole}");
        Some(self.text.remark("link", &part.link.name, "inertia", &text))
    }

    /// Checks that each joint moves some inertia: that of its own link or of links further out.
    pub(super) fn check_bodies(&self, tree: &Robot, remarks: &mut Vec<Remark>) -> Result<()> {
        for ((body, carried), moved) in tree.bodies.iter().zip(tree.carried()).zip(tree.moved_inertias()) {
            let joint = &body.joint.name;
            if moves_nothing(body.joint.kind, moved) {
                let (part, value, expected) = match body.joint.kind {
                    JointKind::Revolute if carried.mass >= LEAST_MASS => (
                        "inertia",
                        moved,
                        format!("a moment of inertia ≥ {LEAST_MOMENT:e} [kg·m²] about the axis of joint {joint}"),
                    ),
                    _ => (
                        "mass",
                        carried.mass,
                        format!("a mass ≥ {LEAST_MASS:e} [kg] of the link that moves and all that is fixed to it"),
                    ),
                };
                return Err(self.text.error("link", &body.name, part, value, expected));
            }
            if body.inertia == Inertia::zero() {
                let text = format!("no mass: joint {joint} moves only the links beyond this one");
                remarks.push(self.text.remark("link", &body.name, "mass", &text));
            }
        }
        Ok(())
    }

    /// Joints of a tree that move nothing with an inertia.
    pub(super) fn idle(tree: &Robot) -> impl Iterator<Item = &str> {
        let idle = |body: &crate::robot::Body, moved| moves_nothing(body.joint.kind, moved);
        let bodies = tree.bodies.iter().zip(tree.moved_inertias());
        bodies.filter(move |(body, moved)| idle(body, *moved)).map(|(body, _)| body.joint.name.as_str())
    }
}

fn moves_nothing(kind: JointKind, moved: f64) -> bool {
    let least = match kind {
        JointKind::Revolute => LEAST_MOMENT,
        JointKind::Prismatic => LEAST_MASS,
    };
    moved < least
}

/// A tensor with the names that a URDF uses.
fn written(tensor: &Matrix3<f64>) -> String {
    let entry = |name: &str, row, column| format!("{name} {:.4e}", tensor[(row, column)]);
    let entries = [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)];
    format!("[{}]", entries.map(|(name, row, column)| entry(name, row, column)).join(", "))
}

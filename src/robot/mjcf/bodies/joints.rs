//! Joints: where they are, how they move, what limits and brakes them.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::super::actuators::{Mimic, limited};
use super::super::classes::Item;
use super::super::compiler::unit;
use super::super::document::Node;
use super::super::written::escaped;
use super::{Around, Walk, own_name};
use crate::error::Result;
use crate::robot::drives::DriveData;
use crate::robot::urdf::LARGEST_DAMPING;

impl<'n> Walk<'n> {
    /// [rad or m] One unit of a joint's positions.
    pub(super) fn unit_of(&self, item: &Item<'_>) -> Result<f64> {
        Ok(if kind(item)? == "hinge" { self.compiler.angle } else { 1.0 })
    }

    /// Writes a joint and returns the pose of the body in the frame of the link that the joint moves.
    pub(super) fn joint(
        &mut self,
        node: &'n Node,
        around: Around<'n>,
        body: &Node,
        (parent, link): (&str, &str),
        at: &Isometry3<f64>,
    ) -> Result<Isometry3<f64>> {
        let fallback = || format!("{}_joint", body.attribute("name").unwrap_or("body"));
        let given = node.attribute("name").map(str::to_owned);
        let name = own_name(&mut self.joints, &given.unwrap_or_else(fallback));
        if node.name == "freejoint" {
            self.write_joint(node.main_line, (&name, "floating"), (parent, link), at, "");
            return Ok(Isometry3::identity());
        }
        let item = self.classes.with(node, around.class)?;
        let kind = kind(&item)?;
        let anchor = around.frame * nalgebra::Point3::from(Vector3::from(item.array::<3>("pos")?.unwrap_or_default()));
        let anchor = Translation3::from(anchor.coords);
        if kind == "fixed" {
            self.remarks
                .push(node.remark("of type fixed, which MuJoCo does not have: the body is fixed to its parent"));
            self.write_joint(node.main_line, (&name, kind), (parent, link), at, "");
            return Ok(Isometry3::identity());
        }
        if kind == "free" || kind == "ball" {
            let of_urdf = if kind == "free" { "floating" } else { "spherical" };
            self.write_joint(node.main_line, (&name, of_urdf), (parent, link), &(at * anchor), "");
            return Ok(anchor.inverse() * Isometry3::identity());
        }
        if let Some(damping) =
            item.numbers("damping", 1, 3)?.and_then(|damping| damping.first().copied()).filter(|c| *c > LARGEST_DAMPING)
        {
            let text = format!("its damping of {damping:e} holds it: it is fixed at its reference");
            self.remarks.push(node.remark(&text));
            self.write_joint(node.main_line, (&name, "fixed"), (parent, link), &(at * anchor), "");
            return Ok(anchor.inverse() * Isometry3::identity());
        }
        let axis = Vector3::from(item.array::<3>("axis")?.unwrap_or([0.0, 0.0, 1.0]));
        let axis = unit(around.frame.rotation * axis)
            .ok_or_else(|| node.error("axis", item.text("axis").unwrap_or_default(), "an axis that is not zero"))?;
        let reference = item.number_or("ref", 0.0)? * self.unit_of(&item)?;
        let back = if kind == "hinge" {
            Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(&axis, -reference))
        } else {
            Isometry3::from_parts(Translation3::from(*axis * -reference), UnitQuaternion::identity())
        };
        let limits = self.limits(&item, kind, &name)?;
        let inner = format!("<axis xyz=\"{} {} {}\"/>{limits}{}", axis.x, axis.y, axis.z, self.dynamics(&item, &name)?);
        let of_urdf = match (kind, limits.contains("lower")) {
            ("hinge", true) => "revolute",
            ("hinge", false) => "continuous",
            _ => "prismatic",
        };
        self.write_joint(node.main_line, (&name, of_urdf), (parent, link), &(at * anchor * back), &inner);
        Ok(anchor.inverse() * Isometry3::identity())
    }

    /// `<limit>`, with a range only where there is one.
    fn limits(&self, item: &Item<'_>, kind: &str, name: &str) -> Result<String> {
        let unit = self.unit_of(item)?;
        let range = limited(item, self.compiler, "range", "limited")?;
        let range = match (range, kind) {
            (Some([lower, upper]), _) => format!(" lower=\"{}\" upper=\"{}\"", lower * unit, upper * unit),
            (None, "slide") => " lower=\"-inf\" upper=\"inf\"".to_owned(),
            (None, _) => String::new(),
        };
        let of_joint = limited(item, self.compiler, "actuatorfrcrange", "actuatorfrclimited")?;
        let of_joint = of_joint.map(|[low, high]| low.abs().max(high.abs()));
        let of_actuators = self.actuators.get(name).and_then(|actuated| actuated.effort);
        let effort = of_joint.into_iter().chain(of_actuators).fold(f64::INFINITY, f64::min);
        Ok(format!("<limit{range} effort=\"{effort}\" velocity=\"inf\"/>"))
    }

    /// `<dynamics>` and `<mimic>` of a joint; also stores its drive data.
    fn dynamics(&mut self, item: &Item<'_>, name: &str) -> Result<String> {
        let damping = item.numbers("damping", 1, 3)?.unwrap_or_default();
        let friction = item.magnitude_or("frictionloss", 0.0)?;
        if damping.iter().skip(1).any(|higher| *higher != 0.0) {
            self.remarks.push(item.node.remark("only the part of its damping linear in velocity is taken"));
        }
        if item.numbers("stiffness", 1, 3)?.is_some_and(|stiffness| stiffness.iter().any(|value| *value != 0.0)) {
            self.remarks.push(item.node.remark("its spring (stiffness) is not taken"));
        }
        let armature = Some(item.magnitude_or("armature", 0.0)?).filter(|armature| *armature > 0.0);
        let gear_ratio = self.actuators.get(name).map(|actuated| actuated.gear).filter(|gear| *gear > 1.0);
        self.drives.insert(name.to_owned(), DriveData { gear_ratio, armature, ..DriveData::default() });
        let mut out = String::new();
        let damping = damping.first().copied().unwrap_or_default();
        if damping != 0.0 || friction != 0.0 {
            out = format!("<dynamics damping=\"{damping}\" friction=\"{friction}\"/>");
        }
        if let Some(Mimic { other, polynomial: [a0, a1] }) = self.mimics.get(name) {
            let reference = |joint: &str| self.references.get(joint).copied().unwrap_or_default();
            let offset = reference(name) + a0 - a1 * reference(other);
            out += &format!("<mimic joint=\"{}\" multiplier=\"{a1}\" offset=\"{offset}\"/>", escaped(other));
        }
        Ok(out)
    }
}

/// How a joint moves. `fixed` is a word of other simulators, whose meaning is clear.
fn kind(item: &Item<'_>) -> Result<&'static str> {
    if item.text("type") == Some("fixed") {
        return Ok("fixed");
    }
    item.node.word("type", item.text("type").unwrap_or("hinge"), &["hinge", "slide", "ball", "free"])
}

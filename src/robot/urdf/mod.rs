//! From URDF to the tree: the only place that names `urdf_rs`.
//!
//! Fixed joints, and movable ones that are held at zero, are merged: their link becomes part of the parent's body.

mod checks;
mod grammar;
mod inertials;
mod mesh;
mod scan;
mod text;
mod tree;

use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use urdf_rs::JointType;

use self::text::UrdfText;
use super::tree::{Inertia, Limits};
use crate::error::{Error, Place, Result};
use crate::units::JointKind;

/// [m/s²] Gravity if the model file gives none.
pub const STANDARD_GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// A URDF with line numbers. Its numbers are checked, and its links and joints form a tree.
pub(super) struct Urdf<'a> {
    file: &'a Path,
    text: UrdfText<'a>,
    robot: urdf_rs::Robot,
    root: usize,
}

impl<'a> Urdf<'a> {
    /// Reads the text of a URDF.
    ///
    /// # Errors
    /// It is not a URDF, a value is not a number, links and joints do not form a tree, or the inertia of a link is not
    /// physical.
    pub(super) fn parse(file: &'a Path, text: &'a str) -> Result<Self> {
        if text.contains("<xacro:") {
            return Err(Error::input(file, Place::File, "", "", "plain URDF; run xacro on this file first"));
        }
        let scanned = UrdfText::scan(file, text)?;
        let robot = urdf_rs::read_from_string(text).map_err(|error| unread(file, &error.to_string()))?;
        let root = checks::root_of(&scanned, &robot)?;
        let urdf = Self { file, text: scanned, robot, root };
        urdf.check_links()?;
        urdf.check_joints()?;
        urdf.check_shapes()?;
        Ok(urdf)
    }

    /// Names of the joints that turn or slide, in the order of the file.
    pub(super) fn movable_joints(&self) -> Vec<&str> {
        let movable = self.robot.joints.iter().filter(|joint| kind_of(joint).is_some() && joint.mimic.is_none());
        movable.map(|joint| joint.name.as_str()).collect()
    }

    /// Whether a joint follows another one.
    pub(super) fn mimics(&self, name: &str) -> bool {
        self.robot.joints.iter().any(|joint| joint.name == name && joint.mimic.is_some())
    }
}

/// An error of the URDF parser. For XML errors, line and reason are taken from its text:
/// `Line: 7, Column: 32, Reason: ...`.
fn unread(file: &Path, message: &str) -> Error {
    let line = message.split_once("Line: ").and_then(|(_, rest)| rest.split(',').next()?.trim().parse().ok());
    let reason = message.split_once("Reason: ").map_or(message, |(_, reason)| reason);
    Error::input(file, line.map_or(Place::File, Place::Line), "URDF", "", format!("well-formed XML ({reason})"))
}

fn kind_of(joint: &urdf_rs::Joint) -> Option<JointKind> {
    match joint.joint_type {
        JointType::Revolute | JointType::Continuous => Some(JointKind::Revolute),
        JointType::Prismatic => Some(JointKind::Prismatic),
        JointType::Fixed | JointType::Floating | JointType::Planar | JointType::Spherical => None,
    }
}

/// [rad or m, rad/s or m/s, N·m or N] Limits from here on count as none: exporters write 1e16 or the largest number for
/// a continuous joint.
const UNLIMITED: f64 = 1e9;

/// Limits. URDF's default of zero counts as not given, and so does the range of a continuous joint.
fn limits_of(joint: &urdf_rs::Joint) -> Limits {
    let given = |value: f64| if value > 0.0 && value < UNLIMITED { value } else { f64::INFINITY };
    let urdf_rs::JointLimit { lower, upper, effort, velocity, .. } = joint.limit;
    let free = joint.joint_type == JointType::Continuous || (lower == 0.0 && upper == 0.0);
    let (lower, upper) = if free { (f64::NEG_INFINITY, f64::INFINITY) } else { (lower, upper) };
    let lower = if lower <= -UNLIMITED { f64::NEG_INFINITY } else { lower };
    let upper = if upper >= UNLIMITED { f64::INFINITY } else { upper };
    Limits { lower, upper, effort: given(effort), velocity: given(velocity) }
}

/// Inertia of a link in the link's frame, rotated from its inertial frame.
fn inertia_of(inertial: &urdf_rs::Inertial) -> Inertia {
    let urdf_rs::Inertia { ixx, ixy, ixz, iyy, iyz, izz } = inertial.inertia;
    let tensor = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
    Inertia { mass: inertial.mass.value, com: Vector3::zeros(), tensor }.seen_from(&isometry(&inertial.origin))
}

/// URDF's `xyz` and `rpy`: rotation about the fixed axes x, y, z in this order, then translation.
fn isometry(pose: &urdf_rs::Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = pose.rpy.0;
    Isometry3::from_parts(
        Translation3::from(Vector3::from(pose.xyz.0)),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

//! From URDF to the tree.
//!
//! Fixed joints, and movable ones that are held, are merged: their link becomes part of the parent's body. A value that is taken otherwise
//! than it stands in the file is remarked, with its line.

mod checks;
mod description;
mod grammar;
mod inertials;
mod masses;
mod mesh;
mod scan;
mod text;
mod tree;

use std::path::Path;

use nalgebra::Vector3;

use self::description::{Description, Joint, JointType, Limit};
pub(super) use self::tree::Built;

use self::text::UrdfText;
use super::remark::Remark;
use super::tree::Limits;
use crate::error::Result;

/// [m/s²] Gravity if the model file gives none.
pub const STANDARD_GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// A URDF with line numbers. Its numbers are checked, and its links and joints form a tree.
pub(super) struct Urdf<'a> {
    file: &'a Path,
    text: UrdfText<'a>,
    description: Description,
    root: usize,
    remarks: Vec<Remark>,
}

impl<'a> Urdf<'a> {
    /// Reads the text of a URDF.
    ///
    /// # Errors
    /// It is not a URDF, a value is not a number, or links and joints do not form a tree.
    pub(super) fn parse(file: &'a Path, text: &'a str) -> Result<Self> {
        let text = UrdfText::scan(file, text)?;
        let mut remarks = text.remarks().to_vec();
        let description = checks::with_world(&text, Description::of(&text), &mut remarks);
        let root = checks::root_of(&text, &description, &mut remarks)?;
        let urdf = Self { file, text, description, root, remarks };
        urdf.check_shapes()?;
        Ok(urdf)
    }

    /// Names of the joints that turn or slide on their own, in the order of the file.
    pub(super) fn movable_joints(&self) -> Vec<&str> {
        let movable =
            self.description.joints.iter().filter(|joint| joint.kind.kind().is_some() && joint.mimic.is_none());
        movable.map(|joint| joint.name.as_str()).collect()
    }

    /// Whether a joint follows another one.
    pub(super) fn mimics(&self, name: &str) -> bool {
        self.description.joints.iter().any(|joint| joint.name == name && joint.mimic.is_some())
    }
}

/// [rad or m, rad/s or m/s, N·m or N] Limits from here on count as none: exporters write 1e16 or the largest number for
/// a continuous joint.
const UNLIMITED: f64 = 1e9;

/// Limits. URDF's default of zero counts as not given, and so does the range of a continuous joint.
fn limits_of(joint: &Joint) -> Limits {
    let unlimited =
        Limits { lower: f64::NEG_INFINITY, upper: f64::INFINITY, effort: f64::INFINITY, velocity: f64::INFINITY };
    let Some(Limit { lower, upper, effort, velocity }) = joint.limit else { return unlimited };
    let given = |value: Option<f64>| value.filter(|value| *value > 0.0 && *value < UNLIMITED).unwrap_or(f64::INFINITY);
    let free = joint.kind == JointType::Continuous || (lower == 0.0 && upper == 0.0);
    let lower = if free || lower <= -UNLIMITED { f64::NEG_INFINITY } else { lower };
    let upper = if free || upper >= UNLIMITED { f64::INFINITY } else { upper };
    Limits { lower, upper, effort: given(effort), velocity: given(velocity) }
}

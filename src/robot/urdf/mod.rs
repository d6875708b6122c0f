//! From URDF to the tree.
//!
//! The scanner knows lines, finds what is wrong, and mends the text; urdf-rs reads the mended text.
//! Fixed joints, and movable ones that are held, are merged: their link becomes part of the parent's body. A value that is taken otherwise
//! than it stands in the file is remarked, with its line.

mod checks;
mod description;
mod grammar;
mod inertials;
mod masses;
mod mend;
mod mesh;
mod scan;
mod text;
mod tree;

use std::path::Path;

use nalgebra::Vector3;

use self::description::kind_of;
pub(super) use self::tree::Built;

use self::text::UrdfText;
use super::remark::Remark;
use crate::error::Result;

/// [m/s²] Gravity if the model file gives none.
pub const STANDARD_GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// A URDF with line numbers. Its numbers are checked, and its links and joints form a tree.
pub(super) struct Urdf<'a> {
    file: &'a Path,
    text: UrdfText<'a>,
    robot: description::Robot,
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
        let robot = checks::with_world(&text, description::read(&text)?, &mut remarks);
        let root = checks::root_of(&text, &robot, &mut remarks)?;
        let urdf = Self { file, text, robot, root, remarks };
        urdf.check_shapes()?;
        Ok(urdf)
    }

    /// Names of the joints that turn or slide on their own, in the order of the file.
    pub(super) fn movable_joints(&self) -> Vec<&str> {
        let movable = self.robot.joints.iter().filter(|joint| kind_of(joint).is_some() && joint.mimic.is_none());
        movable.map(|joint| joint.name.as_str()).collect()
    }

    /// Whether a joint follows another one.
    pub(super) fn mimics(&self, name: &str) -> bool {
        self.robot.joints.iter().any(|joint| joint.name == name && joint.mimic.is_some())
    }
}

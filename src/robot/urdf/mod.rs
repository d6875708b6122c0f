//! Reads a URDF and builds the tree.
//!
//! The scanner knows lines. With it the text is checked and rewritten; urdf-rs reads the rewritten text.
//! Fixed joints, and movable ones that are held, are merged: their link becomes part of the parent's body. A value that is not
//! taken as written is remarked, with its line.

mod checks;
mod description;
mod grammar;
mod inertials;
mod masses;
mod mend;
mod mesh;
mod mesh_paths;
mod scan;
mod text;
mod transmissions;
mod tree;
mod visuals;

use std::path::Path;

use self::description::kind_of;
pub(super) use self::grammar::FRICTION as LARGEST_DAMPING;
pub(super) use self::inertials::written as written_inertial;
pub(super) use self::scan::{Element, elements};
pub(super) use self::tree::Built;

use self::text::UrdfText;
use super::remark::Remark;
use super::robot_file::RobotFile;
use crate::error::Result;

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
        Self::of_text(UrdfText::scan(file, text, None)?)
    }

    /// Reads the URDF of a robot file; errors and remarks give lines of that file.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub(super) fn of(file: &'a Path, robot_file: &'a RobotFile) -> Result<Self> {
        let mut urdf = Self::of_text(UrdfText::scan(file, &robot_file.text, robot_file.lines.as_deref())?)?;
        urdf.remarks.splice(0..0, robot_file.remarks.iter().cloned());
        Ok(urdf)
    }

    fn of_text(text: UrdfText<'a>) -> Result<Self> {
        let file = text.file();
        let mut remarks = grammar::check(&text)?;
        let robot = checks::with_world(&text, description::read(&text)?, &mut remarks);
        let root = checks::root_of(&text, &robot, &mut remarks)?;
        let urdf = Self { file, text, robot, root, remarks };
        urdf.check_shapes()?;
        Ok(urdf)
    }

    /// Names of the joints that turn or slide and do not mimic another joint, in the order of the file.
    pub(super) fn movable_joints(&self) -> Vec<&str> {
        let movable = self.robot.joints.iter().filter(|joint| kind_of(joint).is_some() && joint.mimic.is_none());
        movable.map(|joint| joint.name.as_str()).collect()
    }

    /// Whether a joint follows another one.
    pub(super) fn mimics(&self, name: &str) -> bool {
        self.robot.joints.iter().any(|joint| joint.name == name && joint.mimic.is_some())
    }
}

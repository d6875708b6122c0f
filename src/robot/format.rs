//! The format of a robot file, URDF or MJCF, recognised by its text.

use std::path::Path;

use super::mjcf;
use super::robot_file::RobotFile;
use crate::error::Result;

/// Reads the text of a robot file. A URDF is taken unchanged; MJCF is converted to one.
///
/// # Errors
/// The text is MJCF and cannot be read.
pub(super) fn robot_file(file: &Path, text: &str) -> Result<RobotFile> {
    if mjcf::is_mjcf(text) { mjcf::read(file, text) } else { Ok(RobotFile::of_urdf(text)) }
}

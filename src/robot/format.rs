//! The format of a robot file, URDF or MJCF, recognised by its text.

use std::path::Path;

use super::mjcf;
use super::robot_file::RobotFile;
use crate::error::Result;

/// The robot file of a text. A URDF is taken as it is.
///
/// # Errors
/// It is MJCF that cannot be read.
pub(super) fn robot_file(file: &Path, text: &str) -> Result<RobotFile> {
    if mjcf::is_mjcf(text) { mjcf::read(file, text) } else { Ok(RobotFile::of_urdf(text)) }
}

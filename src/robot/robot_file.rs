//! A robot file as the reader takes it: the text of a URDF, with what a URDF has no element for.

use std::path::Path;

use nalgebra::Vector3;

use super::drives::Drives;
use super::mjcf;
use super::remark::Remark;
use super::urdf::STANDARD_GRAVITY;
use crate::error::Result;

/// A robot file whose tree stands in the words of a URDF.
pub(super) struct RobotFile {
    /// The URDF.
    pub text: String,
    /// Line of the file for every line of the text; `None` where the text is the file's own.
    pub lines: Option<Vec<usize>>,
    /// What the text does not contain of the file, or contains otherwise.
    pub remarks: Vec<Remark>,
    /// What the file says of drives outside its URDF.
    pub drives: Drives,
    /// [m/s²]
    pub gravity: Vector3<f64>,
}

impl RobotFile {
    /// Of the text of a file. A URDF is taken as it is.
    ///
    /// # Errors
    /// It is MJCF that cannot be read.
    pub fn of(file: &Path, text: &str) -> Result<Self> {
        if mjcf::is_mjcf(text) {
            return mjcf::read(file, text);
        }
        let (remarks, drives) = (Vec::new(), Drives::new());
        Ok(Self { text: text.to_owned(), lines: None, remarks, drives, gravity: STANDARD_GRAVITY })
    }
}

//! A robot file as the reader takes it: the text of a URDF, with what a URDF has no element for.

use nalgebra::Vector3;

use super::drives::Drives;
use super::remark::Remark;
use super::tree::STANDARD_GRAVITY;

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
    /// Of the text of a URDF, which is taken as it is.
    pub fn of_urdf(text: &str) -> Self {
        let (remarks, drives) = (Vec::new(), Drives::new());
        Self { text: text.to_owned(), lines: None, remarks, drives, gravity: STANDARD_GRAVITY }
    }
}

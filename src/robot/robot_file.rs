//! A robot file as the reader uses it: the text of a URDF, and data for which URDF has no element.

use nalgebra::Vector3;

use super::drives::Drives;
use super::remark::Remark;
use super::tree::STANDARD_GRAVITY;

/// A robot file whose tree is described by a URDF.
pub(super) struct RobotFile {
    /// The URDF.
    pub text: String,
    /// Line in the file for every line of the text; `None` if the text is that of the file.
    pub lines: Option<Vec<usize>>,
    /// Content of the file that the text does not contain or contains in a changed form.
    pub remarks: Vec<Remark>,
    /// Drive data of the file that are not in the URDF text.
    pub drives: Drives,
    /// [m/s²]
    pub gravity: Vector3<f64>,
}

impl RobotFile {
    /// The robot file of a URDF, whose text is taken unchanged.
    pub fn of_urdf(text: &str) -> Self {
        let (remarks, drives) = (Vec::new(), Drives::new());
        Self { text: text.to_owned(), lines: None, remarks, drives, gravity: STANDARD_GRAVITY }
    }
}

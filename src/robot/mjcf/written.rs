//! Builds the text of a URDF, one element per line, and stores for each line the MJCF line that it comes from.

use nalgebra::{Isometry3, Rotation3};

use crate::files::is_control;

/// [1] Below this cosine of the pitch, roll and yaw turn about the same line, and yaw is set to zero: an error of less than 1e-8 rad.
const POLE: f64 = 1e-8;

/// The text of a URDF, and for each line the line of the MJCF.
pub(super) struct Written {
    text: String,
    lines: Vec<usize>,
}

impl Written {
    /// Starts the URDF of a robot of this name.
    pub fn new(robot: &str, line: usize) -> Self {
        let mut written = Self { text: String::new(), lines: Vec::new() };
        written.line(line, &format!("<robot name=\"{}\">", escaped(robot)));
        written
    }

    /// Adds a line.
    pub fn line(&mut self, line: usize, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
        self.lines.push(line);
    }

    /// The whole text, and the line of the MJCF for each of its lines.
    pub fn finish(mut self) -> (String, Vec<usize>) {
        self.line(1, "</robot>");
        (self.text, self.lines)
    }
}

/// A name with the characters escaped that XML does not allow in an attribute, or that would end its line. The URDF reader judges it.
pub(super) fn escaped(name: &str) -> String {
    let mut escaped = String::with_capacity(name.len());
    for c in name.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '"' => escaped.push_str("&quot;"),
            c if is_control(c) => escaped.push_str(&format!("&#{};", u32::from(c))),
            c => escaped.push(c),
        }
    }
    escaped
}

/// The element `<origin>` of a pose.
pub(super) fn origin(pose: &Isometry3<f64>) -> String {
    let p = pose.translation.vector;
    let [roll, pitch, yaw] = angles(&pose.rotation.to_rotation_matrix());
    format!("<origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/>", p.x, p.y, p.z)
}

/// Rotations about the fixed axes x, y, z in this order [rad]. The pitch is computed by an arctangent: an arcsine loses half of the digits
/// near 90°, a common angle.
fn angles(rotation: &Rotation3<f64>) -> [f64; 3] {
    let r = rotation.matrix();
    let cosine = r[(0, 0)].hypot(r[(1, 0)]);
    let pitch = (-r[(2, 0)]).atan2(cosine);
    if cosine < POLE {
        return [(-r[(1, 2)]).atan2(r[(1, 1)]), pitch, 0.0];
    }
    [r[(2, 1)].atan2(r[(2, 2)]), pitch, r[(1, 0)].atan2(r[(0, 0)])]
}

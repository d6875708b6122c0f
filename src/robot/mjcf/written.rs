//! A URDF as it is written, one element a line, with the line of the MJCF that each comes from.

use nalgebra::{Isometry3, Rotation3};

/// [1] Cosine of the pitch below which roll and yaw turn about the same line: a yaw of zero then is wrong by less than 1e-8 rad.
const POLE: f64 = 1e-8;

/// The text of a URDF, and the lines.
pub(super) struct Written {
    text: String,
    lines: Vec<usize>,
}

impl Written {
    /// Of a robot of this name.
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

/// A name as an attribute's value.
pub(super) fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// `<origin>` of a pose.
pub(super) fn origin(pose: &Isometry3<f64>) -> String {
    let p = pose.translation.vector;
    let [roll, pitch, yaw] = angles(&pose.rotation.to_rotation_matrix());
    format!("<origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/>", p.x, p.y, p.z)
}

/// Rotations about the fixed axes x, y, z in this order [rad]. The pitch comes from an arctangent: an arcsine loses half of the digits at 90°, where
/// many joints stand.
fn angles(rotation: &Rotation3<f64>) -> [f64; 3] {
    let r = rotation.matrix();
    let cosine = r[(0, 0)].hypot(r[(1, 0)]);
    let pitch = (-r[(2, 0)]).atan2(cosine);
    if cosine < POLE {
        return [(-r[(1, 2)]).atan2(r[(1, 1)]), pitch, 0.0];
    }
    [r[(2, 1)].atan2(r[(2, 2)]), pitch, r[(1, 0)].atan2(r[(0, 0)])]
}

//! The elements `<compiler>` and `<option>`, and poses as the compiler reads them.

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use super::classes::{Classes, Item};
use super::document::Node;
use crate::error::Result;
use crate::robot::remark::Remark;
use crate::robot::tree::STANDARD_GRAVITY;
use crate::units::DEG;

/// [1] Axes and quaternions shorter than this count as zero.
const LEAST_LENGTH: f64 = 1e-9;

/// Where the inertia of bodies comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FromGeoms {
    Never,
    /// From geoms where a body has no `<inertial>`.
    Auto,
    Always,
}

/// The settings that define how values of the file are read.
#[derive(Debug, Clone)]
pub(super) struct Compiler {
    /// [rad] Size of the unit of angles.
    pub angle: f64,
    /// Folder of meshes, relative to the folder of the main file; empty or with a slash at its end.
    pub mesh_folder: String,
    /// Whether a range acts as a limit without `limited="true"`.
    pub autolimits: bool,
    pub inertia: FromGeoms,
    /// Whether masses of meshes are computed exactly where a mesh does not say.
    pub exact_meshes: bool,
    /// [m/s²]
    pub gravity: Vector3<f64>,
    /// Axes of Euler angles; capital letters mean fixed axes.
    euler: [char; 3],
}

impl Compiler {
    /// Reads all elements `<compiler>` and `<option>` of the root; of an attribute that occurs twice, the last counts.
    ///
    /// # Errors
    /// A value has no meaning.
    pub fn read(root: &Node, classes: &Classes, remarks: &mut Vec<Remark>) -> Result<Self> {
        let mut compiler = Self {
            angle: DEG,
            mesh_folder: String::new(),
            autolimits: true,
            inertia: FromGeoms::Auto,
            exact_meshes: false,
            gravity: STANDARD_GRAVITY,
            euler: ['x', 'y', 'z'],
        };
        for node in root.all("compiler") {
            compiler.take(&classes.with(node, None)?, remarks)?;
        }
        for node in root.all("option") {
            let item = classes.with(node, None)?;
            if let Some(gravity) = item.array::<3>("gravity")? {
                compiler.gravity = gravity.into();
            }
            if node.all("flag").any(|flag| flag.attribute("gravity") == Some("disable")) {
                compiler.gravity = Vector3::zeros();
            }
            for medium in ["wind", "density", "viscosity"] {
                if item.numbers(medium, 1, 3)?.is_some_and(|values| values.iter().any(|value| *value != 0.0)) {
                    remarks.push(node.remark(&format!("{medium} is not taken: the robot moves in a vacuum")));
                }
            }
        }
        Ok(compiler)
    }

    fn take(&mut self, item: &Item<'_>, remarks: &mut Vec<Remark>) -> Result<()> {
        let node = item.node;
        let word = |name: &str, words: &[&'static str]| {
            node.attribute(name).map(|value| node.word(name, value, words)).transpose()
        };
        if let Some(unit) = word("angle", &["degree", "radian"])? {
            self.angle = if unit == "degree" { DEG } else { 1.0 };
        }
        if let Some(folder) = item.text("meshdir").or(item.text("assetdir")) {
            self.mesh_folder = if folder.ends_with('/') { folder.to_owned() } else { format!("{folder}/") };
        }
        if let Some(auto) = item.switch("autolimits")? {
            self.autolimits = auto;
        }
        self.exact_meshes = item.switch("exactmeshinertia")?.unwrap_or(self.exact_meshes);
        self.inertia = match word("inertiafromgeom", &["false", "true", "auto"])? {
            Some("false") => FromGeoms::Never,
            Some("true") => FromGeoms::Always,
            Some(_) => FromGeoms::Auto,
            None => self.inertia,
        };
        if let Some(sequence) = item.text("eulerseq") {
            let letters: Vec<char> = sequence.chars().filter(|c| "xyzXYZ".contains(*c)).collect();
            self.euler = <[char; 3]>::try_from(letters)
                .ok()
                .filter(|_| sequence.len() == 3)
                .ok_or_else(|| node.error("eulerseq", sequence, "three of the letters x, y, z, X, Y, Z"))?;
        }
        if item.text("coordinate").is_some_and(|value| value != "local") {
            return Err(node.error(
                "coordinate",
                "global",
                "local coordinates; MuJoCo has no others since version 2.3.3",
            ));
        }
        for name in ["settotalmass", "boundmass", "boundinertia", "inertiagrouprange"] {
            if let Some(value) = item
                .text(name)
                .filter(|value| value.parse().is_ok_and(|number: f64| number > 0.0) || value.contains(' '))
            {
                remarks
                    .push(node.remark(&format!("{name} = \"{value}\" is not taken: inertias are used as they stand")));
            }
        }
        Ok(())
    }

    /// Pose of an element: `pos`, and one of `quat`, `axisangle`, `euler`, `xyaxes`, `zaxis`.
    ///
    /// # Errors
    /// A value is not of the expected form.
    pub fn pose(&self, item: &Item<'_>) -> Result<Isometry3<f64>> {
        let position = item.array::<3>("pos")?.unwrap_or_default();
        Ok(Isometry3::from_parts(Translation3::from(Vector3::from(position)), self.rotation(item)?))
    }

    /// Rotation of an element.
    ///
    /// # Errors
    /// As [`pose`](Self::pose).
    pub fn rotation(&self, item: &Item<'_>) -> Result<UnitQuaternion<f64>> {
        let none = |name: &str, expected: &str| item.node.error(name, item.text(name).unwrap_or_default(), expected);
        if let Some([w, x, y, z]) = item.array::<4>("quat")? {
            let expected = "a quaternion w x y z that is not zero";
            return UnitQuaternion::try_new(Quaternion::new(w, x, y, z), LEAST_LENGTH)
                .ok_or_else(|| none("quat", expected));
        }
        if let Some([x, y, z, angle]) = item.array::<4>("axisangle")? {
            let axis = unit(Vector3::new(x, y, z)).ok_or_else(|| none("axisangle", "an axis that is not zero"))?;
            return Ok(UnitQuaternion::from_axis_angle(&axis, angle * self.angle));
        }
        if let Some(angles) = item.array::<3>("euler")? {
            return Ok(self.euler(angles));
        }
        if let Some([a, b, c, d, e, f]) = item.array::<6>("xyaxes")? {
            let (x, y) = (Vector3::new(a, b, c), Vector3::new(d, e, f));
            let x = unit(x).ok_or_else(|| none("xyaxes", "axes that are not zero"))?;
            let y = unit(y - *x * x.dot(&y)).ok_or_else(|| none("xyaxes", "axes that are not parallel"))?;
            let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[*x, *y, x.cross(&y)]));
            return Ok(UnitQuaternion::from_rotation_matrix(&rotation));
        }
        if let Some(axis) = item.array::<3>("zaxis")? {
            let axis = unit(Vector3::from(axis)).ok_or_else(|| none("zaxis", "an axis that is not zero"))?;
            return Ok(turned_onto(&axis));
        }
        Ok(UnitQuaternion::identity())
    }

    /// Small letters mean rotations about the rotating axes, capital letters rotations about the fixed axes.
    fn euler(&self, angles: [f64; 3]) -> UnitQuaternion<f64> {
        let mut rotation = UnitQuaternion::identity();
        for (letter, angle) in self.euler.into_iter().zip(angles) {
            let axis = match letter.to_ascii_lowercase() {
                'x' => Vector3::x_axis(),
                'y' => Vector3::y_axis(),
                _ => Vector3::z_axis(),
            };
            let turn = UnitQuaternion::from_axis_angle(&axis, angle * self.angle);
            rotation = if letter.is_ascii_lowercase() { rotation * turn } else { turn * rotation };
        }
        rotation
    }
}

/// The direction of a vector; `None` for a vector that is zero.
pub(super) fn unit(vector: Vector3<f64>) -> Option<Unit<Vector3<f64>>> {
    Unit::try_new(vector, LEAST_LENGTH)
}

/// The smallest rotation that turns z onto an axis.
pub(super) fn turned_onto(axis: &Unit<Vector3<f64>>) -> UnitQuaternion<f64> {
    let flipped = || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    UnitQuaternion::rotation_between(&Vector3::z(), axis).unwrap_or_else(flipped)
}

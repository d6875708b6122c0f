//! Links and joints as a URDF describes them. The text is checked before: what is missing here is optional, and has its default.

use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::grammar::parsed;
use super::scan::Element;
use super::text::UrdfText;
use crate::robot::tree::{Geometry, Inertia};
use crate::units::JointKind;

/// The content of a URDF that is used.
pub(super) struct Description {
    pub name: String,
    /// In the order of the file.
    pub links: Vec<Link>,
    /// In the order of the file.
    pub joints: Vec<Joint>,
}

pub(super) struct Link {
    pub name: String,
    pub inertial: Option<Inertial>,
    pub collisions: Vec<Collision>,
}

pub(super) struct Inertial {
    /// As it stands in the file, in the frame of the link.
    pub inertia: Inertia,
    /// Whether there is an element `<inertia>`; without one the tensor is zero.
    pub has_tensor: bool,
}

pub(super) struct Collision {
    /// Pose in the frame of the link.
    pub pose: Isometry3<f64>,
    pub solid: Solid,
}

/// Geometry of a collision shape.
pub(super) enum Solid {
    Known(Geometry),
    /// A mesh with its scale.
    Mesh(String, Vector3<f64>),
    /// A mesh whose scale is not three numbers.
    Scaled(String),
    /// The name of another element, empty if there is none.
    Other(String),
}

pub(super) struct Joint {
    pub name: String,
    pub kind: JointType,
    pub parent: String,
    pub child: String,
    /// Pose of the joint in the frame of the parent link.
    pub origin: Isometry3<f64>,
    /// Its axis, of any length.
    pub axis: Vector3<f64>,
    pub limit: Option<Limit>,
    /// [N·m·s/rad or N·s/m]
    pub damping: f64,
    /// [N·m or N]
    pub friction: f64,
    pub mimic: Option<Mimic>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum JointType {
    Revolute,
    Continuous,
    Prismatic,
    Fixed,
    Floating,
    Planar,
    Spherical,
}

/// `<limit>`; the version of URDF decides what a missing `lower` or `upper` is.
pub(super) struct Limit {
    /// [rad or m]
    pub lower: f64,
    /// [rad or m]
    pub upper: f64,
    /// [N·m or N]
    pub effort: Option<f64>,
    /// [rad/s or m/s]
    pub velocity: Option<f64>,
}

/// `<mimic>`: the joint follows another one, `q = multiplier · q_other + offset`.
pub(super) struct Mimic {
    pub joint: String,
    /// [rad or m]
    pub offset: f64,
}

/// Types by their names in URDF.
pub(super) const JOINT_TYPES: [(&str, JointType); 7] = [
    ("revolute", JointType::Revolute),
    ("continuous", JointType::Continuous),
    ("prismatic", JointType::Prismatic),
    ("fixed", JointType::Fixed),
    ("floating", JointType::Floating),
    ("planar", JointType::Planar),
    // Of Bullet's dialect.
    ("spherical", JointType::Spherical),
];

impl JointType {
    pub fn kind(self) -> Option<JointKind> {
        match self {
            Self::Revolute | Self::Continuous => Some(JointKind::Revolute),
            Self::Prismatic => Some(JointKind::Prismatic),
            Self::Fixed | Self::Floating | Self::Planar | Self::Spherical => None,
        }
    }
}

impl Description {
    /// The content of a checked text.
    pub fn of(text: &UrdfText<'_>) -> Self {
        let version = text.version();
        let all = |name: &'static str| {
            text.elements().iter().filter(move |element| element.parent == Some(0) && element.name == name)
        };
        Self {
            name: text.elements().first().map_or_else(String::new, |robot| word(robot, "name")),
            links: all("link").map(|link| Link::of(text, link, version)).collect(),
            joints: all("joint").map(|joint| Joint::of(text, joint, version)).collect(),
        }
    }
}

impl Link {
    fn of(text: &UrdfText<'_>, link: &Element<'_>, version: Version) -> Self {
        let collisions = text.children(link, "collision").map(|collision| Collision {
            pose: pose(text, collision, version),
            solid: Solid::of(text.children(collision, "geometry").flat_map(|geometry| text.inside(geometry)).next()),
        });
        Self {
            name: word(link, "name"),
            inertial: text.child(link, "inertial").map(|inertial| Inertial::of(text, inertial, version)),
            collisions: collisions.collect(),
        }
    }
}

impl Inertial {
    /// In the frame of the link, rotated from the inertial frame.
    fn of(text: &UrdfText<'_>, inertial: &Element<'_>, version: Version) -> Self {
        let tensor = text.child(inertial, "inertia");
        let [ixx, ixy, ixz, iyy, iyz, izz] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]
            .map(|name| tensor.map_or(0.0, |tensor| number(tensor, name, 0.0)));
        let own = Inertia {
            mass: text.child(inertial, "mass").map_or(0.0, |mass| number(mass, "value", 0.0)),
            com: Vector3::zeros(),
            tensor: Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz),
        };
        Self { inertia: own.seen_from(&pose(text, inertial, version)), has_tensor: tensor.is_some() }
    }
}

impl Solid {
    fn of(shape: Option<&Element<'_>>) -> Self {
        let Some(shape) = shape else { return Self::Other(String::new()) };
        let size = |name| number(shape, name, 0.0);
        match shape.name {
            "box" => Self::Known(Geometry::Box(vector(shape, "size", [0.0; 3]))),
            "cylinder" => Self::Known(Geometry::Cylinder(size("radius"), size("length"))),
            "capsule" => Self::Known(Geometry::Capsule(size("radius"), size("length"))),
            "sphere" => Self::Known(Geometry::Sphere(size("radius"))),
            "mesh" => match shape.attribute("scale").map(|scale| parsed(scale, 3, false)) {
                Some(None) => Self::Scaled(word(shape, "filename")),
                _ => Self::Mesh(word(shape, "filename"), vector(shape, "scale", [1.0; 3])),
            },
            other => Self::Other(other.to_owned()),
        }
    }
}

impl Joint {
    fn of(text: &UrdfText<'_>, joint: &Element<'_>, version: Version) -> Self {
        let child = |name| text.child(joint, name);
        let link = |name| child(name).map_or_else(String::new, |element| word(element, "link"));
        let dynamics = |name| child("dynamics").map_or(0.0, |dynamics| number(dynamics, name, 0.0));
        let kind = JOINT_TYPES.iter().find(|(name, _)| joint.attribute("type") == Some(name));
        Self {
            name: word(joint, "name"),
            kind: kind.map_or(JointType::Fixed, |(_, kind)| *kind),
            parent: link("parent"),
            child: link("child"),
            origin: pose(text, joint, version),
            axis: child("axis").map_or(Vector3::x(), |axis| vector(axis, "xyz", [1.0, 0.0, 0.0])),
            limit: child("limit").map(|limit| Limit::of(limit, version)),
            damping: dynamics("damping"),
            friction: dynamics("friction"),
            mimic: child("mimic")
                .map(|mimic| Mimic { joint: word(mimic, "joint"), offset: number(mimic, "offset", 0.0) }),
        }
    }
}

impl Limit {
    fn of(limit: &Element<'_>, version: Version) -> Self {
        let open = if version >= OPEN_LIMITS { f64::INFINITY } else { 0.0 };
        Self {
            lower: number(limit, "lower", -open),
            upper: number(limit, "upper", open),
            effort: optional(limit, "effort"),
            velocity: optional(limit, "velocity"),
        }
    }
}

/// Version of URDF: `version="1.1"` of `<robot>`.
pub(super) type Version = (u32, u32);

/// From this version on an `<origin>` may have `quat_xyzw`.
const QUATERNIONS: Version = (1, 1);

/// From this version on a missing limit is no limit.
const OPEN_LIMITS: Version = (1, 2);

/// URDF's `<origin>`: rotation about the fixed axes x, y, z in this order, or a quaternion, then translation.
fn pose(text: &UrdfText<'_>, owner: &Element<'_>, version: Version) -> Isometry3<f64> {
    let Some(origin) = text.child(owner, "origin") else { return Isometry3::identity() };
    let [roll, pitch, yaw] = numbers(origin, "rpy", [0.0; 3]);
    let [x, y, z, w] = numbers(origin, "quat_xyzw", [0.0; 4]);
    let rotation = match UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9) {
        Some(rotation) if version >= QUATERNIONS => rotation,
        _ => UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    };
    Isometry3::from_parts(Translation3::from(vector(origin, "xyz", [0.0; 3])), rotation)
}

fn word(element: &Element<'_>, attribute: &str) -> String {
    element.attribute(attribute).unwrap_or_default().to_owned()
}

fn numbers<const N: usize>(element: &Element<'_>, attribute: &str, default: [f64; N]) -> [f64; N] {
    let given = element.attribute(attribute).and_then(|value| parsed(value, N, true));
    given.and_then(|values| values.try_into().ok()).unwrap_or(default)
}

fn vector(element: &Element<'_>, attribute: &str, default: [f64; 3]) -> Vector3<f64> {
    Vector3::from(numbers(element, attribute, default))
}

fn optional(element: &Element<'_>, attribute: &str) -> Option<f64> {
    element.attribute(attribute).and_then(|value| parsed(value, 1, true)).map(|values| values[0])
}

fn number(element: &Element<'_>, attribute: &str, default: f64) -> f64 {
    let [value] = numbers(element, attribute, [default]);
    value
}

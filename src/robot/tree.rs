//! A tree of rigid bodies with one movable joint each. Fixed joints are merged; joints held at zero count as fixed.

use std::path::PathBuf;

use nalgebra::{Isometry3, Matrix3, Unit, Vector3};

use super::Coupling;
use crate::units::JointKind;

/// [m/s²] Gravity if the model file gives none.
pub const STANDARD_GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// A robot on a fixed base. Joint `i` moves body `i`; parents come before their children.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// Name in the URDF.
    pub name: String,
    /// [m/s²] gravity seen from the base frame.
    pub gravity: Vector3<f64>,
    /// Collision shapes that do not move, given in the base frame.
    pub base_shapes: Vec<Shape>,
    /// Collision shapes whose mesh file could not be read; with these a planned motion cannot be checked.
    pub unread_shapes: Vec<UnreadShape>,
    /// Meshes by which links are drawn.
    pub drawn: Vec<DrawnMesh>,
    /// The movable bodies.
    pub bodies: Vec<Body>,
    /// How motor axes move the joints; `None`: each axis moves the joint of its name.
    pub coupling: Option<Coupling>,
}

/// A rigid body and the joint that moves it. Its frame is the joint's frame after the joint's motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Name of the URDF link that the joint moves.
    pub name: String,
    /// Index of the parent body; `None` for the base.
    pub parent: Option<usize>,
    /// The joint that connects it to the parent.
    pub joint: Joint,
    /// Its inertia, including all links that are fixed to it.
    pub inertia: Inertia,
    /// Its collision shapes.
    pub shapes: Vec<Shape>,
}

/// A revolute or prismatic joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name in the URDF.
    pub name: String,
    /// Turning or sliding.
    pub kind: JointKind,
    /// Pose of the joint frame in the parent's frame at q = 0.
    pub origin: Isometry3<f64>,
    /// Axis in the joint frame.
    pub axis: Unit<Vector3<f64>>,
    /// Limits.
    pub limits: Limits,
    /// [N·m·s/rad or N·s/m] URDF `dynamics damping`, on the link side, ≥ 0; 0 where the model file states the friction of the joint.
    pub damping: f64,
    /// [N·m or N] URDF `dynamics friction`, on the link side, ≥ 0; 0 where the model file states the friction of the joint.
    pub friction: f64,
}

/// Limits of a joint; infinite where not given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// [rad or m]
    pub lower: f64,
    /// [rad or m]
    pub upper: f64,
    /// [N·m or N]
    pub effort: f64,
    /// [rad/s or m/s]
    pub velocity: f64,
}

/// Inertia of a rigid body in its body frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    /// [kg] ≥ 0.
    pub mass: f64,
    /// [m] centre of mass.
    pub com: Vector3<f64>,
    /// [kg·m²] tensor about the centre of mass, in the axes of the body frame.
    pub tensor: Matrix3<f64>,
}

/// A collision shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// URDF link it belongs to.
    pub link: String,
    /// Pose in the frame of its body.
    pub pose: Isometry3<f64>,
    /// Its geometry.
    pub geometry: Geometry,
}

/// A mesh by which a link is drawn: URDF's `<visual>`. It enters no computation.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnMesh {
    /// Index of the body that it moves with; `None` for the base.
    pub body: Option<usize>,
    /// Pose in the frame of its body.
    pub pose: Isometry3<f64>,
    /// The file as the URDF names it, STL, OBJ or DAE; it need not exist.
    pub file: PathBuf,
    /// [1] Factor on each coordinate of the file, which is then in metres.
    pub scale: Vector3<f64>,
}

/// A collision shape that could not be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnreadShape {
    /// URDF link it belongs to.
    pub link: String,
    /// The mesh file.
    pub file: PathBuf,
    /// What was expected of the file.
    pub expected: String,
}

/// Geometry of a collision shape, as in URDF.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// Full side lengths [m].
    Box(Vector3<f64>),
    /// Axis along z. Radius and full length [m].
    Cylinder(f64, f64),
    /// Axis along z. Radius and length between the centres of its caps [m].
    Capsule(f64, f64),
    /// Radius [m].
    Sphere(f64),
    /// Convex hull of these points [m].
    ConvexHull(Vec<Vector3<f64>>),
}

impl Robot {
    /// Index of a joint by its name.
    pub fn joint_index(&self, name: &str) -> Option<usize> {
        self.bodies.iter().position(|body| body.joint.name == name)
    }

    /// Number of degrees of freedom.
    pub fn dof(&self) -> usize {
        self.bodies.len()
    }

    /// Inertia of each body together with all bodies that it carries, in the frame of the body, with all joints at zero.
    pub fn carried(&self) -> Vec<Inertia> {
        let mut carried: Vec<Inertia> = self.bodies.iter().map(|body| body.inertia).collect();
        for (index, body) in self.bodies.iter().enumerate().rev() {
            if let Some(parent) = body.parent {
                carried[parent] = carried[parent].joined(&carried[index].seen_from(&body.joint.origin));
            }
        }
        carried
    }

    /// [kg·m² or kg] Inertia that each joint alone moves, with all joints at zero: the diagonal of the mass matrix there, without a rotor.
    pub fn moved_inertias(&self) -> Vec<f64> {
        let moved = |(body, carried): (&Body, Inertia)| match body.joint.kind {
            JointKind::Revolute => body.joint.axis.dot(&(carried.tensor_about(&Vector3::zeros()) * *body.joint.axis)),
            JointKind::Prismatic => carried.mass,
        };
        self.bodies.iter().zip(self.carried()).map(moved).collect()
    }

    /// Position, velocity or acceleration of a joint, from those of the motor axes.
    pub fn joint_of_axes(&self, joint: usize, of_axis: impl Fn(usize) -> f64) -> f64 {
        self.coupling.as_ref().map_or_else(|| of_axis(joint), |coupling| coupling.joint(joint, &of_axis))
    }

    /// Torque on each axis per torque on a joint; also motion of the joint per motion of each axis.
    pub fn joint_per_axis(&self, joint: usize) -> Vec<f64> {
        let of_axis = |axis: usize| match &self.coupling {
            Some(coupling) => coupling.joint_per_axis(joint, axis),
            None => f64::from(u8::from(axis == joint)),
        };
        (0..self.dof()).map(of_axis).collect()
    }

    /// Axes that are loaded by a torque on this joint; the joint's own axis comes first.
    pub fn axes_of(&self, joint: usize) -> Vec<usize> {
        self.coupling.as_ref().map_or_else(|| vec![joint], |coupling| coupling.axes_of(joint))
    }

    /// [rad or m] Lowest and highest position that an axis can have while all joints are within their limits.
    pub fn axis_range(&self, axis: usize) -> [f64; 2] {
        let limits = |joint: usize| self.bodies[joint].joint.limits;
        let Some(coupling) = &self.coupling else { return [limits(axis).lower, limits(axis).upper] };
        let parts = (0..self.dof()).map(|joint| (coupling.axis_per_joint(axis, joint), limits(joint)));
        parts.filter(|(c, _)| *c != 0.0).fold([0.0, 0.0], |[low, high], (c, Limits { lower, upper, .. })| {
            [low + (c * lower).min(c * upper), high + (c * lower).max(c * upper)]
        })
    }
}

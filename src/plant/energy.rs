//! Energy of the links from positions and velocities, body by body; it shares nothing with the engines.
//!
//! ```text
//!   E = Σ ½ m |v_c|² + ½ ωᵀ I ω − m gᵀ r_c
//! ```

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::robot::Robot;
use crate::units::JointKind;

/// Kinetic and gravitational energy [J] of the links at `(q, v)`; gravity counts from the base frame's origin.
pub fn of_links(robot: &Robot, q: impl Fn(usize) -> f64, v: impl Fn(usize) -> f64) -> f64 {
    /// Pose, velocity of the frame's origin, angular velocity; all in the base frame.
    struct Moving {
        pose: Isometry3<f64>,
        linear: Vector3<f64>,
        angular: Vector3<f64>,
    }
    let mut bodies: Vec<Moving> = Vec::with_capacity(robot.dof());
    let mut energy = 0.0;
    for (i, body) in robot.bodies.iter().enumerate() {
        let (parent, mut linear, mut angular) = match body.parent {
            Some(parent) => {
                let moving = &bodies[parent];
                (moving.pose, moving.linear, moving.angular)
            }
            None => (Isometry3::identity(), Vector3::zeros(), Vector3::zeros()),
        };
        let axis = body.joint.axis;
        let motion = match body.joint.kind {
            JointKind::Revolute => {
                Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(&axis, q(i)))
            }
            JointKind::Prismatic => {
                Isometry3::from_parts(Translation3::from(axis.scale(q(i))), UnitQuaternion::identity())
            }
        };
        let pose = parent * body.joint.origin * motion;
        linear += angular.cross(&(pose.translation.vector - parent.translation.vector));
        let axis = pose.rotation * axis.into_inner();
        match body.joint.kind {
            JointKind::Revolute => angular += axis * v(i),
            JointKind::Prismatic => linear += axis * v(i),
        }
        let centre = pose * Point3::from(body.inertia.com);
        let centre_velocity = linear + angular.cross(&(centre.coords - pose.translation.vector));
        let local = pose.rotation.inverse() * angular;
        energy += 0.5 * body.inertia.mass * centre_velocity.norm_squared();
        energy += 0.5 * local.dot(&(body.inertia.tensor * local));
        energy -= body.inertia.mass * robot.gravity.dot(&centre.coords);
        bodies.push(Moving { pose, linear, angular });
    }
    energy
}

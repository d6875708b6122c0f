//! Obstacles in rapier's world: bodies that stand still, and how far the links are from them.
//!
//! Links and obstacles have colliders there, so that they can be displayed; rapier's own contact solver, first order in its step, is
//! not used. The shape of an obstacle is a core with a skin around it: the distance from the core is smooth and reliable as long as
//! nothing gets through the skin, and the skin rounds the edges.

use nalgebra::Vector3;
use rapier3d_f64::dynamics::RigidBodyBuilder;
use rapier3d_f64::geometry::ColliderBuilder;

use super::world::{Pair, World, pose};
use crate::dynamics::{closest, solid};
use crate::error::Result;
use crate::robot::{Geometry, Robot, Shape};

/// Something that stands in the way and does not move.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    /// Its shape in the base frame; its name is the shape's `link`.
    pub shape: Shape,
    /// [m] Radius of its edges, > 0, less than half its smallest side; for a sphere or a capsule, its radius.
    pub edge_radius: f64,
    /// `k` [N/m] of the surfaces that touch, > 0.
    pub stiffness: f64,
    /// `c` [N·s/m] of the surfaces that touch, ≥ 0.
    pub damping: f64,
}

impl Obstacle {
    /// Its shape without the skin. The thickness of the skin is the edge radius.
    fn core(&self) -> Shape {
        let skin = self.edge_radius;
        let geometry = match &self.shape.geometry {
            Geometry::Box(sides) => Geometry::Box(sides - Vector3::repeat(2.0 * skin)),
            Geometry::Cylinder(radius, length) => Geometry::Cylinder(radius - skin, length - 2.0 * skin),
            Geometry::Capsule(radius, length) => Geometry::Capsule(radius - skin, *length),
            Geometry::Sphere(radius) => Geometry::Sphere(radius - skin),
            Geometry::ConvexHull(corners) => Geometry::ConvexHull(corners.clone()),
        };
        Shape { geometry, ..self.shape.clone() }
    }
}

impl World {
    /// Puts obstacles into the world and gives the links their collision shapes; returns the pairs that may meet.
    ///
    /// # Errors
    /// The points of a collision mesh span no volume.
    pub fn put_obstacles(&mut self, robot: &Robot, obstacles: &[Obstacle]) -> Result<&[Pair]> {
        let mut standing = Vec::new();
        for obstacle in obstacles {
            let body = self.bodies.insert(RigidBodyBuilder::fixed());
            let collider = collider(robot, &obstacle.core())?.contact_skin(obstacle.edge_radius);
            standing.push(self.colliders.insert_with_parent(collider, body, &mut self.bodies));
        }
        for (body, link) in robot.bodies.iter().enumerate() {
            for shape in &link.shapes {
                let collider = collider(robot, shape)?;
                let link_collider = self.colliders.insert_with_parent(collider, self.links[body], &mut self.bodies);
                for (obstacle, &obstacle_collider) in standing.iter().enumerate() {
                    let skin = obstacles[obstacle].edge_radius;
                    let branch =
                        self.multibody().map(|multibody| multibody.kinematic_branch(body + 1)).unwrap_or_default();
                    self.pairs.push(Pair { body, obstacle, link_collider, obstacle_collider, skin, branch });
                }
            }
        }
        Ok(&self.pairs)
    }

    /// [`RigidBody::distance`](super::RigidBody::distance), without moving anything in the world.
    pub(super) fn pair_distance(&mut self, pair: usize, q: &[f64], reach: f64, gradient: &mut [f64]) -> Option<f64> {
        // A non-finite position counts as out of reach.
        if q.iter().any(|q| !q.is_finite()) {
            return None;
        }
        self.displace(q);
        let Self { pairs, bodies, colliders, multibody_joints, joints, columns, displacement, jacobian, .. } = self;
        let Pair { body, link_collider, obstacle_collider, skin, branch, .. } = &pairs[pair];
        let (multibody, _) = joints.first().copied().flatten().and_then(|handle| multibody_joints.get(handle))?;
        let link_pose = multibody.forward_kinematics_single_branch(bodies, branch, Some(displacement), Some(jacobian));
        let (link, obstacle) = (&colliders[*link_collider], &colliders[*obstacle_collider]);
        let shape_pose = link_pose * *link.position_wrt_parent()?;
        let found = closest((obstacle.position(), obstacle.shape()), (&shape_pose, link.shape()), reach + skin)?;
        let com = link_pose * bodies[self.links[*body]].mass_properties().local_mprops.local_com;
        let (normal, arm) = (found.normal1, found.point2 - com);
        // The link's point moves by the Jacobian's linear part, and by its angular part about the centre of mass.
        let moment = arm.cross(normal);
        for (slope, &column) in gradient.iter_mut().zip(columns.iter()) {
            let twist = jacobian.column(column);
            *slope = twist[0] * normal.x + twist[1] * normal.y + twist[2] * normal.z;
            *slope += twist[3] * moment.x + twist[4] * moment.y + twist[5] * moment.z;
        }
        Some(found.dist - skin)
    }
}

/// The collider of a shape. It is disabled, so that it has no mass and rapier's own contact solver ignores it.
fn collider(robot: &Robot, shape: &Shape) -> Result<ColliderBuilder> {
    let (at, solid) = solid(robot, shape)?;
    Ok(ColliderBuilder::new(solid).position(pose(&at)).enabled(false))
}

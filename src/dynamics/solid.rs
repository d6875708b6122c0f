//! Collision shapes as solids of the collision library, and where two of them come closest.

use std::path::Path;

use nalgebra::{Isometry3, Vector3};
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::{Contact, contact};
use parry3d_f64::shape::{Shape as Solid, SharedShape};
use parry3d_f64::transformation::try_convex_hull;

use crate::error::{Error, Place, Result};
use crate::robot::{Geometry, Robot, Shape};

/// A collision shape in the collision library's type, and its pose in the frame of its body.
///
/// # Errors
/// The points of a convex hull span no volume.
pub fn solid(robot: &Robot, shape: &Shape) -> Result<(Isometry3<f64>, SharedShape)> {
    let mut pose = shape.pose;
    let half = |length: f64| 0.5 * length;
    let solid = match &shape.geometry {
        Geometry::Box(size) => SharedShape::cuboid(half(size.x), half(size.y), half(size.z)),
        Geometry::Sphere(radius) => SharedShape::ball(*radius),
        Geometry::Capsule(radius, length) => SharedShape::capsule_z(half(*length), *radius),
        Geometry::Cylinder(radius, length) => {
            // A cylinder's axis is y in the library and z here.
            pose *= nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
            SharedShape::cylinder(half(*length), *radius)
        }
        Geometry::ConvexHull(points) => {
            let points: Vec<Vector> = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
            SharedShape::convex_hull(&points).ok_or_else(|| {
                let key = format!("collision mesh of link {}", shape.link);
                Error::input(Path::new(&robot.name), Place::File, key, "", "points that span a volume")
            })?
        }
    };
    Ok((pose, solid))
}

/// The triangles of the convex hull of some points, each with its corners in counter-clockwise order seen from outside; `None` where they span no
/// volume.
pub fn convex_hull(points: &[Vector3<f64>]) -> Option<Vec<[Vector3<f64>; 3]>> {
    let points: Vec<Vector> = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    let (corners, triangles) = try_convex_hull(&points).ok()?;
    let corner = |index: u32| corners.get(index as usize).map_or_else(Vector3::zeros, |p| Vector3::new(p.x, p.y, p.z));
    Some(triangles.into_iter().map(|triangle| triangle.map(corner)).collect())
}

/// Where two solids come closest, in the frame of their poses: a point of each, the normal of the first, and their distance,
/// negative where they overlap; `None` where they are farther apart than `reach` [m], or the library has no answer.
pub fn closest(first: (&Pose, &dyn Solid), second: (&Pose, &dyn Solid), reach: f64) -> Option<Contact> {
    contact(first.0, first.1, second.0, second.1, reach).ok()?
}

/// A pose in the collision library's type.
pub(super) fn pose_of(pose: &Isometry3<f64>) -> Pose {
    let (p, r) = (&pose.translation.vector, &pose.rotation);
    Pose::from_parts(Vector::new(p.x, p.y, p.z), Rotation::from_xyzw(r.i, r.j, r.k, r.w))
}

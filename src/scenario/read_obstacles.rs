//! The list `[[obstacles]]` of a scenario file.
//!
//! ```toml
//! [[obstacles]]
//! name = "post"
//! shape = "cylinder"          # its axis along z: radius, length; "capsule" (length between the centres of its caps): the same;
//!                             # "sphere": radius; "box": size = [x, y, z]
//! radius = 0.02               # [m]
//! length = 0.3                # [m]
//! xyz = [0.3, 0.1, 0.15]      # [m] its middle in the base frame
//! rpy = [0.0, 0.0, 0.0]       # [rad] as in a URDF
//! stiffness = 1e5             # [N/m] of the surfaces that touch
//! damping = 100.0             # [N·s/m]
//! edge_radius = 0.005         # [m] of a box or a cylinder
//! ```
//! A planned motion through an obstacle is intended and not refused. A start with a link inside an obstacle is refused.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::ranges;
use crate::error::Result;
use crate::plant::{Engine, Obstacle};
use crate::robot::{Geometry, Robot, Shape};
use crate::toml_input::{Range, Table};

/// `k` [N/m] if the file gives none: an arm that hits a padded or slender object. A steel surface has 1e7 to 1e8, which
/// makes an impact, and the integration steps, shorter than a millisecond.
const STIFFNESS: f64 = 1e5;

/// `c` [N·s/m] if the file gives none: with the default stiffness, 1 kg rebounds with 0.64 of its speed, 10 kg with
/// 0.86.
const DAMPING: f64 = 100.0;

/// [m] Radius of the edges if the file gives none; at most a quarter of the smallest side.
const EDGE_RADIUS: f64 = 0.005;

/// Largest number of obstacles: every link is checked against every one.
const MOST_OBSTACLES: usize = 200;

/// Reads the obstacles of a scenario.
pub(super) fn read(root: &Table<'_>, robot: &Robot, engine: Engine) -> Result<Vec<Obstacle>> {
    let tables = root.tables("obstacles")?;
    if tables.is_empty() {
        return Ok(Vec::new());
    }
    if tables.len() > MOST_OBSTACLES {
        return Err(root.error("obstacles", format!("at most {MOST_OBSTACLES} obstacles, not {}", tables.len())));
    }
    if engine != Engine::Rapier {
        return Err(root.error("obstacles", "plant.engine = \"rapier\": no other engine supports obstacles"));
    }
    if robot.bodies.iter().all(|body| body.shapes.is_empty()) {
        return Err(
            root.error("obstacles", "an arm whose URDF gives its links collision shapes: this one can touch nothing")
        );
    }
    let mut obstacles: Vec<Obstacle> = Vec::new();
    for table in &tables {
        let obstacle = read_obstacle(table)?;
        if obstacles.iter().any(|other| other.shape.link == obstacle.shape.link) {
            return Err(table.error("name", "a name that no other obstacle has"));
        }
        obstacles.push(obstacle);
    }
    Ok(obstacles)
}

#[derive(Clone, Copy)]
enum Kind {
    Box,
    Cylinder,
    Capsule,
    Sphere,
}

fn read_obstacle(table: &Table<'_>) -> Result<Obstacle> {
    let kinds =
        [("box", Kind::Box), ("cylinder", Kind::Cylinder), ("capsule", Kind::Capsule), ("sphere", Kind::Sphere)];
    let kind = table
        .optional_choice("shape", &kinds)?
        .ok_or_else(|| table.error("shape", "box, cylinder, capsule or sphere"))?;
    let length = ranges::SIDE;
    // The geometry, and its smallest side if it has edges.
    let (geometry, side) = match kind {
        Kind::Box => {
            let size: Option<[f64; 3]> = table.optional_vector("size", &length)?;
            let size =
                size.ok_or_else(|| table.error("size", format!("a list of 3 sides, each {length} (missing)")))?;
            (Geometry::Box(Vector3::from(size)), Some(size.into_iter().fold(f64::INFINITY, f64::min)))
        }
        Kind::Cylinder => {
            let (radius, long) = (table.number("radius", &length)?, table.number("length", &length)?);
            (Geometry::Cylinder(radius, long), Some(long.min(2.0 * radius)))
        }
        Kind::Capsule => (Geometry::Capsule(table.number("radius", &length)?, table.number("length", &length)?), None),
        Kind::Sphere => (Geometry::Sphere(table.number("radius", &length)?), None),
    };
    let edge_radius = match (&geometry, side) {
        (_, Some(side)) => {
            let edge =
                table.number_or("edge_radius", &Range::positive("m").up_to(1e3), EDGE_RADIUS.min(0.25 * side))?;
            if edge >= 0.5 * side {
                return Err(
                    table.error("edge_radius", format!("a radius below {} m, half the smallest side", 0.5 * side))
                );
            }
            edge
        }
        (Geometry::Capsule(radius, _) | Geometry::Sphere(radius), None) => *radius,
        _ => EDGE_RADIUS,
    };
    let vector = |key, range| table.optional_vector::<3>(key, range).map(Option::unwrap_or_default);
    let ([x, y, z], [roll, pitch, yaw]) = (vector("xyz", &ranges::PLACE)?, vector("rpy", &ranges::TURN)?);
    let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    let pose = Isometry3::from_parts(Translation3::new(x, y, z), turn);
    let obstacle = Obstacle {
        shape: Shape { link: table.name("name")?.to_owned(), pose, geometry },
        edge_radius,
        stiffness: table.number_or("stiffness", &Range::between(1.0, 1e9, "N/m"), STIFFNESS)?,
        damping: table.number_or("damping", &Range::between(0.0, 1e5, "N·s/m"), DAMPING)?,
    };
    table.finish()?;
    Ok(obstacle)
}

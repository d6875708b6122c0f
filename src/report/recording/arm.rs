//! The arm in three dimensions: the meshes of its links, or their collision shapes, with the poses of the links.

use std::fs;

use nalgebra::{Isometry3, Point3, Vector3};
use rerun::RecordingStream;
use rerun_types::components::{FillMode, MediaType};

use super::Motion;
use super::entities::{failed, log_static, single, times};
use crate::dynamics::{Dynamics, convex_hull};
use crate::error::Result;
use crate::robot::{Geometry, Robot, Shape};

/// Colours of the links, from the base outwards.
const LINKS: [[u8; 3]; 6] =
    [[120, 124, 130], [90, 160, 255], [240, 160, 60], [60, 200, 160], [220, 130, 180], [200, 200, 90]];

/// Colour of obstacles.
const OBSTACLE: [u8; 3] = [200, 80, 60];

/// [bytes] Most of all mesh files: a recording is to be opened at once.
const MOST_BYTES: u64 = 64 << 20;

/// Meshes and shapes below `arm/<link>`, obstacles below `arm/obstacles`, and the motion of their links from `start` [s] on.
pub fn log(stream: &RecordingStream, motion: &Motion<'_>, start: f64) -> Result<()> {
    let robot = motion.robot;
    let drawn = log_meshes(stream, robot)?;
    for (index, shape) in robot.base_shapes.iter().enumerate().filter(|_| !drawn.contains(&None)) {
        log_shape(stream, &format!("arm/base/{index}"), shape, LINKS[0])?;
    }
    for (number, body) in robot.bodies.iter().enumerate().filter(|(number, _)| !drawn.contains(&Some(*number))) {
        let colour = LINKS[1 + number % (LINKS.len() - 1)];
        for (index, shape) in body.shapes.iter().enumerate() {
            log_shape(stream, &format!("arm/{}/{index}", body.name), shape, colour)?;
        }
    }
    if drawn.is_empty() && extent_of_shapes(robot).is_none() {
        log_skeleton(stream, robot)?;
    }
    for obstacle in motion.obstacles {
        log_shape(stream, &format!("arm/obstacles/{}", obstacle.shape.link), &obstacle.shape, OBSTACLE)?;
    }
    log_motion(stream, motion, start)
}

/// Lines from each joint to the next and to the centre of mass, for a robot without shapes.
fn log_skeleton(stream: &RecordingStream, robot: &Robot) -> Result<()> {
    for (number, body) in robot.bodies.iter().enumerate() {
        let origin = Vector3::zeros();
        let children = robot.bodies.iter().filter(|child| child.parent == Some(number));
        let mut ends: Vec<Vector3<f64>> = children.map(|child| child.joint.origin.translation.vector).collect();
        if ends.is_empty() {
            ends.push(2.0 * body.inertia.com);
        }
        let lines = ends.iter().map(|end| [origin, *end].map(|point| <[f32; 3]>::from(point.map(single))));
        let lines = rerun_types::archetypes::LineStrips3D::new(lines)
            .with_colors([LINKS[1 + number % (LINKS.len() - 1)]])
            .with_radii([0.012]);
        log_static(stream, &format!("arm/{}/line", body.name), &lines)?;
        let joint =
            rerun_types::archetypes::Points3D::new([[0.0, 0.0, 0.0]]).with_colors([LINKS[0]]).with_radii([0.025]);
        log_static(stream, &format!("arm/{}/joint", body.name), &joint)?;
    }
    Ok(())
}

/// One transform per link and frame.
fn log_motion(stream: &RecordingStream, motion: &Motion<'_>, start: f64) -> Result<()> {
    let session = &motion.session;
    let joint = |body: &crate::robot::Body| session.joint(&body.joint.name).map(|joint| joint.pose.as_slice());
    let positions: Vec<Option<&[f64]>> = motion.robot.bodies.iter().map(joint).collect();
    let mut dynamics = Dynamics::new(motion.robot);
    let poses: Vec<Vec<Isometry3<f64>>> = (0..session.times.len())
        .map(|frame| {
            let position =
                |values: &Option<&[f64]>| values.and_then(|values| values.get(frame)).copied().unwrap_or(0.0);
            dynamics.poses(&positions.iter().map(position).collect::<Vec<f64>>())
        })
        .collect();
    for (index, body) in motion.robot.bodies.iter().enumerate() {
        let path = format!("arm/{}", body.name);
        let transforms = rerun_types::archetypes::Transform3D::update_fields()
            .with_many_translation(poses.iter().map(|poses| translation(&poses[index])))
            .with_many_quaternion(poses.iter().map(|poses| quaternion(&poses[index])));
        let columns = transforms.columns_of_unit_batches().map_err(|source| failed(&path, source))?;
        let time = times(session.times.iter().copied(), start);
        stream.send_columns(path.as_str(), [time], columns).map_err(|source| failed(&path, source))?;
    }
    Ok(())
}

/// Centre and radius [m] of the space that the arm occupies in its zero position.
pub fn extent(robot: &Robot) -> (Vector3<f64>, f64) {
    let (low, high) = extent_of_shapes(robot).unwrap_or_else(|| {
        let reach: f64 = robot.bodies.iter().map(|body| body.joint.origin.translation.vector.norm()).sum();
        let reach = Vector3::repeat(reach.max(0.1));
        (-reach, reach)
    });
    (0.5 * (low + high), (0.5 * (high - low).norm()).max(1e-3))
}

/// Lowest and highest corner [m] of the space that the shapes occupy in the zero position; `None` without shapes.
fn extent_of_shapes(robot: &Robot) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let poses = Dynamics::new(robot).poses(&vec![0.0; robot.dof()]);
    let moved =
        robot.bodies.iter().zip(&poses).flat_map(|(body, pose)| body.shapes.iter().map(move |shape| (pose, shape)));
    let fixed = Isometry3::identity();
    let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    for (pose, shape) in robot.base_shapes.iter().map(|shape| (&fixed, shape)).chain(moved) {
        let (centre, radius) = ball(&shape.geometry);
        let centre = (pose * shape.pose * Point3::from(centre)).coords;
        low = low.inf(&centre.add_scalar(-radius));
        high = high.sup(&centre.add_scalar(radius));
    }
    (low.x <= high.x).then_some((low, high))
}

/// Bounding sphere of a shape: its centre in the shape's frame, and its radius [m].
fn ball(geometry: &Geometry) -> (Vector3<f64>, f64) {
    match geometry {
        Geometry::Box(sides) => (Vector3::zeros(), 0.5 * sides.norm()),
        Geometry::Cylinder(radius, length) => (Vector3::zeros(), radius.hypot(0.5 * length)),
        Geometry::Capsule(radius, length) => (Vector3::zeros(), radius + 0.5 * length),
        Geometry::Sphere(radius) => (Vector3::zeros(), *radius),
        Geometry::ConvexHull(corners) => {
            #[expect(clippy::cast_precision_loss, reason = "a count of corners")]
            let centre = corners.iter().sum::<Vector3<f64>>() / corners.len().max(1) as f64;
            (centre, corners.iter().map(|corner| (corner - centre).norm()).fold(0.0, f64::max))
        }
    }
}

fn translation(pose: &Isometry3<f64>) -> [f32; 3] {
    pose.translation.vector.map(single).into()
}

fn quaternion(pose: &Isometry3<f64>) -> rerun_types::datatypes::Quaternion {
    rerun_types::datatypes::Quaternion::from_xyzw(pose.rotation.coords.map(single).into())
}

fn log_shape(stream: &RecordingStream, path: &str, shape: &Shape, colour: [u8; 3]) -> Result<()> {
    let centre = [translation(&shape.pose)];
    let turn = [quaternion(&shape.pose)];
    match &shape.geometry {
        Geometry::Box(sides) => {
            let boxes =
                rerun_types::archetypes::Boxes3D::from_centers_and_sizes(centre, [<[f32; 3]>::from(sides.map(single))]);
            log_static(
                stream,
                path,
                &boxes.with_quaternions(turn).with_colors([colour]).with_fill_mode(FillMode::Solid),
            )
        }
        Geometry::Cylinder(radius, length) => {
            let cylinders =
                rerun_types::archetypes::Cylinders3D::from_lengths_and_radii([single(*length)], [single(*radius)]);
            let cylinders = cylinders.with_centers(centre).with_quaternions(turn);
            log_static(stream, path, &cylinders.with_colors([colour]).with_fill_mode(FillMode::Solid))
        }
        Geometry::Capsule(radius, length) => {
            // The archetype's capsule starts at the centre of its lower cap; that of the model is centred.
            let lower = shape.pose * Point3::new(0.0, 0.0, -0.5 * length);
            let capsules =
                rerun_types::archetypes::Capsules3D::from_lengths_and_radii([single(*length)], [single(*radius)]);
            let capsules = capsules.with_translations([<[f32; 3]>::from(lower.coords.map(single))]);
            log_static(
                stream,
                path,
                &capsules.with_quaternions(turn).with_colors([colour]).with_fill_mode(FillMode::Solid),
            )
        }
        Geometry::Sphere(radius) => {
            let spheres = rerun_types::archetypes::Ellipsoids3D::from_centers_and_radii(centre, [single(*radius)]);
            log_static(stream, path, &spheres.with_colors([colour]).with_fill_mode(FillMode::Solid))
        }
        Geometry::ConvexHull(points) => log_static(stream, path, &hull(points, &shape.pose, colour)),
    }
}

/// The convex hull of some points, its triangles shaded as plane faces.
fn hull(points: &[Vector3<f64>], pose: &Isometry3<f64>, colour: [u8; 3]) -> rerun_types::archetypes::Mesh3D {
    let triangles = convex_hull(points).unwrap_or_default();
    let corners =
        triangles.iter().flatten().map(|corner| <[f32; 3]>::from((pose * Point3::from(*corner)).coords.map(single)));
    let normal =
        |[a, b, c]: &[Vector3<f64>; 3]| <[f32; 3]>::from((pose * (b - a).cross(&(c - a)).normalize()).map(single));
    let normals = triangles.iter().flat_map(|triangle| [normal(triangle); 3]);
    rerun_types::archetypes::Mesh3D::new(corners).with_vertex_normals(normals).with_albedo_factor(tint(colour))
}

fn tint([red, green, blue]: [u8; 3]) -> rerun_types::components::AlbedoFactor {
    rerun_types::datatypes::Rgba32::from_rgb(red, green, blue).into()
}

/// Meshes of links below `arm/<link>/drawn`; returns the bodies that are drawn by meshes, and `None` for the base. A file that cannot be read
/// leaves its link to the collision shapes.
fn log_meshes(stream: &RecordingStream, robot: &Robot) -> Result<Vec<Option<usize>>> {
    let mut drawn = Vec::new();
    let mut left = MOST_BYTES;
    for (index, mesh) in robot.drawn.iter().enumerate() {
        let fits = |file: &fs::Metadata| file.is_file() && file.len() <= left;
        let content = fs::metadata(&mesh.file).ok().filter(fits).and_then(|_| fs::read(&mesh.file).ok());
        let (Some(content), Some(format)) = (content, MediaType::guess_from_path(&mesh.file)) else { continue };
        left = left.saturating_sub(content.len() as u64);
        let name = mesh.body.map_or("base", |body| robot.bodies[body].name.as_str());
        let path = format!("arm/{name}/drawn/{index}");
        let place = rerun_types::archetypes::Transform3D::from_translation_rotation_scale(
            translation(&mesh.pose),
            quaternion(&mesh.pose),
            <[f32; 3]>::from(mesh.scale.map(single)),
        );
        log_static(stream, &path, &place)?;
        log_static(stream, &path, &rerun_types::archetypes::Asset3D::new(content).with_media_type(format))?;
        drawn.push(mesh.body);
    }
    Ok(drawn)
}

//! The only place that names urdf-rs: reads a checked text with it, and converts the result to the types of this project.

use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
pub(super) use urdf_rs::{Geometry as Solid, Joint, JointType, Link, Robot};

use super::mend::mended;
use super::mesh;
use super::scan::Element;
use super::text::UrdfText;
use crate::error::Result;
use crate::robot::tree::{Geometry, Inertia, Limits};
use crate::units::JointKind;

/// [rad or m, rad/s or m/s, N·m or N] Limits of this size or more count as none: exporters write 1e16 or the largest number for
/// a continuous joint.
const UNLIMITED: f64 = 1e9;

/// Links and joints of a checked text, in the order of the file.
///
/// # Errors
/// urdf-rs refuses the text; the error gives the line of the first link or joint that it refuses.
pub(super) fn read(text: &UrdfText<'_>) -> Result<Robot> {
    let content = || text.owners("link").chain(text.owners("joint"));
    urdf_rs::read_from_string(&mended(text, content())).map_err(|error| {
        let alone = |element: &Element<'_>| urdf_rs::read_from_string(&mended(text, std::iter::once(element)));
        let faulty = content().find_map(|element| Some((element, alone(element).err()?)));
        let (line, what, error) = match faulty {
            Some((element, error)) => (element.line, text.title(element), error),
            None => (text.elements().first().map_or(1, |robot| robot.line), "robot".to_owned(), error),
        };
        text.broken(line, format!("a {what} that urdf-rs reads ({})", reason(&error.to_string())))
    })
}

/// Reason of an error without the position in the mended text: `Syntax: 1:21 REASON`.
fn reason(message: &str) -> &str {
    message.strip_prefix("Syntax: ").and_then(|rest| rest.split_once(' ')).map_or(message, |(_, reason)| reason)
}

/// A link of which only the name is known.
pub(super) fn bare_link(name: &str) -> Link {
    Link { name: name.to_owned(), inertial: urdf_rs::Inertial::default(), visual: Vec::new(), collision: Vec::new() }
}

/// How a joint moves; `None` for one that does not turn or slide.
pub(super) fn kind_of(joint: &Joint) -> Option<JointKind> {
    match joint.joint_type {
        JointType::Revolute | JointType::Continuous => Some(JointKind::Revolute),
        JointType::Prismatic => Some(JointKind::Prismatic),
        JointType::Fixed | JointType::Floating | JointType::Planar | JointType::Spherical => None,
    }
}

/// Damping [N·m·s/rad or N·s/m] and friction [N·m or N] of a joint.
pub(super) fn dynamics_of(joint: &Joint) -> (f64, f64) {
    joint.dynamics.as_ref().map_or((0.0, 0.0), |dynamics| (dynamics.damping, dynamics.friction))
}

/// Limits. URDF's default of zero counts as not given, and so does the range of a continuous joint.
pub(super) fn limits_of(joint: &Joint) -> Limits {
    let given = |value: f64| if value > 0.0 && value < UNLIMITED { value } else { f64::INFINITY };
    let urdf_rs::JointLimit { lower, upper, effort, velocity, .. } = joint.limit;
    let free = joint.joint_type == JointType::Continuous || (lower == 0.0 && upper == 0.0);
    let lower = if free || lower <= -UNLIMITED { f64::NEG_INFINITY } else { lower };
    let upper = if free || upper >= UNLIMITED { f64::INFINITY } else { upper };
    Limits { lower, upper, effort: given(effort), velocity: given(velocity) }
}

/// Inertia of a link as written in the file, rotated from its inertial frame into the link's frame.
pub(super) fn inertia_of(link: &Link) -> Inertia {
    let urdf_rs::Inertia { ixx, ixy, ixz, iyy, iyz, izz } = link.inertial.inertia;
    let tensor = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
    let mass = link.inertial.mass.value;
    Inertia { mass, com: Vector3::zeros(), tensor }.seen_from(&isometry(&link.inertial.origin))
}

/// URDF's `xyz` and `rpy`: rotation about the fixed axes x, y, z in this order, then translation.
pub(super) fn isometry(pose: &urdf_rs::Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = pose.rpy.0;
    Isometry3::from_parts(
        Translation3::from(Vector3::from(pose.xyz.0)),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

/// A shape with its name and sizes [m]; a mesh is read from its file.
pub(super) fn shape_of(urdf: &Path, geometry: &Solid) -> Result<(Geometry, &'static str, Vec<f64>), mesh::Unread> {
    Ok(match geometry {
        Solid::Box { size } => (Geometry::Box(Vector3::from(size.0)), "<box>", size.0.to_vec()),
        Solid::Cylinder { radius, length } => {
            (Geometry::Cylinder(*radius, *length), "<cylinder>", vec![*radius, *length])
        }
        Solid::Capsule { radius, length } => (Geometry::Capsule(*radius, *length), "<capsule>", vec![*radius, *length]),
        Solid::Sphere { radius } => (Geometry::Sphere(*radius), "<sphere>", vec![*radius]),
        Solid::Mesh { filename, scale } => {
            let scale = scale.map_or_else(|| Vector3::repeat(1.0), |scale| Vector3::from(scale.0));
            (Geometry::ConvexHull(mesh::points(urdf, filename, &scale)?), "<mesh>", Vec::new())
        }
    })
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use nalgebra::Quaternion;

    use super::super::grammar;
    use super::*;

    fn robot(text: &str) -> Result<Robot> {
        let scanned = UrdfText::scan(Path::new("a.urdf"), text, None)?;
        grammar::check(&scanned)?;
        read(&scanned)
    }

    fn files_of(folder: &Path) -> Vec<PathBuf> {
        std::fs::read_dir(folder)
            .map_or_else(|_| Vec::new(), |inside| inside.map(|entry| entry.unwrap().path()).collect())
    }

    #[test]
    fn equivalent_mending_a_sound_file_changes_nothing_that_is_read() {
        let folders = files_of(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots"));
        let files = folders.iter().flat_map(|folder| files_of(folder));
        let mut joints = 0;
        for file in files.filter(|file| file.extension().is_some_and(|extension| extension == "urdf")) {
            let text = std::fs::read_to_string(&file).unwrap();
            let (own, mut other) = (robot(&text).unwrap(), urdf_rs::read_from_string(&text).unwrap());
            // Elements that nothing reads are removed; everything else must be the same in both.
            other.materials.clear();
            for link in &mut other.links {
                link.visual.clear();
                link.collision.iter_mut().for_each(|collision| collision.name = None);
            }
            for joint in &mut other.joints {
                (joint.calibration, joint.safety_controller) = (None, None);
            }
            assert_eq!(format!("{own:?}"), format!("{other:?}"), "{}", file.display());
            joints += own.joints.len();
        }
        assert!(joints > 20, "{joints} joints");
    }

    fn turned(version: &str, origin: &str) -> Isometry3<f64> {
        let text = format!(
            "<robot version=\"{version}\"><link name=\"a\"/><link name=\"b\"/><joint name=\"c\" type=\"fixed\">\
             <parent link=\"a\"/><child link=\"b\"/><origin xyz=\"1 2 3\" {origin}/></joint></robot>"
        );
        isometry(&robot(&text).unwrap().joints[0].origin)
    }

    #[test]
    fn property_a_quaternion_is_read_from_version_1_1_on() {
        // The last one is 0.1° from the pole of roll, pitch and yaw.
        for (axis, angle) in
            [([0.3, -0.5, 0.8], 1.1), ([-1.0, 0.2, 0.1], 3.0), ([0.0, 1.0, 0.0], 89.9_f64.to_radians())]
        {
            let axis = nalgebra::Unit::new_normalize(Vector3::from(axis));
            let rotation = UnitQuaternion::from_axis_angle(&axis, angle);
            let Quaternion { coords } = *rotation.quaternion() * 2.0;
            let origin = format!("rpy=\"1 0 0\" quat_xyzw=\"{} {} {} {}\"", coords.x, coords.y, coords.z, coords.w);
            let found = turned("1.1", &origin);
            assert_eq!(found.translation.vector, Vector3::new(1.0, 2.0, 3.0));
            // An arcsine at 89.9° has a slope of 1 / cos 89.9° = 573: it multiplies some ten roundings of 1e-16.
            assert!(found.rotation.angle_to(&rotation) < 1e-12, "{found}");
            assert!(
                turned("1.0", &origin).rotation.angle_to(&UnitQuaternion::from_euler_angles(1.0, 0.0, 0.0)) < 1e-12
            );
        }
    }

    #[test]
    fn property_missing_limits_are_open_from_version_1_2_on() {
        let limits = |version: &str| {
            let text = format!(
                "<robot version=\"{version}\"><link name=\"a\"/><link name=\"b\"/><joint name=\"c\" type=\"revolute\">\
                 <parent link=\"a\"/><child link=\"b\"/><limit upper=\"2\" effort=\"3\"/></joint></robot>"
            );
            limits_of(&robot(&text).unwrap().joints[0])
        };
        let Limits { lower, upper, effort, velocity } = limits("1.2");
        assert_eq!((lower, upper, effort, velocity), (f64::NEG_INFINITY, 2.0, 3.0, f64::INFINITY));
        assert_eq!(limits("1.1").lower, 0.0);
    }

    #[test]
    fn property_names_stay() {
        let name = "a &amp; &lt;b&gt; &quot;c&apos; d\te\nf&#10;g ü";
        let text = format!("<robot name=\"{name}\">\n<link\nname=\"{name}\"/></robot>");
        let scanned = UrdfText::scan(Path::new("a.urdf"), &text, None).unwrap();
        let robot = read(&scanned).unwrap();
        assert_eq!(scanned.elements()[1].attribute("name"), Some(robot.links[0].name.as_str()));
        assert_eq!(robot.name, robot.links[0].name);
    }

    #[test]
    fn property_what_urdf_rs_does_not_read_is_an_error_with_its_line() {
        let text = "<robot>\n<link name=\"a\"/>\n<link name=\"b&#1;\"/></robot>";
        let unchecked = UrdfText::scan(Path::new("a.urdf"), text, None).unwrap();
        let error = read(&unchecked).unwrap_err().to_string();
        let expected = "a.urdf:3: URDF: expected a link b\\u{1} that urdf-rs reads (Invalid character U+0001)";
        assert_eq!(error, expected);
    }
}

//! From URDF to the tree: the only place that names `urdf_rs`.
//!
//! Fixed joints, and movable ones that are held at zero, are merged: what they carry becomes part of the body before them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};
use urdf_rs::JointType;

use super::mesh;
use super::tree::{Body, Geometry, Inertia, Joint, Limits, Robot, Shape, UnreadShape};
use super::urdf_text::UrdfText;
use crate::error::{Error, Place, Result};
use crate::toml_input::nearest;
use crate::units::JointKind;

/// [m/s²] Gravity where the model file gives none.
pub const STANDARD_GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// A URDF with its lines, its numbers checked, its links and joints known to form a tree.
pub(super) struct Urdf<'a> {
    file: &'a Path,
    text: UrdfText<'a>,
    robot: urdf_rs::Robot,
    root: usize,
}

impl<'a> Urdf<'a> {
    /// Reads the text of a URDF.
    ///
    /// # Errors
    /// It is no URDF, a number is none, links and joints form no tree, a link's inertia is one that no body can have.
    pub(super) fn parse(file: &'a Path, text: &'a str) -> Result<Self> {
        if text.contains("<xacro:") {
            return Err(Error::input(file, Place::File, "", "", "plain URDF; run xacro on this file first"));
        }
        let scanned = UrdfText::scan(file, text)?;
        let robot = urdf_rs::read_from_string(text)
            .map_err(|error| Error::input(file, Place::File, "", "", format!("URDF: {error}")))?;
        let root = root_of(file, &scanned, &robot)?;
        let urdf = Self { file, text: scanned, robot, root };
        urdf.check_links()?;
        urdf.check_joints()?;
        Ok(urdf)
    }

    /// Names of the joints that turn or slide, in the order of the file.
    pub(super) fn movable_joints(&self) -> Vec<&str> {
        let movable = self.robot.joints.iter().filter(|joint| kind_of(joint).is_some() && joint.mimic.is_none());
        movable.map(|joint| joint.name.as_str()).collect()
    }

    /// Whether a joint follows another one.
    pub(super) fn mimics(&self, name: &str) -> bool {
        self.robot.joints.iter().any(|joint| joint.name == name && joint.mimic.is_some())
    }

    /// The tree in which exactly the joints of `moving` move, and the names of the movable joints held at zero.
    ///
    /// # Errors
    /// A joint mimics one that moves, or a moving body has no inertia to be moved.
    pub(super) fn tree(&self, moving: &BTreeSet<&str>) -> Result<(Robot, Vec<String>)> {
        let mut tree = Robot {
            name: self.robot.name.clone(),
            gravity: STANDARD_GRAVITY,
            base_shapes: Vec::new(),
            unread_shapes: Vec::new(),
            bodies: Vec::new(),
        };
        let links: BTreeMap<&str, &urdf_rs::Link> = self.robot.links.iter().map(|link| (&*link.name, link)).collect();
        let mut children: BTreeMap<&str, Vec<&urdf_rs::Joint>> = BTreeMap::new();
        for joint in &self.robot.joints {
            children.entry(&joint.parent.link).or_default().push(joint);
        }
        let mut held = Vec::new();
        self.add_link(&mut tree, &self.robot.links[self.root], None, &Isometry3::identity())?;
        // Joints still to be visited, the first of the file on top: body of the parent link, and the link's pose in it.
        let mut waiting = Vec::new();
        let push = |waiting: &mut Vec<_>, link: &str, body, pose| {
            waiting.extend(children.get(link).into_iter().flatten().rev().map(|&joint| (joint, body, pose)));
        };
        push(&mut waiting, &self.robot.links[self.root].name, None, Isometry3::identity());
        while let Some((joint, parent, pose)) = waiting.pop() {
            let origin = pose * isometry(&joint.origin);
            let (body, pose) = match kind_of(joint) {
                Some(kind) if moving.contains(joint.name.as_str()) => {
                    tree.bodies.push(self.body(joint, kind, parent, origin)?);
                    (Some(tree.bodies.len() - 1), Isometry3::identity())
                }
                Some(_) => {
                    self.check_mimic(joint, moving)?;
                    held.push(joint.name.clone());
                    (parent, origin)
                }
                None => (parent, origin),
            };
            if let Some(link) = links.get(joint.child.link.as_str()) {
                self.add_link(&mut tree, link, body, &pose)?;
            }
            push(&mut waiting, &joint.child.link, body, pose);
        }
        self.check_bodies(&tree)?;
        Ok((tree, held))
    }

    fn body(
        &self,
        joint: &urdf_rs::Joint,
        kind: JointKind,
        parent: Option<usize>,
        origin: Isometry3<f64>,
    ) -> Result<Body> {
        if joint.mimic.is_some() {
            let expected = "a joint of its own; one that mimics another cannot be listed in the model file";
            return Err(self.text.error("joint", &joint.name, "mimic", "", expected));
        }
        let axis = Vector3::from(joint.axis.xyz.0);
        let axis = Unit::try_new(axis, 1e-9)
            .ok_or_else(|| self.text.error("joint", &joint.name, "axis", "0 0 0", "an axis that is not zero"))?;
        let dynamics = joint.dynamics.clone().unwrap_or_default();
        Ok(Body {
            name: joint.child.link.clone(),
            parent,
            joint: Joint {
                name: joint.name.clone(),
                kind,
                origin,
                axis,
                limits: limits_of(joint),
                damping: dynamics.damping,
                friction: dynamics.friction,
            },
            inertia: Inertia::zero(),
            shapes: Vec::new(),
        })
    }

    /// Adds what a link weighs and its collision shapes to its body, or to the base.
    fn add_link(
        &self,
        tree: &mut Robot,
        link: &urdf_rs::Link,
        body: Option<usize>,
        pose: &Isometry3<f64>,
    ) -> Result<()> {
        let mut shapes = Vec::new();
        for collision in &link.collision {
            let pose = pose * isometry(&collision.origin);
            match self.geometry(&link.name, &collision.geometry)? {
                Ok(geometry) => shapes.push(Shape { link: link.name.clone(), pose, geometry }),
                Err((file, expected)) => {
                    tree.unread_shapes.push(UnreadShape { link: link.name.clone(), file, expected });
                }
            }
        }
        match body {
            None => tree.base_shapes.extend(shapes),
            Some(index) => {
                let body = &mut tree.bodies[index];
                body.inertia = body.inertia.joined(&inertia_of(&link.inertial).seen_from(pose));
                body.shapes.extend(shapes);
            }
        }
        Ok(())
    }

    /// A collision geometry; the inner error is a mesh that was not read, and what was expected of it.
    fn geometry(&self, link: &str, geometry: &urdf_rs::Geometry) -> Result<Result<Geometry, mesh::Unread>> {
        let (geometry, sizes) = match geometry {
            urdf_rs::Geometry::Box { size } => (Geometry::Box(Vector3::from(size.0)), size.0.to_vec()),
            urdf_rs::Geometry::Cylinder { radius, length } => {
                (Geometry::Cylinder(*radius, *length), vec![*radius, *length])
            }
            urdf_rs::Geometry::Capsule { radius, length } => {
                (Geometry::Capsule(*radius, *length), vec![*radius, *length])
            }
            urdf_rs::Geometry::Sphere { radius } => (Geometry::Sphere(*radius), vec![*radius]),
            urdf_rs::Geometry::Mesh { filename, scale } => {
                let scale = scale.map_or(Vector3::repeat(1.0), |scale| Vector3::from(scale.0));
                return Ok(mesh::points(self.file, filename, &scale).map(Geometry::ConvexHull));
            }
        };
        if sizes.iter().all(|&size| size > 0.0) {
            return Ok(Ok(geometry));
        }
        Err(self.text.error("link", link, "collision", format!("{sizes:?}"), "sizes > 0 [m]"))
    }

    fn check_links(&self) -> Result<()> {
        for link in &self.robot.links {
            if let Some(fault) = inertia_of(&link.inertial).fault() {
                let (part, expected) = if link.inertial.mass.value < 0.0 {
                    ("mass", "a mass ≥ 0 [kg]".to_owned())
                } else {
                    ("inertia", format!("a tensor that a rigid body can have: {fault}"))
                };
                let tensor = &link.inertial.inertia;
                let value = match part {
                    "mass" => link.inertial.mass.value.to_string(),
                    _ => format!(
                        "[ixx {}, ixy {}, ixz {}, iyy {}, iyz {}, izz {}]",
                        tensor.ixx, tensor.ixy, tensor.ixz, tensor.iyy, tensor.iyz, tensor.izz
                    ),
                };
                return Err(self.text.error("link", &link.name, part, value, expected));
            }
        }
        Ok(())
    }

    fn check_joints(&self) -> Result<()> {
        for joint in &self.robot.joints {
            let refuse =
                |part, value: String, expected: &str| Err(self.text.error("joint", &joint.name, part, value, expected));
            let (lower, upper) = (joint.limit.lower, joint.limit.upper);
            let dynamics = joint.dynamics.clone().unwrap_or_default();
            if matches!(joint.joint_type, JointType::Floating | JointType::Planar | JointType::Spherical) {
                let name = format!("{:?}", joint.joint_type).to_lowercase();
                return refuse("type", name, "revolute, continuous, prismatic or fixed");
            }
            if lower > upper {
                return refuse("limit", format!("lower {lower}, upper {upper}"), "lower ≤ upper");
            }
            if joint.limit.effort < 0.0 || joint.limit.velocity < 0.0 {
                let value = format!("effort {}, velocity {}", joint.limit.effort, joint.limit.velocity);
                return refuse("limit", value, "effort ≥ 0 and velocity ≥ 0");
            }
            if dynamics.damping < 0.0 || dynamics.friction < 0.0 {
                let value = format!("damping {}, friction {}", dynamics.damping, dynamics.friction);
                return refuse("dynamics", value, "damping ≥ 0 and friction ≥ 0");
            }
        }
        Ok(())
    }

    /// A joint that is held at zero must not mimic one that moves, nor stand elsewhere than at zero.
    fn check_mimic(&self, joint: &urdf_rs::Joint, moving: &BTreeSet<&str>) -> Result<()> {
        match &joint.mimic {
            Some(mimic) if moving.contains(mimic.joint.as_str()) || mimic.offset.unwrap_or(0.0) != 0.0 => {
                let expected = "a joint of its own; one that mimics a moving joint is not supported";
                Err(self.text.error("joint", &joint.name, "mimic", &mimic.joint, expected))
            }
            _ => Ok(()),
        }
    }

    /// A body that moves needs a mass; the last of a branch that turns, also a moment of inertia about its axis.
    fn check_bodies(&self, tree: &Robot) -> Result<()> {
        for (index, body) in tree.bodies.iter().enumerate() {
            let Inertia { mass, .. } = body.inertia;
            if mass <= 0.0 {
                let expected = "a mass > 0 [kg] of the link that moves and all that is fixed to it";
                return Err(self.text.error("link", &body.name, "mass", mass, expected));
            }
            let axis = body.joint.axis;
            let moment = axis.dot(&(body.inertia.tensor_about(&Vector3::zeros()) * *axis));
            let last = tree.bodies.iter().all(|other| other.parent != Some(index));
            if last && body.joint.kind == JointKind::Revolute && moment <= 0.0 {
                let expected = format!("a moment of inertia > 0 [kg·m²] about the axis of joint {}", body.joint.name);
                return Err(self.text.error("link", &body.name, "inertia", moment, expected));
            }
        }
        Ok(())
    }
}

/// Index of the link that no joint moves, once it is sure that all others hang from it.
fn root_of(file: &Path, text: &UrdfText<'_>, robot: &urdf_rs::Robot) -> Result<usize> {
    let mut index: BTreeMap<&str, usize> = BTreeMap::new();
    for (i, link) in robot.links.iter().enumerate() {
        if index.insert(&link.name, i).is_some() {
            return Err(text.error("link", &link.name, "", "", "a name that no other link has"));
        }
    }
    let mut names = BTreeSet::new();
    let mut parent: Vec<Option<usize>> = vec![None; robot.links.len()];
    for joint in &robot.joints {
        if !names.insert(joint.name.as_str()) {
            return Err(text.error("joint", &joint.name, "", "", "a name that no other joint has"));
        }
        let find = |part, link: &str| {
            let near = nearest(link, index.keys().copied()).map(|name| format!(", such as {name}")).unwrap_or_default();
            let missing = || text.error("joint", &joint.name, part, link, format!("a link of this file{near}"));
            index.get(link).copied().ok_or_else(missing)
        };
        let (above, below) = (find("parent", &joint.parent.link)?, find("child", &joint.child.link)?);
        if parent[below].replace(above).is_some() {
            return Err(text.error(
                "joint",
                &joint.name,
                "child",
                &joint.child.link,
                "a link that no other joint moves",
            ));
        }
    }
    let roots: Vec<usize> = (0..parent.len()).filter(|&link| parent[link].is_none()).collect();
    let [root] = roots[..] else {
        let names: Vec<&str> = roots.iter().map(|&link| robot.links[link].name.as_str()).collect();
        let expected = "one link that no joint moves (the base)";
        return Err(Error::input(file, Place::File, "links without a joint", names.join(", "), expected));
    };
    // With one parent a link and one root, whatever does not hang from the root turns in a circle.
    for (link, found) in robot.links.iter().zip(hanging_from(root, &parent)) {
        if !found {
            return Err(text.error("link", &link.name, "", "", "a link that hangs from the base, not from itself"));
        }
    }
    Ok(root)
}

/// Which links hang from the root.
fn hanging_from(root: usize, parent: &[Option<usize>]) -> Vec<bool> {
    let mut children = vec![Vec::new(); parent.len()];
    for (link, above) in parent.iter().enumerate() {
        if let Some(above) = above {
            children[*above].push(link);
        }
    }
    let mut found = vec![false; parent.len()];
    let mut waiting = vec![root];
    while let Some(link) = waiting.pop() {
        found[link] = true;
        waiting.extend(&children[link]);
    }
    found
}

fn kind_of(joint: &urdf_rs::Joint) -> Option<JointKind> {
    match joint.joint_type {
        JointType::Revolute | JointType::Continuous => Some(JointKind::Revolute),
        JointType::Prismatic => Some(JointKind::Prismatic),
        JointType::Fixed | JointType::Floating | JointType::Planar | JointType::Spherical => None,
    }
}

/// Limits; what URDF leaves at its default of zero is not given, and so is the range of a continuous joint.
fn limits_of(joint: &urdf_rs::Joint) -> Limits {
    let given = |value: f64| if value > 0.0 { value } else { f64::INFINITY };
    let urdf_rs::JointLimit { lower, upper, effort, velocity, .. } = joint.limit;
    let free = joint.joint_type == JointType::Continuous || (lower == 0.0 && upper == 0.0);
    let (lower, upper) = if free { (f64::NEG_INFINITY, f64::INFINITY) } else { (lower, upper) };
    Limits { lower, upper, effort: given(effort), velocity: given(velocity) }
}

/// Inertia of a link in the link's frame, its inertial frame turned back.
fn inertia_of(inertial: &urdf_rs::Inertial) -> Inertia {
    let urdf_rs::Inertia { ixx, ixy, ixz, iyy, iyz, izz } = inertial.inertia;
    let tensor = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
    Inertia { mass: inertial.mass.value, com: Vector3::zeros(), tensor }.seen_from(&isometry(&inertial.origin))
}

/// URDF's `xyz` and `rpy`: turned about the fixed axes x, y, z in this order, then moved.
fn isometry(pose: &urdf_rs::Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = pose.rpy.0;
    Isometry3::from_parts(
        Translation3::from(Vector3::from(pose.xyz.0)),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

//! Builds the tree: a link becomes a body, or a part of the body that it is fixed to.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};

use super::description::{
    Joint, JointType, Link, Solid, dynamics_of, inertia_of, isometry, kind_of, limits_of, shape_of,
};
use super::masses::Part;
use super::scan::Element;
use super::{Urdf, mend, mesh, visuals};
use crate::error::Result;
use crate::robot::remark::Remark;
use crate::robot::tree::{self, Body, Geometry, Inertia, Robot, STANDARD_GRAVITY, Shape, UnreadShape};
use crate::units::JointKind;

/// A tree, and the remarks on it.
pub(in crate::robot) struct Built {
    pub robot: Robot,
    /// Movable joints that are held at zero because they are not among the moving ones.
    pub held: Vec<String>,
    /// Values of the file that are not taken as written.
    pub remarks: Vec<Remark>,
}

impl Urdf<'_> {
    /// The tree in which exactly the joints of `moving` move.
    ///
    /// # Errors
    /// One of them mimics another joint or has no axis, a moving body has a negative mass, or a joint moves no inertia.
    pub(in crate::robot) fn tree(&self, moving: &BTreeSet<&str>) -> Result<Built> {
        let mut built = self.grown(moving)?;
        self.check_bodies(&built.robot, &mut built.remarks)?;
        Ok(built)
    }

    /// The tree in which every joint moves that has a mass to move and no reason to be held; the others are held at zero, with a remark.
    ///
    /// # Errors
    /// As [`tree`](Self::tree); no joint moves anything.
    pub(in crate::robot) fn whole_tree(&self, reasons: &BTreeMap<String, String>) -> Result<Built> {
        let free = |joint: &&str| !reasons.contains_key(*joint);
        let movable: BTreeSet<&str> = self.movable_joints().into_iter().filter(free).collect();
        let all = self.grown(&movable)?;
        let idle: BTreeSet<&str> = Self::idle(&all.robot).collect();
        if idle.len() == movable.len() {
            return self.tree(&movable);
        }
        let moving = movable.difference(&idle).copied().collect();
        let mut built = self.tree(&moving)?;
        let remark = |joint: &str, text: &str| self.text.remark("joint", joint, "", text);
        let without = "it moves no mass and is held at zero; give the links behind it an <inertial> if it is to move";
        built.remarks.extend(idle.into_iter().map(|joint| remark(joint, without)));
        built.remarks.extend(reasons.iter().map(|(joint, reason)| remark(joint, reason)));
        Ok(built)
    }

    /// The tree; its bodies are not checked yet.
    fn grown(&self, moving: &BTreeSet<&str>) -> Result<Built> {
        let robot = Robot {
            name: self.robot.name.clone(),
            gravity: STANDARD_GRAVITY,
            base_shapes: Vec::new(),
            unread_shapes: Vec::new(),
            drawn: Vec::new(),
            bodies: Vec::new(),
            coupling: None,
        };
        let mut built = Built { robot, held: Vec::new(), remarks: self.remarks.clone() };
        // A world that was added has no element.
        let elements = self.text.owners("link").map(Some).chain(std::iter::once(None));
        let links: BTreeMap<&str, (&Link, Option<&Element<'_>>)> =
            self.robot.links.iter().zip(elements).map(|(link, element)| (&*link.name, (link, element))).collect();
        let mut children: BTreeMap<&str, Vec<&Joint>> = BTreeMap::new();
        for joint in &self.robot.joints {
            children.entry(&joint.parent.link).or_default().push(joint);
        }
        // One list of parts per body.
        let mut parts: Vec<Vec<Part<'_>>> = Vec::new();
        let root = &self.robot.links[self.root];
        self.add_link(&mut built.robot, &mut parts, links[root.name.as_str()], None, &Isometry3::identity())?;
        // Joints still to be visited, the first of the file on top: with the body of the parent link, and that link's pose in the body.
        let mut waiting = Vec::new();
        let push = |waiting: &mut Vec<_>, link: &str, body, pose| {
            waiting.extend(children.get(link).into_iter().flatten().rev().map(|&joint| (joint, body, pose)));
        };
        push(&mut waiting, &root.name, None, Isometry3::identity());
        while let Some((joint, parent, pose)) = waiting.pop() {
            let origin = pose * isometry(&joint.origin);
            let (body, pose) = match kind_of(joint) {
                Some(kind) if moving.contains(joint.name.as_str()) => {
                    built.robot.bodies.push(self.body(joint, kind, parent, origin, &mut built.remarks)?);
                    parts.push(Vec::new());
                    (Some(built.robot.bodies.len() - 1), Isometry3::identity())
                }
                _ => (parent, origin * self.held_at(joint, &mut built)?),
            };
            if let Some(&link) = links.get(joint.child.link.as_str()) {
                self.add_link(&mut built.robot, &mut parts, link, body, &pose)?;
            }
            push(&mut waiting, &joint.child.link, body, pose);
        }
        for (body, parts) in built.robot.bodies.iter_mut().zip(&parts) {
            body.inertia = self.body_inertia(parts, &mut built.remarks)?;
        }
        Ok(built)
    }

    /// Displacement of a joint that does not move. A joint that mimics another is held at its offset: its position with the other at zero.
    fn held_at(&self, joint: &Joint, built: &mut Built) -> Result<Isometry3<f64>> {
        let mut remark = |part: &str, text: &str| {
            built.remarks.push(self.text.remark("joint", &joint.name, part, text));
        };
        match (kind_of(joint), &joint.mimic) {
            (Some(kind), Some(mimic)) => {
                let (other, offset) = (&mimic.joint, mimic.offset.unwrap_or(0.0));
                let unit = kind.position_unit();
                remark(
                    "mimic",
                    &format!("it mimics {other}; this is not simulated: it is held at its offset, {offset} {unit}"),
                );
                if offset == 0.0 {
                    Ok(Isometry3::identity())
                } else {
                    Ok(displacement(kind, &self.axis(joint)?, offset))
                }
            }
            (Some(_), None) => {
                built.held.push(joint.name.clone());
                Ok(Isometry3::identity())
            }
            (None, _) => {
                if joint.joint_type != JointType::Fixed {
                    let element = self.text.owner("joint", &joint.name);
                    let kind = element.and_then(|element| element.attribute("type")).unwrap_or_default();
                    remark("", &format!("of type {kind}: it is held fixed, as the base of the robot is"));
                }
                Ok(Isometry3::identity())
            }
        }
    }

    /// Direction of a joint's axis.
    fn axis(&self, joint: &Joint) -> Result<Unit<Vector3<f64>>> {
        let zero = || self.text.error("joint", &joint.name, "axis", "0 0 0", "an axis that is not zero");
        Unit::try_new(Vector3::from(joint.axis.xyz.0), 1e-9).ok_or_else(zero)
    }

    fn body(
        &self,
        joint: &Joint,
        kind: JointKind,
        parent: Option<usize>,
        origin: Isometry3<f64>,
        remarks: &mut Vec<Remark>,
    ) -> Result<Body> {
        if joint.mimic.is_some() {
            let expected = "a joint of its own; one that mimics another cannot be listed in the model file";
            return Err(self.text.error("joint", &joint.name, "mimic", "", expected));
        }
        self.check_joint(joint, remarks)?;
        let (damping, friction) = dynamics_of(joint);
        Ok(Body {
            name: joint.child.link.clone(),
            parent,
            joint: tree::Joint {
                name: joint.name.clone(),
                kind,
                origin,
                axis: self.axis(joint)?,
                limits: limits_of(joint),
                damping,
                friction,
            },
            inertia: Inertia::zero(),
            shapes: Vec::new(),
        })
    }

    /// Adds the mass and the collision shapes of a link to its body, or to the base.
    fn add_link<'s>(
        &'s self,
        robot: &mut Robot,
        parts: &mut [Vec<Part<'s>>],
        (link, element): (&'s Link, Option<&Element<'_>>),
        body: Option<usize>,
        pose: &Isometry3<f64>,
    ) -> Result<()> {
        let collisions = element.into_iter().flat_map(|element| self.text.children(element, "collision"));
        let unread = collisions.filter_map(|collision| mend::unread(&self.text, collision));
        let noted = |(file, expected)| UnreadShape { link: link.name.clone(), file, expected };
        robot.unread_shapes.extend(unread.map(noted));
        let drawn =
            element.into_iter().flat_map(|element| visuals::of_link(self.file, &self.text, element, body, pose));
        robot.drawn.extend(drawn);
        let mut shapes = Vec::new();
        for collision in &link.collision {
            match self.geometry(link, &collision.geometry)? {
                Ok(geometry) => {
                    shapes.push(Shape { link: link.name.clone(), pose: pose * isometry(&collision.origin), geometry });
                }
                Err(unread) => robot.unread_shapes.push(noted(unread)),
            }
        }
        let Some(index) = body else {
            robot.base_shapes.extend(shapes);
            return Ok(());
        };
        robot.bodies[index].shapes.extend(shapes);
        if let Some(inertial) = element.and_then(|element| self.text.child(element, "inertial")) {
            let has_tensor = self.text.child(inertial, "inertia").is_some();
            parts[index].push(Part { link, inertia: inertia_of(link).seen_from(pose), has_tensor });
        }
        Ok(())
    }

    /// A collision geometry; the inner error describes a shape that was not read, and what was expected.
    fn geometry(&self, link: &Link, geometry: &Solid) -> Result<Result<Geometry, mesh::Unread>> {
        let (shape, name, sizes) = match shape_of(self.file, geometry) {
            Ok(shape) => shape,
            Err(unread) => return Ok(Err(unread)),
        };
        if sizes.iter().any(|&size| size < 0.0) {
            return Err(self.text.error("link", &link.name, "collision", format!("{sizes:?}"), "sizes > 0 [m]"));
        }
        let sound = !sizes.contains(&0.0);
        Ok(if sound { Ok(shape) } else { Err((PathBuf::from(name), "sizes > 0 [m]".to_owned())) })
    }
}

/// Motion of a joint about or along its axis by `q` [rad or m].
fn displacement(kind: JointKind, axis: &Unit<Vector3<f64>>, q: f64) -> Isometry3<f64> {
    match kind {
        JointKind::Revolute => {
            Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(axis, q))
        }
        JointKind::Prismatic => Isometry3::from_parts(Translation3::from(**axis * q), UnitQuaternion::identity()),
    }
}

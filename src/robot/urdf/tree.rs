//! Builds the tree: a link becomes a body, or part of the body that it is fixed to.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Unit, Vector3};

use super::{STANDARD_GRAVITY, Urdf, inertia_of, isometry, kind_of, limits_of, mesh};
use crate::error::Result;
use crate::robot::tree::{Body, Geometry, Inertia, Joint, Robot, Shape, UnreadShape};
use crate::units::JointKind;

impl Urdf<'_> {
    /// The tree in which exactly the joints of `moving` move, and the names of the movable joints held at zero.
    ///
    /// # Errors
    /// A joint mimics a moving one, or a moving body has no inertia.
    pub(in crate::robot) fn tree(&self, moving: &BTreeSet<&str>) -> Result<(Robot, Vec<String>)> {
        let mut tree = Robot {
            name: self.robot.name.clone(),
            gravity: STANDARD_GRAVITY,
            base_shapes: Vec::new(),
            unread_shapes: Vec::new(),
            bodies: Vec::new(),
            coupling: None,
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
        self.check_limit(joint)?;
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

    /// Adds the mass and the collision shapes of a link to its body, or to the base.
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

    /// A collision geometry; the inner error is a mesh that was not read, with what was expected of it.
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
}

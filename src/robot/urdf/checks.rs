//! Checks of links and joints beyond syntax: they form a tree of physically possible bodies.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;

use super::text::UrdfText;
use super::{Urdf, inertia_of};
use crate::error::{Error, Place, Result};
use crate::robot::tree::{Inertia, Robot};
use crate::toml_input::nearest;
use crate::units::JointKind;

/// Most collision shapes: a link that is divided into convex parts has some tens.
const MOST_SHAPES: usize = 2000;

/// [kg] Least mass of a moving body, that of a speck of dust.
const LEAST_MASS: f64 = 1e-9;

/// [kg·m²] Least moment of inertia about a joint: that mass at a tenth of a millimetre from the axis.
const LEAST_MOMENT: f64 = 1e-17;

impl Urdf<'_> {
    pub(super) fn check_links(&self) -> Result<()> {
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

    pub(super) fn check_joints(&self) -> Result<()> {
        for joint in &self.robot.joints {
            let refuse =
                |part, value: String, expected: &str| Err(self.text.error("joint", &joint.name, part, value, expected));
            let (lower, upper) = (joint.limit.lower, joint.limit.upper);
            let dynamics = joint.dynamics.clone().unwrap_or_default();
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

    /// Limits the number of collision shapes: the number of pairs to check grows with its square.
    pub(super) fn check_shapes(&self) -> Result<()> {
        let shapes: usize = self.robot.links.iter().map(|link| link.collision.len()).sum();
        if shapes <= MOST_SHAPES {
            return Ok(());
        }
        let expected = format!("at most {MOST_SHAPES} of them; join the parts of a link");
        Err(Error::input(self.text.file(), Place::File, "collision shapes", shapes, expected))
    }

    /// A moving joint that is not continuous needs the limits of its range.
    pub(super) fn check_limit(&self, joint: &urdf_rs::Joint) -> Result<()> {
        let endless = matches!(joint.joint_type, urdf_rs::JointType::Continuous);
        if endless || self.text.has("joint", &joint.name, "limit") {
            return Ok(());
        }
        let expected = "an element <limit> with lower, upper, effort and velocity; a joint that turns without end is of type continuous";
        Err(self.text.error("joint", &joint.name, "limit", "", expected))
    }

    /// Notes on values of the moving joints that are not taken literally: limits of zero, which exporters write for
    /// unknown ones.
    pub(in crate::robot) fn notes(&self, moving: &BTreeSet<&str>) -> Vec<String> {
        let mut notes = Vec::new();
        let moves = |joint: &&urdf_rs::Joint| moving.contains(joint.name.as_str());
        for joint in self.robot.joints.iter().filter(moves) {
            let urdf_rs::JointLimit { lower, upper, effort, velocity, .. } = joint.limit;
            if !self.text.has("joint", &joint.name, "limit") {
                continue;
            }
            let unlimited = [("effort", effort), ("velocity", velocity)].into_iter().filter(|(_, value)| *value == 0.0);
            let mut zero: Vec<&str> = unlimited.map(|(name, _)| name).collect();
            if lower == 0.0 && upper == 0.0 && !matches!(joint.joint_type, urdf_rs::JointType::Continuous) {
                zero.insert(0, "lower and upper");
            }
            if !zero.is_empty() {
                notes.push(format!("joint {}: limit {} of 0 is taken as not given", joint.name, zero.join(" and ")));
            }
        }
        notes
    }

    /// A joint that is held at zero must not mimic a moving joint, nor be offset from zero.
    pub(super) fn check_mimic(&self, joint: &urdf_rs::Joint, moving: &BTreeSet<&str>) -> Result<()> {
        match &joint.mimic {
            Some(mimic) if moving.contains(mimic.joint.as_str()) || mimic.offset.unwrap_or(0.0) != 0.0 => {
                let expected = "a joint of its own; one that mimics a moving joint is not supported";
                Err(self.text.error("joint", &joint.name, "mimic", &mimic.joint, expected))
            }
            _ => Ok(()),
        }
    }

    /// A body that moves needs a mass; the last body of a branch that turns also needs a moment of inertia about its
    /// axis.
    pub(super) fn check_bodies(&self, tree: &Robot) -> Result<()> {
        for (index, body) in tree.bodies.iter().enumerate() {
            let Inertia { mass, .. } = body.inertia;
            if mass < LEAST_MASS {
                let expected =
                    format!("a mass ≥ {LEAST_MASS:e} [kg] of the link that moves and all that is fixed to it");
                return Err(self.text.error("link", &body.name, "mass", mass, expected));
            }
            let axis = body.joint.axis;
            let moment = axis.dot(&(body.inertia.tensor_about(&Vector3::zeros()) * *axis));
            let last = tree.bodies.iter().all(|other| other.parent != Some(index));
            if last && body.joint.kind == JointKind::Revolute && moment < LEAST_MOMENT {
                let axis = &body.joint.name;
                let expected = format!("a moment of inertia ≥ {LEAST_MOMENT:e} [kg·m²] about the axis of joint {axis}");
                return Err(self.text.error("link", &body.name, "inertia", moment, expected));
            }
        }
        Ok(())
    }
}

/// Index of the root link, after a check that all other links hang from it.
pub(super) fn root_of(text: &UrdfText<'_>, robot: &urdf_rs::Robot) -> Result<usize> {
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
        return Err(Error::input(text.file(), Place::File, "links without a joint", names.join(", "), expected));
    };
    // Every link has one parent and there is one root: links that do not hang from the root form a cycle.
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

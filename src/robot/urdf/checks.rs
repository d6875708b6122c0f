//! Checks of links and joints beyond syntax: they form a tree, and the moving joints have limits that make sense.

use std::collections::{BTreeMap, BTreeSet};

use super::Urdf;
use super::description::{Joint, JointType, Robot, bare_link, dynamics_of};
use super::text::UrdfText;
use crate::error::{Error, Place, Result};
use crate::robot::remark::Remark;
use crate::toml_input::nearest;

/// Largest number of collision shapes: a link that is divided into convex parts has a few tens.
const MOST_SHAPES: usize = 2000;

/// Name of the base in files that attach a robot to it without describing it as a link.
const WORLD: &str = "world";

impl Urdf<'_> {
    /// Checks the number of collision shapes: the number of pairs grows with its square.
    pub(super) fn check_shapes(&self) -> Result<()> {
        let shapes: usize = self.robot.links.iter().map(|link| link.collision.len()).sum();
        if shapes <= MOST_SHAPES {
            return Ok(());
        }
        let expected = format!("at most {MOST_SHAPES} of them; join the parts of a link");
        Err(Error::input(self.text.file(), Place::File, "collision shapes", shapes, expected))
    }

    /// Checks limits and dynamics of a joint that moves. Limits that are missing or not plausible count as not given, with a remark:
    /// exporters write 0 and -1 for unknown limits.
    pub(super) fn check_joint(&self, joint: &Joint, remarks: &mut Vec<Remark>) -> Result<()> {
        let refuse =
            |part, value: String, expected: &str| Err(self.text.error("joint", &joint.name, part, value, expected));
        let (damping, friction) = dynamics_of(joint);
        if damping < 0.0 || friction < 0.0 {
            let value = format!("damping {damping}, friction {friction}");
            return refuse("dynamics", value, "damping ≥ 0 and friction ≥ 0");
        }
        let endless = joint.joint_type == JointType::Continuous;
        let mut remark = |text: &str| remarks.push(self.text.remark("joint", &joint.name, "limit", text));
        let owner = self.text.owner("joint", &joint.name);
        let Some(limit) = owner.and_then(|owner| self.text.child(owner, "limit")) else {
            if !endless {
                remark("no <limit>: its range, effort and velocity are taken as unlimited");
            }
            return Ok(());
        };
        let (lower, upper) = (joint.limit.lower, joint.limit.upper);
        if lower > upper && !endless {
            return refuse("limit", format!("lower {lower}, upper {upper}"), "lower ≤ upper");
        }
        let range = (lower == 0.0 && upper == 0.0 && !endless).then_some("lower and upper");
        let which = |what: fn(f64) -> bool| {
            let named = [("effort", joint.limit.effort), ("velocity", joint.limit.velocity)].into_iter();
            named.filter(move |(_, value)| what(*value)).map(|(name, _)| name)
        };
        let zero: Vec<&str> = range.into_iter().chain(which(|value| value == 0.0)).collect();
        if !zero.is_empty() {
            remark(&format!("limit {} of 0 is taken as not given", zero.join(" and ")));
        }
        let negative: Vec<&str> = which(|value| value < 0.0).collect();
        if !negative.is_empty() {
            remark(&format!("limit {} below 0 is taken as not given", negative.join(" and ")));
        }
        let missing: Vec<&str> =
            ["effort", "velocity"].into_iter().filter(|name| limit.given(name).is_none()).collect();
        if !missing.is_empty() {
            remark(&format!("limit without {}: taken as unlimited", missing.join(" and ")));
        }
        Ok(())
    }
}

/// The parent of a joint may be a `world` that is not a link of the file: it is the base, and is added as a link without content.
pub(super) fn with_world(text: &UrdfText<'_>, mut robot: Robot, remarks: &mut Vec<Remark>) -> Robot {
    let known = robot.links.iter().any(|link| link.name == WORLD);
    if let Some(joint) = robot.joints.iter().find(|joint| joint.parent.link == WORLD && !known) {
        let taken = format!("parent {WORLD} is no link of this file and is taken as the base");
        remarks.push(text.remark("joint", &joint.name, "parent", &taken));
        robot.links.push(bare_link(WORLD));
    }
    robot
}

/// Index of the root link, after a check that joints connect all other links to it. Links without any joint are left out, with a remark.
pub(super) fn root_of(text: &UrdfText<'_>, robot: &Robot, remarks: &mut Vec<Remark>) -> Result<usize> {
    let parent = parents(text, robot)?;
    let roots: Vec<usize> = (0..parent.len()).filter(|&link| parent[link].is_none()).collect();
    let carries = |root: &usize| parent.contains(&Some(*root));
    let (carrying, alone): (Vec<usize>, Vec<usize>) = roots.iter().copied().partition(carries);
    let name = |link: usize| robot.links[link].name.as_str();
    let (root, alone) = match (&carrying[..], &alone[..]) {
        ([root], alone) => (*root, alone),
        ([], [root, others @ ..]) => (*root, others),
        ([], []) => {
            let expected = "one link that no joint moves (the base)";
            return Err(Error::input(text.file(), Place::File, "links without a joint", "", expected));
        }
        _ => {
            let names: Vec<&str> = carrying.iter().map(|&link| name(link)).collect();
            let expected = "one link that no joint moves (the base); attach each of the others to it by a fixed joint";
            let second = carrying.get(1).map_or(Place::File, |&link| text.place("link", name(link), ""));
            return Err(Error::input(text.file(), second, "links without a joint", names.join(", "), expected));
        }
    };
    for &link in alone {
        remarks.push(text.remark("link", name(link), "", "no joint attaches it to the robot: it is left out"));
    }
    // Every link has one parent and there is one root: links that are not connected to the root form a cycle.
    for (index, found) in hanging_from(root, &parent).into_iter().enumerate() {
        if !found && !alone.contains(&index) {
            return Err(text.error("link", name(index), "", "", "a link connected to the base, not a closed loop"));
        }
    }
    Ok(root)
}

/// Index of each link's parent.
///
/// # Errors
/// A name occurs twice, a joint names a link that does not exist, or two joints move the same link.
fn parents(text: &UrdfText<'_>, robot: &Robot) -> Result<Vec<Option<usize>>> {
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
            let expected = "a link that no other joint moves";
            return Err(text.error("joint", &joint.name, "child", &joint.child.link, expected));
        }
    }
    Ok(parent)
}

/// Which links are connected to the root.
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

//! Actuators and equalities: what drives a joint, and which joints follow others.
//!
//! ```text
//!   effort limit = |g| · max |forcerange|          g: first number of `gear`; for a `motor` without a force range, its control range
//!   q_1 − q_1ref = a_0 + a_1 (q_2 − q_2ref)        equality of two joints: joint 1 mimics joint 2
//! ```
//! Left out: gains, biases and dynamics of actuators, which belong to a controller; tendons, sites and bodies that they drive; equalities of
//! higher order, and all others.

use std::collections::BTreeMap;

use super::classes::{ACTUATORS, Classes, Item};
use super::compiler::Compiler;
use super::document::Node;
use crate::error::Result;
use crate::robot::remark::Remark;

/// What drives a joint.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Actuated {
    /// [N·m or N] Sum of the limits of its actuators; `None` if one of them has no limit.
    pub effort: Option<f64>,
    /// [1] Largest `|gear|`.
    pub gear: f64,
}

/// The actuators by their joints.
///
/// # Errors
/// A value is not a number.
pub(super) fn actuators(
    root: &Node,
    classes: &Classes,
    compiler: &Compiler,
    remarks: &mut Vec<Remark>,
) -> Result<BTreeMap<String, Actuated>> {
    let mut found: BTreeMap<String, Actuated> = BTreeMap::new();
    let nodes = root.all("actuator").flat_map(|section| &section.children);
    for node in nodes.filter(|node| ACTUATORS.contains(&node.name.as_str())) {
        let item = classes.with(node, None)?;
        let Some(joint) = item.text("joint").or(item.text("jointinparent")) else {
            remarks.push(node.remark("it drives no single joint and is not taken"));
            continue;
        };
        let gear = item.numbers("gear", 1, 6)?.and_then(|gear| gear.first().copied()).unwrap_or(1.0).abs();
        let own = effort(&item, compiler)?.map(|force| force * gear);
        let before = found.get(joint).copied();
        let effort = match (before, own) {
            (None, own) => own,
            (Some(before), Some(own)) => before.effort.map(|effort| effort + own),
            (Some(_), None) => None,
        };
        found.insert(joint.to_owned(), Actuated { effort, gear: gear.max(before.map_or(0.0, |before| before.gear)) });
    }
    Ok(found)
}

/// [N·m or N] Largest force of an actuator before its gear.
fn effort(item: &Item<'_>, compiler: &Compiler) -> Result<Option<f64>> {
    let largest = |range: [f64; 2]| range[0].abs().max(range[1].abs());
    if let Some(range) = limited(item, compiler, "forcerange", "forcelimited")? {
        return Ok(Some(largest(range)));
    }
    let is_force = match item.node.name.as_str() {
        "motor" => Some(1.0),
        "general"
            if item.text("biastype").is_none_or(|word| word == "none")
                && item.text("gaintype").is_none_or(|word| word == "fixed") =>
        {
            Some(item.numbers("gainprm", 1, 10)?.and_then(|gains| gains.first().copied()).unwrap_or(1.0))
        }
        _ => None,
    };
    let Some(gain) = is_force else { return Ok(None) };
    Ok(limited(item, compiler, "ctrlrange", "ctrllimited")?.map(|range| largest(range) * gain.abs()))
}

/// A range that acts as a limit; `None` for one that does not.
///
/// # Errors
/// The range is not two numbers.
pub(super) fn limited(item: &Item<'_>, compiler: &Compiler, range: &str, switch: &str) -> Result<Option<[f64; 2]>> {
    let on = item.switch(switch)?.unwrap_or(compiler.autolimits);
    Ok(item.array::<2>(range)?.filter(|_| on))
}

/// A joint that follows another one.
#[derive(Debug, Clone)]
pub(super) struct Mimic {
    pub other: String,
    /// `a_0`, `a_1`.
    pub polynomial: [f64; 2],
}

/// Joints that follow others, by their names.
///
/// # Errors
/// A value is not a number.
pub(super) fn mimics(root: &Node, classes: &Classes, remarks: &mut Vec<Remark>) -> Result<BTreeMap<String, Mimic>> {
    let mut found = BTreeMap::new();
    for node in root.all("equality").flat_map(|section| &section.children) {
        let item = classes.with(node, None)?;
        if item.text("active") == Some("false") {
            continue;
        }
        let coefficients = item.numbers("polycoef", 1, 5)?.unwrap_or_else(|| vec![0.0, 1.0]);
        let linear = coefficients.iter().skip(2).all(|higher| *higher == 0.0);
        match (node.name.as_str(), item.text("joint1"), item.text("joint2")) {
            ("joint", Some(joint), Some(other)) if linear && joint != other => {
                let polynomial = [0, 1].map(|k| coefficients.get(k).copied().unwrap_or_default());
                found.insert(joint.to_owned(), Mimic { other: other.to_owned(), polynomial });
            }
            _ => remarks.push(node.remark("this equality is not taken: the bodies move as if it were not there")),
        }
    }
    Ok(found)
}

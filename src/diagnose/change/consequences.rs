//! Changes that follow from a new effect and are none of their own.
//!
//! ```text
//!   torque_constant_error e     F/(1 + e): friction, computed from the current with the nominal constant, changes by −e/(1 + e)
//!   payload m at d              I ≤ |m| d²: the load's own inertia, which a point mass does not have, adds to that of each wrist
//! ```
//! The column of a wrong torque constant contains the rigid body's torque, since both recordings share their friction. A body that is mounted at the
//! origin of its link has a radius of gyration of at most the distance `d` of its centre.

use crate::diagnose::fit::cause::changed;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::result::{Change, FoundEffect, Parts, Withdrawn};
use crate::distributions::NORMAL_975;

/// Quantities of friction, which a torque constant scales.
const FRICTION: [&str; 3] = ["coulomb", "breakaway", "viscous"];

/// Takes the changes that new effects explain out of `changes`, and lists them as withdrawn.
pub fn withdraw(parts: &mut Parts, problem: &Problem, changes: &mut Vec<Change>) {
    let findings = &mut parts.findings;
    changes.retain(|change| {
        let Some(reason) = findings.effects.iter().find_map(|effect| explained(problem, effect, change)) else {
            return true;
        };
        let (effect, joints) = (format!("change of {}", change.quantity), vec![change.joint.clone()]);
        findings.withdrawn.push(Withdrawn { effect, joints, reason });
        false
    });
}

/// Why a change follows from an effect, if it does.
fn explained(problem: &Problem, effect: &FoundEffect, change: &Change) -> Option<String> {
    let value = |name: &str| effect.parameters.get(name).map_or(0.0, |measured| measured.value);
    let seen = 0.01 * change.change_percent.value;
    let error = 0.01 * NORMAL_975 * change.change_percent.std_error;
    let joint = problem.motion.model.joints.iter().find(|joint| joint.name == change.joint)?;
    match changed(&effect.effect)? {
        "torque_constant_error" => {
            let applies = effect.joints.contains(&change.joint) && FRICTION.contains(&change.quantity.as_str());
            let apparent = 1.0 / (1.0 + value("error")) - 1.0;
            let words = || {
                format!("friction seems to change by {:.1} % where the torque constant has changed", 100.0 * apparent)
            };
            (applies && (seen - apparent).abs() < error).then(words)
        }
        "payload" => {
            let applies = effect.joints.contains(&change.joint) && change.quantity == "rotor_inertia";
            let distance = ["x", "y", "z"].map(value).iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
            let (mass, own) = (value("mass"), joint.reflected_inertia());
            let most = mass.abs() * distance * distance;
            let words = || format!("the load's own inertia, up to {most:.2e} kg·m², explains it");
            (applies && mass * seen > 0.0 && own * (seen.abs() - error) < most).then(words)
        }
        _ => None,
    }
}

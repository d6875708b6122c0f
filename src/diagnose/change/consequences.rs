//! Changes that follow from a new effect and are none of their own.
//!
//! ```text
//!   torque_constant_error e     F/(1 + e): friction, computed from the current with the nominal constant, changes by −e/(1 + e)
//!   payload m at d              I ≤ |m| d²: what is left of the load's own inertia adds to that of each wrist
//! ```
//! The column of a wrong torque constant contains the rigid body's torque, since both recordings share their friction. A body that is mounted at the
//! origin of its link has a radius of gyration of at most the distance `d` of its centre.

use crate::diagnose::fit::cause::changed;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::result::{Change, FoundEffect, Parts, Withdrawn};
use crate::distributions::NORMAL_975;
use crate::robot::JointModel;

/// Quantities of friction, which a torque constant scales.
const FRICTION: [&str; 3] = ["coulomb", "breakaway", "viscous"];

/// Takes the changes that new effects explain out of `changes`, and lists them as withdrawn.
pub fn withdraw(parts: &mut Parts, problem: &Problem, changes: &mut Vec<Change>) {
    let findings = &mut parts.findings;
    changes.retain(|change| {
        let joint = problem.motion.model.joints.iter().find(|joint| joint.name == change.joint);
        let rotor = joint.map_or(0.0, JointModel::reflected_inertia);
        let Some(reason) = findings.effects.iter().find_map(|effect| explained(effect, change, rotor)) else {
            return true;
        };
        let (effect, joints) = (format!("change of {}", change.quantity), vec![change.joint.clone()]);
        findings.withdrawn.push(Withdrawn { effect, joints, reason });
        false
    });
}

/// Why a change follows from an effect, if it does; `rotor` [kg·m² or kg]: the rotor's inertia at the joint.
fn explained(effect: &FoundEffect, change: &Change, rotor: f64) -> Option<String> {
    let value = |name: &str| effect.parameters.get(name).map_or(0.0, |measured| measured.value);
    let seen = 0.01 * change.change_percent.value;
    let error = 0.01 * NORMAL_975 * change.change_percent.std_error;
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
            let mass = value("mass");
            let most = mass.abs() * distance * distance;
            let words = || format!("the load's own inertia, up to {most:.2e} kg·m², explains it");
            (applies && mass * seen > 0.0 && rotor * (seen.abs() - error) < most).then(words)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::fit::cause::change_of;
    use crate::diagnose::result::{EffectGain, Measured, Standing};
    use crate::effects::find;

    fn measured(value: f64, std_error: f64) -> Measured {
        Measured { value, std_error, unit: "" }
    }

    fn new(effect: &str, values: &[(&str, f64)]) -> FoundEffect {
        let gain = EffectGain {
            gain_percent: 50.0,
            gain_interval_percent: [40.0, 60.0],
            gain_of: String::new(),
            gain_by_joint: Default::default(),
        };
        let standing = Standing { probability: 0.9, evidence_nats: 100.0, gain };
        let parameters = values.iter().map(|(name, value)| ((*name).to_owned(), measured(*value, 0.0))).collect();
        let about = find(effect).expect("of the catalogue").about();
        FoundEffect { effect: change_of(effect), ..FoundEffect::new(about, vec!["j".to_owned()], parameters, standing) }
    }

    fn change(quantity: &str, joint: &str, [percent, error]: [f64; 2]) -> Change {
        Change {
            quantity: quantity.to_owned(),
            joint: joint.to_owned(),
            reference: measured(1.0, 0.0),
            now: measured(1.0 + 0.01 * percent, 0.0),
            change_percent: measured(percent, error),
            standing: 5.0,
            probability: 0.9,
        }
    }

    /// A constant 6 % smaller lets friction seem 1/0.94 = 6.4 % larger.
    #[test]
    fn analytic_friction_that_a_torque_constant_scales_has_not_changed() {
        let constant = new("torque_constant_error", &[("error", -0.06)]);
        let said = |quantity: &str, joint: &str, size: [f64; 2]| {
            explained(&constant, &change(quantity, joint, size), 1.0).is_some()
        };
        assert!(said("coulomb", "j", [7.5, 1.7]) && said("viscous", "j", [6.4, 0.1]));
        // Another size, another sign, another joint, another quantity.
        assert!(!said("coulomb", "j", [12.0, 1.7]) && !said("coulomb", "j", [-6.4, 1.7]));
        assert!(!said("coulomb", "i", [6.4, 1.7]) && !said("rotor_inertia", "j", [6.4, 1.7]));
    }

    /// 0.6 kg at 0.08 m has an inertia of its own of at most 3.84e-3 kg·m²: 19 % of a rotor of 0.02 kg·m².
    #[test]
    fn analytic_a_rotor_is_no_heavier_by_what_a_load_turns() {
        let load = new("payload", &[("mass", 0.6), ("y", 0.08)]);
        let said = |size: [f64; 2]| explained(&load, &change("rotor_inertia", "j", size), 0.02).is_some();
        assert!(said([12.7, 2.8]) && said([19.0, 0.1]));
        assert!(!said([25.0, 1.0]) && !said([-12.7, 2.8]), "too much, and the other sign");
    }
}

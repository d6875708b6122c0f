//! Dry friction differs between the two directions of motion.
//!
//! `F_C, F_S → F_C (1 ± a), F_S (1 ± a)`: `+` for v > 0, `−` for v < 0.
//! While the joint moves, the motor has to add `a · F_dry(v)` to the symmetric law, with the same sign in both directions;
//! at rest it has to add nothing. The Stribeck part is asymmetric too, unlike a constant offset.
//! Left out: a difference between the Stribeck velocities.
//! Reference: B. Armstrong-Hélouvry (1991), Control of Machines with Friction, ch. 4.

use std::collections::BTreeMap;

use super::parameters::{need_friction, need_joint};
use super::{About, Action, Diagnosable, Effect, Experiment, Kind, Motion, ParameterSpec, Parameters, Scope};
use crate::error::Result;
use crate::gearhead::FrictionLaw;
use crate::robot::Model;

static ABOUT: About = About {
    name: "coulomb_asymmetry",
    summary: "Dry friction differs between the two directions of motion.",
    equation: "F_C, F_S → F_C (1 ± a), F_S (1 ± a): + for v > 0, − for v < 0",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[ParameterSpec::new(
        "asymmetry",
        "a",
        "1",
        "relative difference of dry friction from the mean of both directions, positive where it is larger for v > 0",
    )
    .between(-0.95, 0.95)],
    signature: "a torque of one sign while the joint moves, the same at all speeds but for the Stribeck part; nothing at rest",
    look_alikes: &["current_offset", "base_tilt", "cable_spring", "viscous_asymmetry"],
    separate_by: "record the current while the joint rests unloaded: an offset stays, an asymmetry does not; and move slowly, where the Stribeck part differs",
    reference: "B. Armstrong-Hélouvry (1991), Control of Machines with Friction, ch. 4",
};

/// Dry friction differs between the two directions of motion.
pub struct CoulombAsymmetry;

impl Effect for CoulombAsymmetry {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let a = Parameters::check(&ABOUT, model, given)?.get("asymmetry");
        let joint = need_joint(&ABOUT, model, joint)?;
        match &mut need_friction(&ABOUT, model, joint)?.law {
            FrictionLaw::Exponential(law) => {
                for (side, sign) in law.iter_mut().zip([1.0, -1.0]) {
                    side.coulomb *= 1.0 + sign * a;
                    side.breakaway *= 1.0 + sign * a;
                }
            }
            FrictionLaw::TwoLines(law) => {
                // Dry part of a law with two lines: both offsets, and the part of the first slope above the second.
                for (side, sign) in law.iter_mut().zip([1.0, -1.0]) {
                    side.a1 *= 1.0 + sign * a;
                    side.a2 *= 1.0 + sign * a;
                    side.b1 = side.b2 + (side.b1 - side.b2) * (1.0 + sign * a);
                }
            }
        }
        Ok(Vec::new())
    }

    fn shown_by(&self) -> &'static [Experiment] {
        &[Experiment::AtRest, Experiment::SlowSteps]
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for CoulombAsymmetry {
    /// Dry friction rises towards rest or not at all. A fit without the asymmetry can give a law that falls there, which stands for what it lacks.
    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        vec![motion.column(joint, |m, row| m.friction.dry(m.v[row]).max(m.friction.coulomb) * m.direction[row].abs())]
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0]]
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::effects::SymmetricFriction;
    use crate::effects::drawn::{LENGTH, MODEL, ROBOT, drawn};

    /// With `F_S > F_C` the torque is `F_dry(v)` wherever the joint moves, with `F_S < F_C` it is `F_C`.
    #[test]
    fn analytic_the_torque_follows_a_law_that_rises_towards_rest_alone() {
        let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a model");
        let mut motion = drawn(&model, 1, None, LENGTH);
        let column = |motion: &Motion| CoulombAsymmetry.columns(motion, 0, &[]).swap_remove(0);
        for breakaway in [3.0, 0.5] {
            let law = SymmetricFriction { coulomb: 1.0, breakaway, stribeck_velocity: 0.1, viscous: 2.0 };
            motion.joints[0].friction = law;
            let m = &motion.joints[0];
            let expected = |row: usize| {
                let falling = (breakaway - 1.0) * (-m.v[row].abs() / 0.1).exp();
                (1.0 + falling.max(0.0)) * m.direction[row].abs()
            };
            for (row, found) in column(&motion).into_iter().enumerate() {
                // Rounding.
                assert!((found - expected(row)).abs() < 1e-12, "{breakaway} {row}: {found}");
            }
        }
    }
}

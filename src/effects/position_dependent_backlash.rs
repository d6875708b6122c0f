//! The gap between the flanks varies with the angle: by wear where the joint works most, or by an eccentric gear.
//!
//! `b → b + a cos(n θ + φ)`, `n` periods per turn of the joint, never below zero. The flanks are at `± b(θ)/2`; because of their slope, the
//! torque `T` of a flank takes `T (1 ∓ b'(θ)/2)` from the rotor.
//! `θ` is the rotor's angle; the link's differs from it by the gap.
//! A diagnosis identifies it with a second encoder behind the gear, which shows `± b(θ)/2` on the flanks. With the motor's side
//! alone, single reversals of fast motion give the gap to 0.2 to 1 mrad on some machines, and with an error of its full size on others
//! (seeds 11 to 14 of the draw in `tests/gaps`, with friction and its share behind the gear known): the regression does not identify it there. `diagnose --judge` seeks it
//! by the score of every sample (`likelihood::uneven`).
//! Left out: other harmonics (each is a separate effect).
//! Reference: M. Nordin, P.-O. Gutman (2002), Controlling mechanical systems with backlash, a survey.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::parameters::{misfit, need_joint};
use super::{About, Action, Claim, Effect, GearAction, Kind, ParameterSpec, Parameters, Phenomenon, Scope};
use crate::error::Result;
use crate::gearhead::Mesh;
use crate::robot::Model;

static ABOUT: About = About {
    name: "position_dependent_backlash",
    summary: "The gap between the flanks of the gear varies with the angle.",
    equation: "b → b + a cos(n θ + φ)",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("amplitude", "a", "rad (joint)", "amplitude of the total gap, at most the gap itself")
            .between(0.0, 1.0),
        ParameterSpec::new("order", "n", "1", "periods per turn of the joint").between(0.0, 1000.0),
        ParameterSpec::new("phase", "φ", "rad", "phase at θ = 0").between(-TAU, TAU).or(0.0),
    ],
    signature: "the distance that the rotor moves through the gap at a reversal depends on where it reverses",
    look_alikes: &["coupling_slip", "position_dependent_friction", "joint_compliance"],
    separate_by: "a second encoder behind the gear, and reversals at many angles, each several times",
    reference: "M. Nordin, P.-O. Gutman (2002), Controlling mechanical systems with backlash, a survey",
};

/// The gap varies with the angle.
pub struct PositionDependentBacklash;

struct UnevenGap {
    amplitude: f64,
    order: f64,
    phase: f64,
}

impl GearAction for UnevenGap {
    fn alter(&self, _time: f64, theta: f64, mesh: &mut Mesh) {
        let (sin, cos) = (self.order * theta + self.phase).sin_cos();
        mesh.half_gap += 0.5 * self.amplitude * cos;
        mesh.half_gap_slope -= 0.5 * self.amplitude * self.order * sin;
    }

    fn fastest(&self, speed: f64) -> f64 {
        self.order * speed
    }
}

impl Effect for PositionDependentBacklash {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        let (amplitude, order) = (given.get("amplitude"), given.get("order"));
        let gap = model.joints[joint].backlash.unwrap_or(0.0);
        if amplitude > gap {
            let name = &model.joints[joint].name;
            let expected = format!("at most the gap, joints.{name}.backlash = {gap}");
            return Err(misfit(&ABOUT, model, "amplitude", amplitude, expected));
        }
        if 0.5 * amplitude * order >= 1.0 {
            let expected = format!("less than 2/order = {:.3e}, or the flanks would turn back", 2.0 / order);
            return Err(misfit(&ABOUT, model, "amplitude", amplitude, expected));
        }
        Ok(vec![Action::Gear(joint, Box::new(UnevenGap { amplitude, order, phase: given.get("phase") }))])
    }

    fn claims(&self, phenomenon: &Phenomenon) -> Option<Claim> {
        match phenomenon {
            Phenomenon::UnevenGap { amplitude, order, phase } => {
                Some(vec![("amplitude", *amplitude), ("order", *order), ("phase", *phase)])
            }
            _ => None,
        }
    }
}

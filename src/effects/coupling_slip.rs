//! A coupling slips once: from then on the link is displaced against the rotor.
//!
//! ```text
//!   q = θ + ε(t) without torque,   ε = δ s((t − t0)/D),   s(x) = 6x⁵ − 15x⁴ + 10x³ from 0 to 1, constant outside
//! ```
//! The jump is a smooth ramp over the short time `D`, so that the transient of rotor and link is that of the machine. The work of the
//! coupling, `T ε̇`, is counted: it is negative where the coupling yields.
//! Left out: the torque at which a real coupling slips; here it slips at a given time.
//! Reference: M. Nordin, P.-O. Gutman (2002), Controlling mechanical systems with backlash, a survey, for rotor and link as two masses.

use std::collections::BTreeMap;

use super::parameters::need_joint;
use super::{About, Action, Claim, Effect, GearAction, Kind, ParameterSpec, Parameters, Phenomenon, Scope};
use crate::error::Result;
use crate::gearhead::Mesh;
use crate::robot::Model;

static ABOUT: About = About {
    name: "coupling_slip",
    summary: "A coupling between motor and link slips once.",
    equation: "q = θ + δ for t > t0, without torque",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("jump", "δ", "rad (joint)", "angle by which the link is ahead of the rotor afterwards")
            .between(-10.0, 10.0),
        ParameterSpec::new("time", "t0", "s", "time at which the slip begins, since the start of the session")
            .between(0.0, 1e7),
        ParameterSpec::new("duration", "D", "s", "duration of the slip").between(1e-3, 10.0).or(0.01),
    ],
    signature: "a transient of the current at one time; from then on a known contact or gravity is met at another motor angle",
    look_alikes: &["position_dependent_backlash", "external_contact"],
    separate_by: "return to the same pose afterwards: a slip persists, a knock from outside does not",
    reference: "M. Nordin, P.-O. Gutman (2002), Controlling mechanical systems with backlash, a survey, for rotor and link as two masses",
};

/// A coupling slips once.
pub struct CouplingSlip;

struct Slip {
    jump: f64,
    start: f64,
    duration: f64,
}

impl GearAction for Slip {
    fn alter(&self, time: f64, _theta: f64, mesh: &mut Mesh) {
        let x = ((time - self.start) / self.duration).clamp(0.0, 1.0);
        mesh.offset += self.jump * x * x * x * (10.0 + x * (6.0 * x - 15.0));
        mesh.offset_rate += self.jump / self.duration * 30.0 * x * x * (1.0 - x) * (1.0 - x);
    }
}

impl Effect for CouplingSlip {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        let slip = Slip { jump: given.get("jump"), start: given.get("time"), duration: given.get("duration") };
        Ok(vec![Action::Gear(joint, Box::new(slip))])
    }

    fn claims(&self, phenomenon: &Phenomenon) -> Option<Claim> {
        match phenomenon {
            Phenomenon::Step { jump, time } => Some(vec![("jump", *jump), ("time", *time)]),
            _ => None,
        }
    }
}

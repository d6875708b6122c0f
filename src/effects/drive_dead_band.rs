//! The power stage gives no current for a small command: the dead time of the bridge clamps the current at zero.
//!
//! `i_cmd → 0` for `|i_cmd| < u0`, unchanged beyond: above the clamp the current loop compensates the loss.
//! Only the command shows it: the current that flows moves the joint like any current, so torque against motion shows nothing.
//! Left out: the transition, which in a real bridge depends on the ripple of the current.
//! Reference: J.-W. Choi, S.-K. Sul (1996), Inverter output voltage synthesis using novel dead time compensation.

use std::collections::BTreeMap;

use super::parameters::need_joint;
use super::{About, Action, Claim, DriveAction, Effect, Kind, ParameterSpec, Parameters, Phenomenon, Scope};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "drive_dead_band",
    summary: "The power stage gives no current for a small command.",
    equation: "i_cmd → 0 for |i_cmd| < u0",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[ParameterSpec::new("width", "u0", "A", "command below which no current flows").between(0.0, 1e5)],
    signature: "no current flows while the controller commands a small one",
    look_alikes: &["coulomb_asymmetry", "dwell_stiction", "current_offset"],
    separate_by: "record the command beside the current, and hold small commands of either sign",
    reference: "J.-W. Choi, S.-K. Sul (1996), Inverter output voltage synthesis using novel dead time compensation",
};

/// No current for a small command.
pub struct DriveDeadBand;

struct DeadBand(f64);

impl DriveAction for DeadBand {
    fn command(&self, command: f64) -> f64 {
        if command.abs() < self.0 { 0.0 } else { command }
    }
}

impl Effect for DriveDeadBand {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let u0 = Parameters::check(&ABOUT, model, given)?.get("width");
        Ok(vec![Action::Drive(need_joint(&ABOUT, model, joint)?, Box::new(DeadBand(u0)))])
    }

    fn claims(&self, phenomenon: &Phenomenon) -> Option<Claim> {
        match phenomenon {
            Phenomenon::DeadBand { width } => Some(vec![("width", *width)]),
            _ => None,
        }
    }
}

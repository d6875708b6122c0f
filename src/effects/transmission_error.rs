//! The link does not follow the rotor evenly: teeth that are not in their place.
//!
//! `q = θ + e sin(z θ + φ)` for a gear without torque, `z` periods a turn of the joint. At a constant rotor speed `ω` the link's velocity
//! ripples by `e z ω` and its acceleration by `e z² ω²`: the torque at tooth order grows with the square of speed. The torque `T` on
//! the link takes `T (1 + e z cos(z θ + φ))` of the rotor: no work is lost.
//! Left out: other harmonics (each is an effect of its own), tooth stiffness that varies with the same order.
//! Reference: J. D. Smith (2003), Gear Noise and Vibration; F. H. Ghorbel, P. S. Gandhi, F. Alpeter (2001), On the kinematic error in
//! harmonic drive gears.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::parameters::{misfit, need_joint};
use super::{About, Action, Effect, GearAction, Kind, ParameterSpec, Parameters, Scope};
use crate::error::Result;
use crate::gearhead::Mesh;
use crate::robot::Model;

static ABOUT: About = About {
    name: "transmission_error",
    summary: "The link leads and lags the rotor periodically: teeth are not in their place.",
    equation: "q = θ + e sin(z θ + φ) without torque",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("amplitude", "e", "rad (joint)", "amplitude at the joint").at_least(0.0),
        ParameterSpec::new("teeth", "z", "1", "periods per turn of the joint").between(0.0, 10_000.0),
        ParameterSpec::new("phase", "φ", "rad", "phase at θ = 0").between(-TAU, TAU).or(0.0),
    ],
    signature: "a ripple at tooth order that grows with the square of speed",
    look_alikes: &["cogging", "torque_ripple", "position_dependent_friction"],
    separate_by: "several speeds: the torque of cogging stays, that of the teeth grows with the square of speed",
    reference: "J. D. Smith (2003), Gear Noise and Vibration",
};

/// The link leads and lags the rotor.
pub struct TransmissionError;

struct Teeth {
    amplitude: f64,
    teeth: f64,
    phase: f64,
}

impl GearAction for Teeth {
    fn alter(&self, _time: f64, theta: f64, mesh: &mut Mesh) {
        let (sin, cos) = (self.teeth * theta + self.phase).sin_cos();
        mesh.offset += self.amplitude * sin;
        mesh.offset_slope += self.amplitude * self.teeth * cos;
    }

    fn fastest(&self, speed: f64) -> f64 {
        self.teeth * speed
    }
}

impl Effect for TransmissionError {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        let (amplitude, teeth) = (given.get("amplitude"), given.get("teeth"));
        if amplitude * teeth >= 1.0 {
            let expected = format!("less than 1/teeth = {:.3e}, or the link would turn back", 1.0 / teeth);
            return Err(misfit(&ABOUT, model, "amplitude", amplitude, expected));
        }
        Ok(vec![Action::Gear(joint, Box::new(Teeth { amplitude, teeth, phase: given.get("phase") }))])
    }
}

//! The encoder's disc runs out: it sees the shaft lead and lag once a turn.
//!
//! The encoder sees `θ + e sin(θ_m + φ)`, `θ_m = ratio · θ` the angle of the motor shaft, and counts that: position and velocity
//! are read with it, by the controller too. At a constant speed the velocity read ripples by `e · ratio · θ̇`; a controller that
//! believes it makes the motor follow. A link encoder is not touched.
//! Left out: other harmonics, such as two a turn of a tilted disc.
//! Reference: R. C. Kavanagh (2001), Performance analysis and compensation of M/T-type digital tachometers.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::parameters::{misfit, need_joint};
use super::{About, Action, Effect, EncoderAction, Kind, ParameterSpec, Parameters, Scope};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "encoder_eccentricity",
    summary: "The encoder's disc runs out: it sees the shaft lead and lag once a turn.",
    equation: "θ → θ + e sin(θ_m + φ), read by the controller too",
    kind: Kind::Measurement,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new(
            "amplitude",
            "e",
            "rad (joint)",
            "amplitude at the joint, that at the shaft divided by the ratio",
        )
        .at_least(0.0),
        ParameterSpec::new("phase", "φ", "rad", "phase at θ_m = 0").between(-TAU, TAU).or(0.0),
    ],
    signature: "a ripple of velocity once a motor turn, in proportion to speed, and no torque of its own",
    look_alikes: &["cogging", "transmission_error", "torque_ripple"],
    separate_by: "several speeds: the angle by which position runs out stays, the torque of cogging stays",
    reference: "R. C. Kavanagh (2001), Performance analysis and compensation of M/T-type digital tachometers",
};

/// The encoder's disc runs out.
pub struct EncoderEccentricity;

struct RunOut {
    amplitude: f64,
    gear_ratio: f64,
    phase: f64,
}

impl EncoderAction for RunOut {
    fn seen(&self, position: f64, velocity: f64) -> (f64, f64) {
        let (sin, cos) = (self.gear_ratio * position + self.phase).sin_cos();
        (position + self.amplitude * sin, velocity * (1.0 + self.amplitude * self.gear_ratio * cos))
    }
}

impl Effect for EncoderEccentricity {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        let (amplitude, gear_ratio) = (given.get("amplitude"), model.joints[joint].gear_ratio);
        if amplitude * gear_ratio >= 1.0 {
            let expected =
                format!("less than 1/gear_ratio = {:.3e}, or the encoder would count back", 1.0 / gear_ratio);
            return Err(misfit(&ABOUT, model, "amplitude", amplitude, expected));
        }
        Ok(vec![Action::Encoder(joint, Box::new(RunOut { amplitude, gear_ratio, phase: given.get("phase") }))])
    }
}

//! The encoder's disc has runout: its reading leads and lags the shaft once per turn.
//!
//! The encoder reads `θ + e sin(θ_m + φ)`, `θ_m = ratio · θ` the angle of the motor shaft, and counts that. Position and velocity
//! contain the error, for the controller too. At a constant speed the velocity reading ripples by `e · ratio · θ̇`, and the controller
//! makes the motor follow this ripple. A link encoder is not affected.
//!
//! A torque computed from this reading contains the torque of the ripple, which was not applied: with `s = sin(θ_m + φ)` the
//! motor torque lacks `e ((J + M) s̈ + F_V ṡ)`, `J` the rotor's and `M` the links' inertia at the joint.
//! Left out: the torque of that ripple on other joints; other harmonics, such as two per turn of a tilted disc.
//! Reference: R. C. Kavanagh (2001), Performance analysis and compensation of M/T-type digital tachometers.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::parameters::{misfit, need_joint};
use super::{
    About, Action, Diagnosable, Effect, EncoderAction, Harmonic, Kind, Motion, ParameterSpec, Parameters, Scope,
};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "encoder_eccentricity",
    summary: "The encoder's disc has runout: its reading leads and lags the shaft once per turn.",
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
        .between(0.0, 1.0),
        ParameterSpec::new("phase", "φ", "rad", "phase at θ_m = 0").between(-TAU, TAU).or(0.0),
    ],
    signature: "a ripple of velocity once per motor turn, in proportion to speed, and no torque of its own",
    look_alikes: &["cogging", "transmission_error", "torque_ripple"],
    separate_by: "several speeds: runout keeps the amplitude of its angle error, cogging keeps the amplitude of its torque",
    reference: "R. C. Kavanagh (2001), Performance analysis and compensation of M/T-type digital tachometers",
};

/// The encoder's disc has runout.
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
    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

/// Columns of a line at an order [1/turn].
fn columns_at(motion: &Motion, joint: usize, order: f64) -> Vec<Vec<f64>> {
    let (m, model) = (&motion.joints[joint], &motion.model.joints[joint]);
    let missing = |row: usize| {
        let inertia = model.reflected_inertia() + m.link_inertia[row];
        let [rate, curvature] = motion.harmonic_rates(joint, row, order);
        [0, 1].map(|k| -inertia * curvature[k] - m.friction.viscous * rate[k])
    };
    let rows: Vec<[f64; 2]> = (0..motion.rows()).map(missing).collect();
    [0, 1].map(|k| rows.iter().map(|row| row[k]).collect()).into()
}

impl Diagnosable for EncoderEccentricity {
    fn applies(&self, motion: &Motion, joint: usize) -> bool {
        motion.range(joint) * motion.model.joints[joint].gear_ratio > TAU
    }

    fn harmonic(&self) -> Option<Harmonic> {
        Some(Harmonic {
            order: |motion, joint, _| motion.model.joints[joint].gear_ratio,
            several: false,
            in_narrow_rows: Some(columns_at),
        })
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        columns_at(motion, joint, motion.model.joints[joint].gear_ratio)
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        // e sin(x + φ) = e sin φ · cos x + e cos φ · sin x
        vec![coefficients[0].hypot(coefficients[1]), coefficients[0].atan2(coefficients[1])]
    }
}

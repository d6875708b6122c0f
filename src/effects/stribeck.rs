//! Friction falls with speed before it rises: the part that a Coulomb and viscous law lacks.
//!
//! `F(v) = (F_C + (F_S − F_C) e^{−|v|/v_S}) sgn v + F_V v`, equation 6; the nominal law has `F_S = F_C`.
//! It is a candidate only if the model file gives a law without it; if friction is unknown, it is part of the baseline.
//! Left out: the lag of friction behind velocity (presliding).
//! Reference: L. Márton, B. Lantos (2009), equation 6.

use std::collections::BTreeMap;

use super::falling::falling;
use super::parameters::{need_friction, need_joint};
use super::{About, Action, Diagnosable, Effect, Kind, Motion, ParameterSpec, Parameters, Scope};
use crate::error::{Error, Place, Result};
use crate::gearhead::FrictionLaw;
use crate::robot::Model;

static ABOUT: About = About {
    name: "stribeck",
    summary: "Friction falls with speed before it rises, which the nominal law lacks.",
    equation: "F(v) = (F_C + (F_S − F_C) e^{−|v|/v_S}) sgn v + F_V v",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("breakaway", "F_S", "N·m", "friction at the onset of motion").between(0.0, 1e7),
        ParameterSpec::new("stribeck_velocity", "v_S", "rad/s", "speed over which friction falls from F_S towards F_C")
            .between(1e-9, 1e4),
    ],
    signature: "a peak of friction below a low speed, in both directions alike",
    look_alikes: &["viscous_asymmetry", "load_dependent_friction"],
    separate_by: "slow constant speeds, several below the Stribeck velocity",
    reference: "L. Márton, B. Lantos (2009), equation 6",
};

/// Slowest Stribeck velocity that is tried, relative to the fastest motion: a slower one is only breakaway at rest.
const SLOWEST: f64 = 1e-5;

/// The falling part of the friction law.
pub struct Stribeck;

impl Effect for Stribeck {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        let source = model.source.clone();
        match &mut need_friction(&ABOUT, model, joint)?.law {
            FrictionLaw::Exponential(law) => {
                for side in law {
                    side.breakaway = given.get("breakaway");
                    side.stribeck_velocity = given.get("stribeck_velocity");
                }
                Ok(Vec::new())
            }
            FrictionLaw::TwoLines(_) => Err(Error::input(
                &source,
                Place::File,
                "effects.stribeck",
                "two lines",
                "the friction law of equation 6: two lines contain the falling part already",
            )),
        }
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

/// Least fall relative to Coulomb friction: growth of friction at rest leaves a fall of 3 % at slow speeds (tuning seed 3401), a removed
/// disturbance no more (4602).
const LEAST_FALL: f64 = 0.05;

impl Diagnosable for Stribeck {
    fn applies(&self, motion: &Motion, joint: usize) -> bool {
        match motion.model.joints[joint].friction.map(|friction| friction.law) {
            // A law without the falling part has F_S = F_C up to rounding.
            Some(FrictionLaw::Exponential(law)) => law.iter().all(|side| side.breakaway <= side.coulomb * (1.0 + 1e-9)),
            Some(FrictionLaw::TwoLines(_)) | None => false,
        }
    }

    fn shapes(&self, motion: &Motion, joint: usize) -> Vec<Vec<f64>> {
        let mut speeds: Vec<f64> = motion.joints[joint].v.iter().map(|v| v.abs()).collect();
        let directions = &motion.joints[joint].direction;
        let mut moving = directions.iter().map(|direction| *direction != 0.0);
        speeds.retain(|_| moving.next().unwrap_or(false));
        speeds.sort_by(f64::total_cmp);
        let (Some(fastest), Some(slow)) = (speeds.last(), speeds.get(speeds.len() / 20)) else { return Vec::new() };
        // From the speed that one twentieth of the motion is below, so that the fall is visible, to half of the largest speed.
        let mut shapes = Vec::new();
        let mut v_s = slow.max(SLOWEST * fastest);
        while v_s < 0.5 * fastest {
            shapes.push(vec![v_s]);
            v_s *= 1.4;
        }
        shapes
    }

    fn is_itself(&self, motion: &Motion, joint: usize, _shape: &[f64], coefficients: &[f64]) -> bool {
        coefficients[0] > LEAST_FALL * motion.joints[joint].friction.coulomb
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        let v_s = shape[0].abs().max(1e-12);
        vec![falling(motion, joint, v_s)]
    }

    fn parameters(&self, motion: &Motion, joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![motion.joints[joint].friction.coulomb + coefficients[0], shape[0].abs()]
    }
}

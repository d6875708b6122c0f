//! The rotor's inertia differs from the model's.
//!
//! `J_r → J_r (1 + a)`. The motor has to add `a · ratio² J_r · θ̈` and nothing else: a joint does not feel the rotors of other joints.
//! A larger inertia (a > 0) needs more torque in the direction of the acceleration.
//! Left out: the inertia of gear stages between motor and joint, which has the same effect.
//! Reference: M. Gautier, P. Poignet (2001), Extended Kalman filtering and weighted least squares dynamic identification of robot.

use std::collections::BTreeMap;

use super::parameters::{need, need_joint};
use super::{About, Action, Diagnosable, Effect, Experiment, Kind, Motion, ParameterSpec, Parameters, Scope};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "rotor_inertia",
    summary: "The rotor's inertia differs from what the model says.",
    equation: "J_r → J_r (1 + a)",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[ParameterSpec::new("error", "a", "1", "relative error, positive where the rotor is heavier")
        .between(-0.9, 10.0)],
    signature: "torque in proportion to the joint's own acceleration, the same in every pose and for any motion of the other joints",
    look_alikes: &["payload", "torque_constant_error", "sensor_delay"],
    separate_by: "accelerate one joint while another rests: a payload couples them, a rotor does not; a wrong torque constant scales friction too",
    reference: "M. Gautier, P. Poignet (2001), Extended Kalman filtering and weighted least squares dynamic identification of robot",
};

/// The rotor's inertia differs.
pub struct RotorInertia;

impl Effect for RotorInertia {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let a = Parameters::check(&ABOUT, model, given)?.get("error");
        let joint = need_joint(&ABOUT, model, joint)?;
        let key = format!("joints.{}.rotor_inertia", model.joints[joint].name);
        let nominal = need(&ABOUT, &model.source, key, model.joints[joint].rotor_inertia.as_mut())?;
        *nominal *= 1.0 + a;
        Ok(Vec::new())
    }

    fn shown_by(&self) -> &'static [Experiment] {
        &[Experiment::OneByOne]
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for RotorInertia {
    /// An unknown inertia is fitted with the baseline.
    fn applies(&self, motion: &Motion, joint: usize) -> bool {
        motion.model.joints[joint].reflected_inertia() > 0.0
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        let reflected = motion.model.joints[joint].reflected_inertia();
        vec![motion.column(joint, |m, row| reflected * m.a[row])]
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0]]
    }
}

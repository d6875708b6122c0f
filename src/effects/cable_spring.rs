//! A cable or hose pulls the link towards a rest position.
//!
//! The link feels `−c (q − q0)`; the motor has to add `c (q − q0)`, at any direction and speed.
//! This contains a constant, `−c q0`: a constant alone is reported as an offset, not as a cable.
//! Left out: hysteresis of the cable, and its pull on other joints.
//! Reference: M. Pham, M. Gautier, P. Poignet (2001), Identification of joint stiffness with bandpass filtering.

use std::collections::BTreeMap;

use super::parameters::need_joint;
use super::{
    About, Action, Diagnosable, Effect, Experiment, JointAction, JointState, Kind, Motion, ParameterSpec, Parameters,
    Scope,
};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "cable_spring",
    summary: "A cable or hose pulls the link towards a rest position.",
    equation: "τ = −c (q − q0) on the link",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("stiffness", "c", "N·m/rad", "torque per displacement, positive towards the rest position")
            .between(0.0, 1e9)
            .as_size(),
        ParameterSpec::new(
            "rest_position",
            "q0",
            "rad (joint)",
            "position at which the cable does not pull: beyond a few turns it would be a constant torque",
        )
        .between(-10.0, 10.0)
        .or(0.0),
    ],
    signature: "a torque linear in the position of one joint, whatever direction and speed",
    look_alikes: &["base_tilt", "current_offset", "coulomb_asymmetry"],
    separate_by: "move over the whole range: gravity bends like a sine, a cable does not; or take the cable off",
    reference: "M. Pham, M. Gautier, P. Poignet (2001), Identification of joint stiffness with bandpass filtering",
};

/// A cable pulls the link towards a rest position.
pub struct CableSpring;

struct Cable {
    c: f64,
    q0: f64,
}

impl JointAction for Cable {
    fn link_torque(&self, state: &JointState) -> f64 {
        -self.c * (state.link_position - self.q0)
    }
}

impl Effect for CableSpring {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let cable = Cable { c: given.get("stiffness"), q0: given.get("rest_position") };
        Ok(vec![Action::Joint(need_joint(&ABOUT, model, joint)?, Box::new(cable))])
    }

    fn shown_by(&self) -> &'static [Experiment] {
        &[Experiment::WideRange]
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for CableSpring {
    fn loads_link(&self) -> bool {
        true
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        let q = motion.link(joint).into_owned();
        // If the torque has a free offset, the offset takes the constant, and the rest position cannot be determined.
        if motion.joints[joint].has_current { vec![q, vec![1.0; motion.rows()]] } else { vec![q] }
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        match coefficients {
            [c, constant] => vec![*c, -constant / c],
            _ => vec![coefficients[0]],
        }
    }
}

//! The current sensor has an offset.
//!
//! `i → i + i0`, constant in a session. The measured torque has an error of `ratio K_t i0`, at rest and in motion.
//! Left out: a drift within a session.
//! Reference: A. Janot, M. Gautier, M. Brunot (2019), the offset of the EMPS model.

use std::collections::BTreeMap;

use super::parameters::need_joint;
use super::{
    About, Action, Diagnosable, Effect, Experiment, Kind, Motion, ParameterSpec, Parameters, Reading, Scope,
    SensorAction,
};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "current_offset",
    summary: "The current sensor has an offset.",
    equation: "i → i + i0",
    kind: Kind::Measurement,
    scope: Scope::Joint,
    parameters: &[ParameterSpec::new("offset", "i0", "A", "reading of the sensor at zero current").between(-1e5, 1e5)],
    signature: "a constant in amperes, also at rest",
    look_alikes: &["coulomb_asymmetry", "cable_spring", "base_tilt"],
    separate_by: "record the current with the drive off: an offset stays",
    reference: "A. Janot, M. Gautier, M. Brunot (2019), Data set and reference models of EMPS",
};

/// The current sensor has an offset.
pub struct CurrentOffset;

struct Offset(f64);

impl SensorAction for Offset {
    fn alter(&mut self, _time: f64, reading: &mut Reading) {
        reading.current += self.0;
    }
}

impl Effect for CurrentOffset {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let i0 = Parameters::check(&ABOUT, model, given)?.get("offset");
        Ok(vec![Action::Sensor(need_joint(&ABOUT, model, joint)?, Box::new(Offset(i0)))])
    }

    fn shown_by(&self) -> &'static [Experiment] {
        &[Experiment::AtRest, Experiment::SlowSteps]
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for CurrentOffset {
    fn applies(&self, motion: &Motion, joint: usize) -> bool {
        motion.joints[joint].has_current
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        vec![vec![motion.model.joints[joint].torque_per_ampere(); motion.rows()]]
    }

    fn reading_at_rest(&self, coefficients: &[f64]) -> f64 {
        coefficients[0]
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0]]
    }
}

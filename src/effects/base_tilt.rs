//! The base is not mounted as in the model: gravity comes from another direction.
//!
//! The base is turned by the angle `tilt` about the horizontal axis `k = (−sin α, cos α, 0)` of its frame, so that its z axis leans
//! towards the azimuth `α`. In the frame of the base, gravity turns the opposite way: `g → R(k, −tilt) g`, for small angles
//! `g + tilt · (cos α · ∂g_x + sin α · ∂g_y)`, with `∂g_x = −ŷ × g`, `∂g_y = x̂ × g`. A loose ball on the base rolls towards `α`.
//! One tilt acts on all joints. Left out: a base that is not rigid.
//! Reference: J. Hollerbach, W. Khalil, M. Gautier (2016), Model identification, Springer Handbook of Robotics.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::{DMatrix, Rotation3, Unit, Vector3};

use super::{About, Action, Diagnosable, Effect, Experiment, Kind, Motion, ParameterSpec, Parameters, Scope};
use crate::error::Result;
use crate::robot::Model;

static ABOUT: About = About {
    name: "base_tilt",
    summary: "The base is tilted against what the model says.",
    equation: "g → R(k, −tilt) g, k = (−sin α, cos α, 0)",
    kind: Kind::Physics,
    scope: Scope::Machine,
    parameters: &[
        ParameterSpec::new("tilt", "t", "rad", "angle by which the z axis of the base leans").between(0.0, 1.6),
        ParameterSpec::new(
            "azimuth",
            "α",
            "rad",
            "direction in which it leans, from the x axis of the base towards its y axis",
        )
        .between(-TAU, TAU),
    ],
    signature: "sine and cosine of the absolute link angles, whatever direction and speed; one tilt explains all joints",
    look_alikes: &["cable_spring", "current_offset"],
    separate_by: "repeat the run with the base turned by 90°, or move each joint over its whole range with another pose of the others",
    reference: "J. Hollerbach, W. Khalil, M. Gautier (2016), Model identification, Springer Handbook of Robotics",
};

/// The base is tilted.
pub struct BaseTilt;

/// Change of gravity per angle of tilt towards x and towards y.
fn gravity_changes(gravity: &Vector3<f64>) -> [Vector3<f64>; 2] {
    [-Vector3::y().cross(gravity), Vector3::x().cross(gravity)]
}

impl Effect for BaseTilt {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, _joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let (sin, cos) = given.get("azimuth").sin_cos();
        let k = Unit::new_normalize(Vector3::new(-sin, cos, 0.0));
        model.robot.gravity = Rotation3::from_axis_angle(&k, -given.get("tilt")) * model.robot.gravity;
        Ok(Vec::new())
    }

    fn shown_by(&self) -> &'static [Experiment] {
        &[Experiment::WideRange]
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for BaseTilt {
    fn loads_link(&self) -> bool {
        true
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        let columns = gravity_changes(&motion.model.robot.gravity).map(|gravity| {
            let mut robot = motion.model.robot.clone();
            robot.gravity = gravity;
            motion.inverse_dynamics(&robot, true).swap_remove(joint)
        });
        columns.into()
    }

    fn on_changed_bodies(&self, motion: &Motion, changes: &DMatrix<f64>, c: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let mut robot = motion.model.robot.clone();
        let [x, y] = gravity_changes(&robot.gravity);
        robot.gravity = x * c[0] + y * c[1];
        Some(motion.regressed_on(&robot, true, changes))
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        vec![coefficients[0].hypot(coefficients[1]), coefficients[1].atan2(coefficients[0])]
    }
}

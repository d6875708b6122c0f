//! A mass on the last link that is not in the model.
//!
//! A point mass `m` at `(x, y, z)` in the frame of the last body. All joints feel it: by their own acceleration, coupling, Coriolis and
//! centrifugal terms, and gravity where present. The torque is linear in `m` for a given position.
//! The position is sought along the line from the last joint through the centre of mass of its body; a mass beside that line is
//! identified at the nearest position on it.
//! Left out: the size of the payload.
//! Reference: W. Khalil, M. Gautier, P. Lemoine (2007), Identification of the payload inertial parameters of industrial manipulators.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::{About, Action, Diagnosable, Effect, Experiment, Kind, Motion, ParameterSpec, Parameters, Scope};
use crate::error::Result;
use crate::robot::{Inertia, Model, Robot};
use crate::units::JointKind;

static ABOUT: About = About {
    name: "payload",
    summary: "A mass that the model does not know of rides on the last link.",
    equation: "τ = m · Y(q, q̇, q̈, r), a point mass at r = (x, y, z) of the last body",
    kind: Kind::Physics,
    scope: Scope::Machine,
    parameters: &[
        ParameterSpec::new("mass", "m", "kg", "mass that the model lacks").between(0.0, 1e5),
        position("x"),
        position("y"),
        position("z"),
    ],
    signature: "torque in proportion to acceleration and to the Coriolis terms of all joints at once",
    look_alikes: &["load_dependent_friction", "sensor_delay", "base_tilt"],
    separate_by: "accelerate one joint while another rests: a payload couples them, a wrong rotor inertia or torque constant does not; or add a known mass: what it adds is measured as it is",
    reference: "W. Khalil, M. Gautier, P. Lemoine (2007), Identification of the payload inertial parameters",
};

const fn position(axis: &'static str) -> ParameterSpec {
    ParameterSpec::new(axis, axis, "m", "position in the frame of the last body").between(-1e3, 1e3).or(0.0)
}

/// A mass on the last link.
pub struct Payload;

/// A point mass.
fn point(mass: f64, position: Vector3<f64>) -> Inertia {
    Inertia { mass, com: position, tensor: Matrix3::zeros() }
}

/// The line along which the payload is sought: unit vector from the last joint's origin through its body's centre of mass, and that
/// distance. On a wrist that turns about the tool's axis, the line is that axis; on a planar arm it is perpendicular to the joint axis.
fn line(robot: &Robot) -> Option<(Vector3<f64>, f64)> {
    let body = robot.bodies.last()?;
    if body.joint.kind == JointKind::Prismatic {
        return None;
    }
    let distance = body.inertia.com.norm();
    (distance > 1e-9).then(|| (body.inertia.com / distance, distance))
}

fn place(robot: &Robot, shape: &[f64]) -> Vector3<f64> {
    match (line(robot), shape.first()) {
        (Some((direction, _)), Some(radius)) => direction * *radius,
        _ => Vector3::zeros(),
    }
}

impl Effect for Payload {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, _joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let position = Vector3::new(given.get("x"), given.get("y"), given.get("z"));
        if let Some(body) = model.robot.bodies.last_mut() {
            body.inertia = body.inertia.joined(&point(given.get("mass"), position));
        }
        Ok(Vec::new())
    }

    fn shown_by(&self) -> &'static [Experiment] {
        &[Experiment::AddedMass, Experiment::Fast, Experiment::OneByOne]
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

impl Diagnosable for Payload {
    fn loads_link(&self) -> bool {
        true
    }

    fn shapes(&self, motion: &Motion, _joint: usize) -> Vec<Vec<f64>> {
        match line(&motion.model.robot) {
            Some((_, distance)) => [0.5, 1.0, 1.5, 2.0, 3.0].iter().map(|part| vec![part * distance]).collect(),
            None => vec![Vec::new()],
        }
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        let mut robot = motion.model.robot.clone();
        let position = place(&robot, shape);
        let last = robot.bodies.len().saturating_sub(1);
        for (index, body) in robot.bodies.iter_mut().enumerate() {
            body.inertia = point(if index == last { 1.0 } else { 0.0 }, position);
        }
        vec![motion.inverse_dynamics(&robot, false).swap_remove(joint)]
    }

    fn parameters(&self, motion: &Motion, _joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        let position = place(&motion.model.robot, shape);
        vec![coefficients[0], position.x, position.y, position.z]
    }
}

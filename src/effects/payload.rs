//! A mass on a link, by default on the last one: a tool or a workpiece that the nominal model does not contain.
//!
//! A mass `m` at `r = (x, y, z)` in the frame of a body, with the same moment of inertia `I_c` about every axis through its centre. All joints
//! below feel it: by their own acceleration, coupling, Coriolis and centrifugal terms, and gravity where present. The torque is linear in the
//! ten parameters of the body, `m`, `h = m r` and `I = (h·h E − h hᵀ)/m + I_c E`, and the first part of `I` is linear in `m` and `h` near a
//! position `r₀`: `Σ_k h_k (2 r₀_k E − e_k r₀ᵀ − r₀ e_kᵀ) − m (r₀·r₀ E − r₀ r₀ᵀ)`, with no error at `r = r₀`. So mass, first moments and `I_c` are
//! fitted together, and `r₀` follows them.
//! Where the motion does not show the position, the mass stays near the centre of mass of its link: `h − m r_c ~ N(0, (m ρ)²)`; likewise
//! `I_c ~ N(0, (m κ²)²)`. A point mass would leave the inertia of a load on a wrist to a wrong link.
//! Left out: moments of inertia that differ by the axis.
//! Reference: W. Khalil, M. Gautier, P. Lemoine (2007), Identification of the payload inertial parameters of industrial manipulators.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::{About, Action, Diagnosable, Effect, Experiment, Kind, Motion, ParameterSpec, Parameters, Scope};
use crate::error::{Error, Result};
use crate::robot::{Accuracy, Inertia, Model, Robot};
use crate::units::JointKind;

static ABOUT: About = About {
    name: "payload",
    summary: "A link, by default the last one, carries a mass that the model does not contain.",
    equation: "τ = m · Y(q, q̇, q̈, r) + I_c · Y(q, q̇, q̈), a mass at r = (x, y, z) of the body",
    kind: Kind::Physics,
    scope: Scope::Machine,
    parameters: &[
        ParameterSpec::new("mass", "m", "kg", "mass that the model lacks; negative where a load was taken off")
            .between(-1e5, 1e5)
            .as_size(),
        position("x"),
        position("y"),
        position("z"),
        ParameterSpec::new("inertia", "I_c", "kg·m²", "moment of inertia about every axis through its centre")
            .between(-1e5, 1e5)
            .or(0.0),
        ParameterSpec::new("link", "i", "1", "number of the joint whose link carries it, counted from 1; 0: the last")
            .between(0.0, 128.0)
            .or(0.0),
    ],
    signature: "torque in proportion to acceleration and to the Coriolis terms of all joints at once",
    look_alikes: &["load_dependent_friction", "sensor_delay", "base_tilt"],
    separate_by: "accelerate one joint while another rests: a payload couples them, a wrong rotor inertia or torque constant does not; or add a known mass: the torque that it adds is measured correctly",
    reference: "W. Khalil, M. Gautier, P. Lemoine (2007), Identification of the payload inertial parameters",
};

const fn position(axis: &'static str) -> ParameterSpec {
    ParameterSpec::new(axis, axis, "m", "position in the frame of the body").between(-1e3, 1e3).or(0.0)
}

/// A mass on a link.
pub struct Payload;

/// `ρ` [m] How far from the centre of mass of its link a load is expected: a gripper with a workpiece reaches that far.
const EXPECTED_WITHIN: f64 = 0.3;
/// `κ` [m] Radius of gyration that is expected: a cube of 0.25 m.
const EXPECTED_GYRATION: f64 = 0.1;

/// Parameters of a body.
const NUMBERS: usize = Inertia::NUMBERS;
/// Coefficients of a load: mass, first moments, moment of inertia.
const UNKNOWNS: usize = 5;

/// A mass with a moment of inertia about its centre.
fn load(mass: f64, position: Vector3<f64>, inertia: f64) -> Inertia {
    Inertia { mass, com: position, tensor: Matrix3::identity() * inertia }
}

/// Index of the body that a parameter `link` means.
pub(super) fn body_of(robot: &Robot, link: f64) -> usize {
    let last = robot.bodies.len().saturating_sub(1);
    if link >= 1.0 { (link as usize - 1).min(last) } else { last }
}

/// Torque of changes of one body's parameters, ten rows and a column for each: `torque[joint][column][row]`.
pub(super) fn regressed_of_body(motion: &Motion, body: usize, changes: &DMatrix<f64>) -> Vec<Vec<Vec<f64>>> {
    let mut of_bodies = DMatrix::zeros(NUMBERS * motion.model.robot.bodies.len(), changes.ncols());
    of_bodies.rows_mut(NUMBERS * body, NUMBERS).copy_from(changes);
    motion.regressed(&of_bodies)
}

/// On a model whose inertias are exact, a load is sought along a line: the unit vector from the last joint's origin through its body's centre of
/// mass, and that distance. On a wrist that turns about the tool's axis it is that axis, on a planar arm it is perpendicular to the joint's axis.
/// Four coefficients would fit the residue of other effects there, because nothing else can.
fn line(motion: &Motion) -> Option<(Vector3<f64>, f64)> {
    let Accuracy { masses, centres, inertias, .. } = motion.model.accuracy;
    let body = motion.model.robot.bodies.last()?;
    let distance = body.inertia.com.norm();
    let exact = [masses, centres, inertias] == [0.0; 3];
    (exact && body.joint.kind == JointKind::Revolute && distance > 1e-9)
        .then(|| (body.inertia.com / distance, distance))
}

/// The place of a load on that line, for a shape that gives its distance.
fn on_line(motion: &Motion, shape: &[f64]) -> Option<Vector3<f64>> {
    let [radius] = shape else { return None };
    line(motion).map(|(direction, _)| direction * *radius)
}

/// Where a load is tried: `r₀`, a typical `m ρ` [kg·m], and the parameter `link`.
struct Place {
    position: Vector3<f64>,
    spread: f64,
    link: f64,
}

impl Place {
    fn of(shape: &[f64]) -> Self {
        let at = |k: usize| shape.get(k).copied().unwrap_or(0.0);
        Self { position: Vector3::new(at(0), at(1), at(2)), spread: at(3), link: at(4) }
    }

    fn shape(&self) -> Vec<f64> {
        vec![self.position.x, self.position.y, self.position.z, self.spread, self.link]
    }
}

/// Changes of a body's ten parameters per unit of the mass at the point `centre`, of the first moments beside it, and of the moment of inertia.
fn changes(centre: &Vector3<f64>, position: &Vector3<f64>) -> [[f64; NUMBERS]; UNKNOWNS] {
    let listed = |m: f64, h: Vector3<f64>, i: Matrix3<f64>| {
        [m, h.x, h.y, h.z, i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]]
    };
    let r = position;
    let slope = |k: usize| {
        let e = Vector3::ith(k, 1.0);
        Matrix3::identity() * (2.0 * r[k]) - e * r.transpose() - r * e.transpose()
    };
    let of_mass =
        (0..3).fold(-(Matrix3::identity() * r.norm_squared() - r * r.transpose()), |sum, k| sum + slope(k) * centre[k]);
    let moment = |k: usize| listed(0.0, Vector3::ith(k, 1.0), slope(k));
    let of_inertia = listed(0.0, Vector3::zeros(), Matrix3::identity());
    [listed(1.0, *centre, of_mass), moment(0), moment(1), moment(2), of_inertia]
}

impl Effect for Payload {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, _joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let position = Vector3::new(given.get("x"), given.get("y"), given.get("z"));
        let index = body_of(&model.robot, given.get("link"));
        if let Some(body) = model.robot.bodies.get_mut(index) {
            // A load that is taken off elsewhere than where the model has it leaves second moments that no body has.
            body.inertia = body.inertia.joined(&load(given.get("mass"), position, given.get("inertia"))).physical();
            if let Some(fault) = body.inertia.fault() {
                let expected = format!("a mass with which {} can exist as a body, not one with {fault}", body.name);
                let place = crate::error::Place::File;
                return Err(Error::input(&model.source, place, "effects.payload.mass", given.get("mass"), expected));
            }
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

    /// The last link first.
    fn shapes(&self, motion: &Motion, _joint: usize) -> Vec<Vec<f64>> {
        if let Some((_, distance)) = line(motion) {
            return [0.5, 1.0, 1.5, 2.0, 3.0].iter().map(|part| vec![part * distance]).collect();
        }
        let bodies = &motion.model.robot.bodies;
        let on = |(index, body): (usize, &crate::robot::Body)| {
            let link = if index + 1 == bodies.len() { 0.0 } else { (index + 1) as f64 };
            // A load as heavy as its link, to begin with.
            Place { position: body.inertia.com, spread: EXPECTED_WITHIN * body.inertia.mass, link }.shape()
        };
        bodies.iter().enumerate().rev().map(on).collect()
    }

    /// A load does not make a link lighter than its nominal mass; between two recordings a load may be removed.
    fn is_itself(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> bool {
        coefficients[0] > 0.0
    }

    /// A position follows its coefficients; a distance along a line is refined.
    fn refined_shapes(&self, shape: &[f64]) -> usize {
        usize::from(shape.len() == 1)
    }

    fn priors(&self, shape: &[f64]) -> Vec<(usize, f64)> {
        if shape.len() == 1 {
            return Vec::new();
        }
        let moment = Place::of(shape).spread.max(1e-9);
        let inertia = moment / EXPECTED_WITHIN * EXPECTED_GYRATION * EXPECTED_GYRATION;
        (1..UNKNOWNS).map(|k| (k, if k < 4 { moment } else { inertia }.powi(-2))).collect()
    }

    fn improved(&self, motion: &Motion, shape: &[f64], coefficients: &[f64]) -> Option<Vec<f64>> {
        let place = Place::of(shape);
        let [mass, x, y, z] = *coefficients.first_chunk::<4>()?;
        let centre = motion.model.robot.bodies[body_of(&motion.model.robot, place.link)].inertia.com;
        let position = centre + Vector3::new(x, y, z) / mass;
        let improved = Place { position, spread: EXPECTED_WITHIN * mass.abs(), ..place };
        position.iter().all(|x| x.is_finite()).then(|| improved.shape())
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        self.columns_of_all(motion, shape).map_or_else(Vec::new, |mut all| all.swap_remove(joint))
    }

    fn columns_of_all(&self, motion: &Motion, shape: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let robot = &motion.model.robot;
        if let Some(position) = on_line(motion, shape) {
            let change = DMatrix::from_column_slice(NUMBERS, 1, &load(1.0, position, 0.0).parameters());
            return Some(regressed_of_body(motion, robot.bodies.len() - 1, &change));
        }
        let place = Place::of(shape);
        let body = body_of(robot, place.link);
        let changes = changes(&robot.bodies[body].inertia.com, &place.position);
        Some(regressed_of_body(motion, body, &DMatrix::from_column_slice(NUMBERS, UNKNOWNS, changes.as_flattened())))
    }

    fn parameters(&self, motion: &Motion, _joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        if let Some(position) = on_line(motion, shape) {
            return vec![coefficients[0], position.x, position.y, position.z, 0.0, 0.0];
        }
        let place = Place::of(shape);
        let centre = motion.model.robot.bodies[body_of(&motion.model.robot, place.link)].inertia.com;
        let [mass, x, y, z, inertia] = coefficients.first_chunk::<UNKNOWNS>().copied().unwrap_or_default();
        let position = centre + Vector3::new(x, y, z) / if mass == 0.0 { 1.0 } else { mass };
        vec![mass, position.x, position.y, position.z, inertia, place.link]
    }
}

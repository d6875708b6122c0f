//! Mass, centre of mass or inertia of a link differ from the nominal values by more than the accuracy that the model states for them.
//!
//! The ten parameters `π = (m, h, I_O)` of a body are `π̄ + D c`, with `h` the first moments and `I_O` the tensor about the origin of the body's
//! frame. `D` is their change by [`LOOSE`] standard deviations of each nominal value ([`Accuracy`]), and `c_k ~ N(0, 1)`: a value that is wrong is wrong
//! by more than was stated, but rarely by more than that. `τ = Y(q, q̇, q̈) D c`, on the body's joint and all below it.
//! A motion shows only combinations of the parameters with those of other links, the base parameters; what it does not show stays at its nominal value.
//! In a simulation the body is the nearest one that can exist. Exact nominal values are not doubted.
//! References: M. Gautier, W. Khalil (1990), Direct calculation of minimum set of inertial parameters of serial robots; C. G. Atkeson, C. H. An,
//! J. M. Hollerbach (1986), Estimation of inertial parameters of manipulator loads and links (ridge for what the motion does not show).

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::payload::{body_of, regressed_of_body};
use super::possible::{is_possible, missing};
use super::{About, Action, Diagnosable, Effect, Experiment, Kind, Motion, ParameterSpec, Parameters, Scope};
use crate::error::Result;
use crate::robot::{Inertia, Masses, Model};

/// [1] Number of standard deviations by which a value that is less accurate than stated may be wrong.
const LOOSE: f64 = 10.0;
/// Parameters of a body, see [`Inertia::parameters`].
const NUMBERS: usize = Inertia::NUMBERS;
/// [1] Part of a link's torque that a possible body may lack: the laws of the catalogue are no more exact.
const INEXACT: f64 = 0.12;
/// `|c|²` that ten coefficients exceed in one case of twenty (χ² distribution): a body that differs by more from the fitted one is not as likely.
const UNLIKELY: f64 = 18.3;
/// Square of the torque's difference plus that of the body's, each over its limit, above which one of the two exceeds it.
const BOTH: f64 = 2.0;

const fn difference(name: &'static str, symbol: &'static str, unit: &'static str) -> ParameterSpec {
    ParameterSpec::new(name, symbol, unit, "true value minus nominal value").between(-1e6, 1e6).or(0.0)
}

static ABOUT: About = About {
    name: "link_inertia",
    summary: "A link is heavier, lighter or otherwise distributed than the model states.",
    equation: "π = π̄ + Δ, π = (m, h, I_O)",
    kind: Kind::Physics,
    scope: Scope::Machine,
    parameters: &[
        difference("mass", "Δm", "kg"),
        difference("moment_x", "Δh_x", "kg·m"),
        difference("moment_y", "Δh_y", "kg·m"),
        difference("moment_z", "Δh_z", "kg·m"),
        difference("inertia_xx", "ΔI_xx", "kg·m²"),
        difference("inertia_xy", "ΔI_xy", "kg·m²"),
        difference("inertia_xz", "ΔI_xz", "kg·m²"),
        difference("inertia_yy", "ΔI_yy", "kg·m²"),
        difference("inertia_yz", "ΔI_yz", "kg·m²"),
        difference("inertia_zz", "ΔI_zz", "kg·m²"),
        ParameterSpec::new("link", "i", "1", "number of the joint that moves the link, counted from 1; 0: the last")
            .between(0.0, 128.0)
            .or(0.0),
    ],
    signature: "torque of one link's weight and acceleration, on its own joint and on those below it",
    look_alikes: &["payload", "rotor_inertia", "torque_constant_error"],
    separate_by: "weigh the link, or repeat the motion with a known mass on it: the torque that the mass adds is measured correctly",
    reference: "M. Gautier, W. Khalil (1990), Direct calculation of minimum set of inertial parameters of serial robots",
};

/// A link differs from its nominal inertia.
pub struct LinkInertia;

/// `D` of a body: a column for each of its ten nominal values.
fn changes(model: &Model, body: usize) -> DMatrix<f64> {
    model.accuracy.deviations_of(&model.robot.bodies[body].inertia) * LOOSE
}

/// `Σ YᵀY` over all joints and rows of `columns[joint][k][row]`.
fn gram(columns: &[Vec<Vec<f64>>]) -> DMatrix<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    DMatrix::from_fn(NUMBERS, NUMBERS, |i, j| columns.iter().map(|joint| dot(&joint[i], &joint[j])).sum())
}

impl Effect for LinkInertia {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, _joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let index = body_of(&model.robot, given.get("link"));
        if let Some(body) = model.robot.bodies.get_mut(index) {
            let mut parameters = body.inertia.parameters();
            for (value, spec) in parameters.iter_mut().zip(ABOUT.parameters) {
                *value += given.get(spec.name);
            }
            body.inertia = Inertia::nearest(&parameters);
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

impl Diagnosable for LinkInertia {
    fn applies(&self, motion: &Motion, _joint: usize) -> bool {
        let accuracy = motion.model.accuracy;
        motion.model.masses == Masses::Known && [accuracy.masses, accuracy.centres, accuracy.inertias] != [0.0; 3]
    }

    fn several(&self) -> bool {
        true
    }

    /// The mass of the link itself does not change; a mass that is put on it is a payload.
    fn can_change(&self) -> bool {
        false
    }

    fn loads_link(&self) -> bool {
        true
    }

    /// One for each link: its number.
    fn shapes(&self, motion: &Motion, _joint: usize) -> Vec<Vec<f64>> {
        (1..=motion.model.robot.bodies.len()).map(|link| vec![link as f64]).collect()
    }

    fn refines(&self) -> bool {
        false
    }

    /// The torque of a spring or a balancer may be that of masses that no body has, or of one so heavy that nobody would expect it.
    /// There is a possible body whose torque differs by less than the inaccuracy of the laws, and which is as likely, or the link is not the cause.
    fn is_itself(&self, motion: &Motion, _joint: usize, shape: &[f64], coefficients: &[f64]) -> bool {
        let body = body_of(&motion.model.robot, shape[0]);
        let (inertia, changes) = (&motion.model.robot.bodies[body].inertia, changes(motion.model, body));
        let estimate = DVector::from_column_slice(coefficients);
        is_possible(inertia, &changes, &estimate) || {
            let gram = gram(&regressed_of_body(motion, body, &changes));
            let limit = INEXACT.powi(2) * estimate.dot(&(&gram * &estimate));
            let metric = gram / limit.max(f64::MIN_POSITIVE) + DMatrix::identity(NUMBERS, NUMBERS) / UNLIKELY;
            let missing = missing(inertia, &changes, &estimate, &metric);
            missing.dot(&(metric * &missing)) < BOTH
        }
    }

    fn nearest_possible(
        &self,
        motion: &Motion,
        shape: &[f64],
        coefficients: &[f64],
        precision: &DMatrix<f64>,
    ) -> Option<Vec<f64>> {
        let body = body_of(&motion.model.robot, *shape.first()?);
        let (inertia, changes) = (&motion.model.robot.bodies[body].inertia, changes(motion.model, body));
        let estimate = DVector::from_column_slice(coefficients);
        let metric = precision + DMatrix::identity(NUMBERS, NUMBERS);
        let nearest = || &estimate + missing(inertia, &changes, &estimate, &metric);
        (!is_possible(inertia, &changes, &estimate)).then(|| nearest().as_slice().to_vec())
    }

    fn priors(&self, _shape: &[f64]) -> Vec<(usize, f64)> {
        (0..NUMBERS).map(|k| (k, 1.0)).collect()
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        self.columns_of_all(motion, shape).map_or_else(Vec::new, |mut all| all.swap_remove(joint))
    }

    fn columns_of_all(&self, motion: &Motion, shape: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let body = body_of(&motion.model.robot, *shape.first()?);
        Some(regressed_of_body(motion, body, &changes(motion.model, body)))
    }

    fn parameters(&self, motion: &Motion, _joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        let link = shape.first().copied().unwrap_or(0.0);
        let mut values = vec![0.0; NUMBERS];
        if coefficients.len() == NUMBERS {
            let body = body_of(&motion.model.robot, link);
            values = (changes(motion.model, body) * DVector::from_column_slice(coefficients)).as_slice().to_vec();
        }
        values.push(link);
        values
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::effects::drawn::{LENGTH, MODEL, ROBOT, drawn};

    /// An arm of 1 kg at 0.3 m on a level axis, `Σ_xx = 0.1 kg·m²`: a body of its mass carries first moments up to `√(m Σ_xx)`, 0.32 kg·m. An arm may be
    /// half as heavy again. Moments of −0.9 kg·m, as of a balancer, need a product of mass and inertia that is eight times as large: only where the
    /// nominal ones are guesses, that may be.
    #[test]
    fn negative_a_balancer_is_no_link() {
        let robot = ROBOT
            .replace("<inertial>", "<inertial><origin xyz=\"0.3 0 0\"/>")
            .replace("0.2\"", "0.02\"")
            .replace("xyz=\"0 0 1\"", "xyz=\"0 -1 0\"");
        let is_link = |masses: f64, change: &dyn Fn(&mut [f64; NUMBERS])| {
            let accuracy = format!("[accuracy]\nmasses = {masses}\ncentres = 0.05\ninertias = {masses}\n");
            let text = MODEL.replace("[accuracy]\nmasses = 0\ncentres = 0\ninertias = 0\n", &accuracy);
            let model = Model::from_texts(&text, &robot, Path::new("model.toml")).expect("a model");
            let motion = drawn(&model, 1, None, LENGTH);
            let nominal = model.robot.bodies[0].inertia.parameters();
            let mut parameters = nominal;
            change(&mut parameters);
            let difference = DVector::from_fn(NUMBERS, |k, _| parameters[k] - nominal[k]);
            let coefficients = changes(&model, 0).lu().solve(&difference).expect("ten columns");
            LinkInertia.is_itself(&motion, 0, &[1.0], coefficients.as_slice())
        };
        let heavier = |parameters: &mut [f64; NUMBERS]| parameters.iter_mut().for_each(|value| *value *= 1.5);
        let balanced = |parameters: &mut [f64; NUMBERS]| parameters[1] = -0.9;
        assert!(is_link(0.05, &heavier));
        assert!(!is_link(0.05, &balanced));
        assert!(is_link(1.0, &balanced));
    }
}

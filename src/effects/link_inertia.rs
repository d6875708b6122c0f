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
use super::{About, Action, Diagnosable, Effect, Experiment, Kind, Motion, ParameterSpec, Parameters, Scope};
use crate::error::Result;
use crate::robot::{Inertia, Masses, Model};

/// [1] Number of standard deviations by which a value that is less accurate than stated may be wrong.
const LOOSE: f64 = 10.0;
/// Parameters of a body, see [`Inertia::parameters`].
const NUMBERS: usize = 10;

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

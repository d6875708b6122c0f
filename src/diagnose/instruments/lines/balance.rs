//! The disturbance torque on a rotor at a frequency, computed from its position and the motor's torque.
//!
//! ```text
//!   D θ = τ_m + d      D = −ω² J + K − K (K − ω² M)⁻¹ K      K = diag(k + iω d_g),  J = diag(rotors),  M links
//!   θ_j = R_j (τ_j + d_j) + …      R_j = (D⁻¹)_jj, over the joints that move; dry friction holds a rotor at rest
//! ```
//! A joint at rest is held on both sides of its gear, by the friction of rotor and link.
//! `k` and `d_g` are stiffness and damping of a gear while its flanks touch. Below `√(k/M)` the links follow the rotor. Above it the rotor
//! oscillates alone on its gear's spring; the current then shows little, because a controller that smooths its velocity no longer
//! responds. `M` changes with the arm's shape, slowly compared with the line: `d_j = θ_j/R_j − τ_j` with `R_j` of the posture. Near `√(k/M)` the links hold the
//! rotor, and `R_j` is small and changes its sign with the posture. Lines are looked for with `R̄_j`, the mean over the motion.
//! Left out: viscous friction (`ω B`, some per cent of `D`), the response of other motors, gaps that open where the load is small.
//! Reference: W. T. Thomson (1993), Theory of Vibration with Applications, ch. 6.

use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

use super::piece::Posture;
use crate::robot::Model;

/// [Hz] Distance of the frequencies at which it is computed.
const SPACING: f64 = 0.5;

/// [1] Stiffness of a rigid gear divided by `ω² M`: such a gear yields by the inverse of this, and the difference of two such terms keeps
/// ten digits.
const RIGID: f64 = 1e6;

/// Number of postures of which a mean is taken.
const PLACES: usize = 40;

/// `1/R̄` of a joint at many frequencies.
pub struct Stiffness {
    first: f64,
    values: Vec<Complex<f64>>,
}

impl Stiffness {
    /// From `first` to `last` [Hz].
    pub fn new(model: &Model, joint: usize, places: &[Posture], first: f64, last: f64) -> Self {
        let places: Vec<&Posture> = places.iter().step_by(places.len().div_ceil(PLACES).max(1)).collect();
        let count = ((last - first) / SPACING).ceil() as usize + 2;
        let at = |k: usize| {
            let omega = TAU * (first + SPACING * k as f64);
            let all: Complex<f64> = places.iter().filter_map(|place| receptance(model, joint, place, omega)).sum();
            Complex::from(places.len() as f64) / all
        };
        Self { first, values: (0..count).map(at).collect() }
    }

    /// [N·m/rad or N/m] at a frequency [Hz], by linear interpolation.
    pub fn at(&self, frequency: f64) -> Complex<f64> {
        let x = ((frequency - self.first) / SPACING).clamp(0.0, (self.values.len() - 2) as f64);
        let (k, part) = (x as usize, x.fract());
        self.values[k] * (1.0 - part) + self.values[k + 1] * part
    }
}

/// `R_j` [rad/(N·m) or m/N] in each posture, at a frequency [Hz]; 0 where nothing moves.
pub fn receptances(model: &Model, joint: usize, places: &[Posture], frequency: f64) -> Vec<Complex<f64>> {
    let at = |place| receptance(model, joint, place, TAU * frequency).unwrap_or_default();
    places.iter().map(at).collect()
}

/// `R_j` in one posture.
fn receptance(model: &Model, joint: usize, place: &Posture, omega: f64) -> Option<Complex<f64>> {
    let moving: Vec<usize> = (0..model.joints.len()).filter(|i| *i == joint || place.moves[*i]).collect();
    let gear = |i: usize| match model.joints[i].gear_stiffness {
        Some(stiffness) => Complex::new(stiffness, omega * model.joints[i].gear_damping.unwrap_or(0.0)),
        None => Complex::from(RIGID * omega * omega * place.mass[(i, i)]),
    };
    let matrix = |of: &dyn Fn(usize, usize) -> Complex<f64>| {
        DMatrix::from_fn(moving.len(), moving.len(), |a, b| of(moving[a], moving[b]))
    };
    let diagonal = |i: usize, j: usize, value: Complex<f64>| if i == j { value } else { Complex::default() };
    let follows = matrix(&|i, j| diagonal(i, j, gear(i)) - place.mass[(i, j)] * omega * omega).try_inverse()?;
    let own = |i: usize| gear(i) - model.joints[i].reflected_inertia() * omega * omega;
    let yielding = |a: usize, b: usize| gear(moving[a]) * follows[(a, b)] * gear(moving[b]);
    let stiffness =
        DMatrix::from_fn(moving.len(), moving.len(), |a, b| diagonal(a, b, own(moving[a])) - yielding(a, b));
    let own = moving.iter().position(|i| *i == joint)?;
    let unit = DVector::from_fn(moving.len(), |i, _| Complex::from(f64::from(u8::from(i == own))));
    Some(stiffness.lu().solve(&unit)?[own])
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const ROBOT: &str = "<robot name=\"one\"><link name=\"base\"/><link name=\"arm\"><inertial><mass value=\"1\"/>\
        <inertia ixx=\"0.2\" ixy=\"0\" ixz=\"0\" iyy=\"0.2\" iyz=\"0\" izz=\"0.2\"/></inertial></link>\
        <joint name=\"joint1\" type=\"revolute\"><parent link=\"base\"/><child link=\"arm\"/><axis xyz=\"0 0 1\"/>\
        <limit lower=\"-3\" upper=\"3\" effort=\"3\" velocity=\"3\"/></joint></robot>";
    const MODEL: &str = "schema = \"lostmotion/model/1\"\nname = \"one\"\nurdf = \"one.urdf\"\n[joints.joint1]\n\
        gear_ratio = 5.0\nrotor_inertia = 0.0008\ngear_stiffness = 3000.0\n[joints.joint1.motor]\ntorque_constant = 0.02\n";

    /// At low frequency rotor and link are one mass; above, `D = −J ω² + k (−M ω²)/(k − M ω²)`.
    #[test]
    fn closed_form_two_masses_on_a_spring() {
        let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a good model");
        let places = [Posture { mass: DMatrix::from_element(1, 1, 0.2), moves: vec![true] }];
        let stiffness = Stiffness::new(&model, 0, &places, 0.5, 150.0);
        for f in [0.5, 10.0, 50.0, 100.0] {
            let omega: f64 = TAU * f;
            let links = -0.2 * omega * omega;
            let expected = -0.02 * omega * omega + 3000.0 * links / (3000.0 + links);
            // Rounding error of two matrix inversions.
            assert!((stiffness.at(f) - expected).norm() < 1e-9 * expected.abs(), "{f} Hz: {}", stiffness.at(f));
        }
        // At 0.5 Hz the spring yields by M ω²/k = 0.07 %.
        let omega: f64 = TAU * 0.5;
        assert!((stiffness.at(0.5).re / (-0.22 * omega * omega) - 1.0).abs() < 1e-3);
    }

    /// A joint at rest holds its link: what moves is one mass behind one spring. With both in motion the other's mass is felt.
    #[test]
    fn closed_form_a_joint_at_rest_is_held_on_both_sides() {
        let model = Model::load(Path::new("robots/scara/model.toml")).expect("a model");
        let dof = model.joints.len();
        let mut mass = DMatrix::from_diagonal_element(dof, dof, 0.1);
        (mass[(0, 1)], mass[(1, 0)]) = (0.06, 0.06);
        let place = |others: bool| Posture { mass: mass.clone(), moves: (0..dof).map(|i| i == 0 || others).collect() };
        let omega = TAU * 30.0;
        let at = |others: bool| Complex::from(1.0) / receptances(&model, 0, &[place(others)], 30.0)[0];
        let gear = match model.joints[0].gear_stiffness {
            Some(stiffness) => Complex::new(stiffness, omega * model.joints[0].gear_damping.unwrap_or(0.0)),
            None => Complex::from(RIGID * omega * omega * mass[(0, 0)]),
        };
        let link = -mass[(0, 0)] * omega * omega;
        let expected = gear * link / (gear + link) - model.joints[0].reflected_inertia() * omega * omega;
        // Rounding error of two matrix inversions; of a rigid gear, of the difference of two large terms.
        assert!((at(false) - expected).norm() < 1e-6 * expected.norm(), "{} {expected}", at(false));
        assert!((at(true) - expected).norm() > 0.01 * expected.norm());
    }
}

//! What the integrator asks of the links: `M(q)` and `h(q, q̇)` of `M(q) q̈ + h(q, q̇) = τ`, from one of two engines.

use nalgebra::DMatrix;

use crate::dynamics::Dynamics;
use crate::robot::Coupling;

/// The links of a machine as a rigid-body engine sees them.
pub trait RigidBody: Send {
    /// Writes the mass matrix `M(q)` and the bias `h(q, q̇)` (Coriolis, centrifugal, gyroscopic and gravity torques).
    ///
    /// `q`, `v`, `h` have one entry per joint, `mass` is square of that size.
    fn evaluate(&mut self, q: &[f64], v: &[f64], mass: &mut DMatrix<f64>, h: &mut [f64]);

    /// Distance [m] of a link from an obstacle at `q`, negative where they overlap, and its gradient `∂d/∂q`, one entry per joint.
    ///
    /// `pair` is the index among the engine's pairs of a link and an obstacle; `None` where they are farther apart than `reach`.
    fn distance(&mut self, _pair: usize, _q: &[f64], _reach: f64, _gradient: &mut [f64]) -> Option<f64> {
        None
    }
}

/// The project's own recursive algorithms.
impl RigidBody for Dynamics {
    fn evaluate(&mut self, q: &[f64], v: &[f64], mass: &mut DMatrix<f64>, h: &mut [f64]) {
        self.mass_matrix_and_bias(q, v, mass, h);
    }
}

/// Converts an engine in joint coordinates to the coordinates of coupled axes: `q = C⁻¹ θ`, `M_θ = C⁻ᵀ M C⁻¹`, `h_θ = C⁻ᵀ h`,
/// `∂d/∂θ = C⁻ᵀ ∂d/∂q`.
pub struct OnAxes<E> {
    engine: E,
    coupling: Coupling,
    q: Vec<f64>,
    v: Vec<f64>,
    on_joints: Vec<f64>,
}

impl<E: RigidBody> OnAxes<E> {
    /// Puts the coupling before the engine.
    pub fn new(engine: E, coupling: Coupling) -> Self {
        let zero = vec![0.0; coupling.dof()];
        Self { engine, coupling, q: zero.clone(), v: zero.clone(), on_joints: zero }
    }
}

impl<E: RigidBody> RigidBody for OnAxes<E> {
    fn evaluate(&mut self, q: &[f64], v: &[f64], mass: &mut DMatrix<f64>, h: &mut [f64]) {
        self.coupling.joints(q, &mut self.q);
        self.coupling.joints(v, &mut self.v);
        self.engine.evaluate(&self.q, &self.v, mass, &mut self.on_joints);
        self.coupling.axis_torques(&self.on_joints, h);
        self.coupling.axis_matrix(mass, &mut self.on_joints);
    }

    fn distance(&mut self, pair: usize, q: &[f64], reach: f64, gradient: &mut [f64]) -> Option<f64> {
        self.coupling.joints(q, &mut self.q);
        let distance = self.engine.distance(pair, &self.q, reach, &mut self.on_joints)?;
        self.coupling.axis_torques(&self.on_joints, gradient);
        Some(distance)
    }
}

//! What the integrator asks of the links: `M(q)` and `h(q, q̇)` of `M(q) q̈ + h(q, q̇) = τ`, from one of two engines.

use nalgebra::DMatrix;

use crate::dynamics::Dynamics;

/// The links of a machine as a rigid-body engine sees them.
pub trait RigidBody: Send {
    /// Writes the mass matrix `M(q)` and the bias `h(q, q̇)` (Coriolis, centrifugal, gyroscopic and gravity torques).
    ///
    /// `q`, `v`, `h` have one entry a joint, `mass` is square of that size.
    fn evaluate(&mut self, q: &[f64], v: &[f64], mass: &mut DMatrix<f64>, h: &mut [f64]);

    /// Distance [m] of a link from an obstacle at `q`, negative where they overlap, and its gradient `∂d/∂q`, one entry a joint.
    ///
    /// `pair` counts the engine's pairs of a link and an obstacle; `None` where they are farther apart than `reach`.
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

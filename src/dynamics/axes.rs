//! The algorithms in the coordinates of coupled axes, `θ = C q`.
//!
//! ```text
//!   q = C⁻¹ θ,  v and a alike        τ_θ = C⁻ᵀ τ        H_θ = C⁻ᵀ H C⁻¹        C_θ = C⁻ᵀ C(q, v) C⁻¹        Y_θ = C⁻ᵀ Y
//! ```
//! `C` is constant, so `Ḣ_θ − 2 C_θ` stays skew-symmetric and energies keep their values.

use nalgebra::{DMatrix, Isometry3};

use super::Dynamics;
use crate::robot::Coupling;

/// The coupling, with working memory for quantities of the joints.
#[derive(Debug, Clone)]
pub(super) struct Axes {
    coupling: Coupling,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    tau: Vec<f64>,
}

impl Axes {
    pub(super) fn new(coupling: &Coupling) -> Self {
        let zero = vec![0.0; coupling.dof()];
        Self { coupling: coupling.clone(), q: zero.clone(), v: zero.clone(), a: zero.clone(), tau: zero }
    }

    /// Stores the position and velocity of the joints, computed from those of the axes.
    fn take(&mut self, q: &[f64], v: &[f64]) {
        self.coupling.joints(q, &mut self.q);
        self.coupling.joints(v, &mut self.v);
    }
}

impl Dynamics {
    /// Calls `work` in joint coordinates: while it runs, this robot has no coupling.
    fn on_joints<T: Default>(&mut self, work: impl FnOnce(&mut Self, &mut Axes) -> T) -> T {
        let Some(mut axes) = self.axes.take() else { return T::default() };
        let result = work(self, &mut axes);
        self.axes = Some(axes);
        result
    }

    /// Position of a joint, from those of the axes.
    pub(super) fn joint_position(&self, joint: usize, axes: &[f64]) -> f64 {
        self.axes.as_ref().map_or(axes[joint], |own| own.coupling.joint(joint, |axis| axes[axis]))
    }

    pub(super) fn inverse_on_axes(&mut self, q: &[f64], v: &[f64], a: &[f64], tau: &mut [f64]) {
        self.on_joints(|joints, axes| {
            axes.take(q, v);
            axes.coupling.joints(a, &mut axes.a);
            joints.inverse(&axes.q, &axes.v, &axes.a, &mut axes.tau);
            axes.coupling.axis_torques(&axes.tau, tau);
        });
    }

    pub(super) fn bias_on_axes(&mut self, q: &[f64], v: &[f64], tau: &mut [f64]) {
        self.on_joints(|joints, axes| {
            axes.take(q, v);
            joints.bias(&axes.q, &axes.v, &mut axes.tau);
            axes.coupling.axis_torques(&axes.tau, tau);
        });
    }

    pub(super) fn gravity_on_axes(&mut self, q: &[f64], tau: &mut [f64]) {
        self.on_joints(|joints, axes| {
            axes.coupling.joints(q, &mut axes.q);
            joints.gravity(&axes.q, &mut axes.tau);
            axes.coupling.axis_torques(&axes.tau, tau);
        });
    }

    pub(super) fn mass_matrix_on_axes(&mut self, q: &[f64], h: &mut DMatrix<f64>) {
        self.on_joints(|joints, axes| {
            axes.coupling.joints(q, &mut axes.q);
            joints.mass_matrix(&axes.q, h);
            axes.coupling.axis_matrix(h, &mut axes.tau);
        });
    }

    pub(super) fn mass_matrix_and_bias_on_axes(&mut self, q: &[f64], v: &[f64], h: &mut DMatrix<f64>, tau: &mut [f64]) {
        self.on_joints(|joints, axes| {
            axes.take(q, v);
            joints.mass_matrix_and_bias(&axes.q, &axes.v, h, &mut axes.tau);
            axes.coupling.axis_torques(&axes.tau, tau);
            axes.coupling.axis_matrix(h, &mut axes.tau);
        });
    }

    pub(super) fn forward_on_axes(&mut self, q: &[f64], v: &[f64], tau: &[f64], a: &mut [f64]) {
        self.on_joints(|joints, axes| {
            axes.take(q, v);
            axes.coupling.joint_torques(tau, &mut axes.tau);
            joints.forward(&axes.q, &axes.v, &axes.tau, &mut axes.a);
            axes.coupling.axes(&axes.a, a);
        });
    }

    pub(super) fn coriolis_matrix_on_axes(&mut self, q: &[f64], v: &[f64], c: &mut DMatrix<f64>) {
        self.on_joints(|joints, axes| {
            axes.take(q, v);
            joints.coriolis_matrix(&axes.q, &axes.v, c);
            axes.coupling.axis_matrix(c, &mut axes.tau);
        });
    }

    pub(super) fn regressor_on_axes(&mut self, q: &[f64], v: &[f64], a: &[f64], y: &mut DMatrix<f64>) {
        self.on_joints(|joints, axes| {
            axes.take(q, v);
            axes.coupling.joints(a, &mut axes.a);
            joints.regressor(&axes.q, &axes.v, &axes.a, y);
            for mut column in y.column_iter_mut() {
                axes.coupling.axis_torques(column.as_slice(), &mut axes.tau);
                column.copy_from_slice(&axes.tau);
            }
        });
    }

    pub(super) fn kinetic_energy_on_axes(&mut self, q: &[f64], v: &[f64]) -> f64 {
        self.on_joints(|joints, axes| {
            axes.take(q, v);
            joints.kinetic_energy(&axes.q, &axes.v)
        })
    }

    pub(super) fn poses_on_axes(&mut self, q: &[f64], poses: &mut [Isometry3<f64>]) {
        self.on_joints(|joints, axes| {
            axes.coupling.joints(q, &mut axes.q);
            joints.poses_into(&axes.q, poses);
        });
    }
}

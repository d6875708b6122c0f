//! How motor axes move joints: the constant matrix of a wrist or of a parallelogram.
//!
//! ```text
//!   θ = C q          θ_i angle of motor i divided by its gear ratio, q_j angle of joint j
//!   τ_q = Cᵀ τ_θ     virtual work: τ_θᵀ dθ = τ_qᵀ dq
//! ```
//! A wrist whose sixth motor turns by the sum of the last two joints has `θ_5 = q_5`, `θ_6 = q_5 + q_6`; hence `τ_q5 = τ_θ5 + τ_θ6`, `τ_q6 = τ_θ6`.
//! Rotor, gear and friction of an axis turn with `θ_i`; a link, its stops and a second encoder on it turn with `q_j`.
//! Seen from the axes, the links have the mass matrix `C⁻ᵀ M C⁻¹` and the torques `C⁻ᵀ τ_q`.
//! Left out: a coupling that depends on the pose, such as a crank or a linear drive on a lever.
//! Reference: B. Siciliano, L. Sciavicco, L. Villani, G. Oriolo (2009), Robotics, section 7.2 (actuators that are not at their joints).

use nalgebra::DMatrix;

use super::tree::Body;
use crate::error::{Error, Result};
use crate::toml_input::{Range, Table, nearest};

/// A coefficient: motion of an axis per motion of a joint. Published coefficients are 1, −1, or the ratio of two wheels.
const COEFFICIENT: Range = Range::between(-1e6, 1e6, "motion of the axis per motion of the joint");

/// [1] Ratio of the smallest to the largest singular value below which a matrix counts as singular. At this ratio, torques that are
/// computed with the inverse keep seven of their sixteen digits.
const SINGULAR: f64 = 1e-9;

/// The constant matrix between joints and motor axes, `θ = C q`.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// `C`.
    matrix: DMatrix<f64>,
    /// `C⁻¹`.
    inverse: DMatrix<f64>,
}

impl Coupling {
    /// The coupling of a matrix `C` with one row per axis and one column per joint; `None` if it is not square, not finite or singular.
    pub fn new(matrix: DMatrix<f64>) -> Option<Self> {
        if !matrix.is_square() || matrix.is_empty() || matrix.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let sizes = matrix.singular_values();
        if sizes.min() <= SINGULAR * sizes.max() {
            return None;
        }
        let inverse = matrix.clone().try_inverse()?;
        Some(Self { matrix, inverse })
    }

    /// Number of axes; it equals the number of joints.
    pub fn dof(&self) -> usize {
        self.matrix.nrows()
    }

    /// `C[i][j]`: motion of axis `i` per motion of joint `j`.
    pub fn axis_per_joint(&self, axis: usize, joint: usize) -> f64 {
        self.matrix[(axis, joint)]
    }

    /// `C⁻¹[j][i]`: motion of joint `j` per motion of axis `i`, with the other axes at rest; also the torque on axis `i` per torque on joint `j`.
    pub fn joint_per_axis(&self, joint: usize, axis: usize) -> f64 {
        self.inverse[(joint, axis)]
    }

    /// Position, velocity or acceleration of one joint, `(C⁻¹ θ)_j`, from those of the axes.
    pub fn joint(&self, joint: usize, of_axis: impl Fn(usize) -> f64) -> f64 {
        (0..self.inverse.ncols()).map(|axis| self.inverse[(joint, axis)] * of_axis(axis)).sum()
    }

    /// `q = C⁻¹ θ`, also for velocities and accelerations.
    pub fn joints(&self, axes: &[f64], joints: &mut [f64]) {
        for (j, joint) in joints.iter_mut().enumerate() {
            *joint = self.joint(j, |axis| axes[axis]);
        }
    }

    /// `θ = C q`, also for velocities and accelerations.
    pub fn axes(&self, joints: &[f64], axes: &mut [f64]) {
        for (i, axis) in axes.iter_mut().enumerate() {
            *axis = joints.iter().enumerate().map(|(j, q)| self.matrix[(i, j)] * q).sum();
        }
    }

    /// `τ_θ = C⁻ᵀ τ_q`, also for the gradient of a function of the pose.
    pub fn axis_torques(&self, joints: &[f64], axes: &mut [f64]) {
        for (i, axis) in axes.iter_mut().enumerate() {
            *axis = joints.iter().enumerate().map(|(j, tau)| self.inverse[(j, i)] * tau).sum();
        }
    }

    /// `τ_q = Cᵀ τ_θ`.
    pub fn joint_torques(&self, axes: &[f64], joints: &mut [f64]) {
        for (j, joint) in joints.iter_mut().enumerate() {
            *joint = axes.iter().enumerate().map(|(i, tau)| self.matrix[(i, j)] * tau).sum();
        }
    }

    /// `A → C⁻ᵀ A C⁻¹`: a matrix that gives torques from motions, such as the mass matrix.
    pub fn axis_matrix(&self, matrix: &mut DMatrix<f64>, room: &mut [f64]) {
        for _ in 0..2 {
            for mut column in matrix.column_iter_mut() {
                self.axis_torques(column.as_slice(), room);
                column.copy_from_slice(room);
            }
            matrix.transpose_mut();
        }
    }

    /// Axes that are loaded by a torque on this joint; the joint's own axis comes first.
    pub fn axes_of(&self, joint: usize) -> Vec<usize> {
        let others = (0..self.matrix.nrows()).filter(|axis| *axis != joint && self.inverse[(joint, *axis)] != 0.0);
        std::iter::once(joint).chain(others).collect()
    }

    /// For each axis, the largest motion in either direction for which no joint moves farther than these distances. A joint divides its
    /// distance equally among the axes that move it.
    pub fn within(&self, of_joints: &[f64]) -> Vec<f64> {
        let n = self.dof();
        let moved = |joint: usize| self.inverse.row(joint).iter().filter(|value| **value != 0.0).count() as f64;
        let left = |joint: usize, axis: usize| of_joints[joint] / (moved(joint) * self.inverse[(joint, axis)].abs());
        let of_axis = |axis: usize| {
            let moves = (0..n).filter(|joint| self.inverse[(*joint, axis)] != 0.0);
            moves.map(|joint| left(joint, axis)).fold(f64::INFINITY, f64::min)
        };
        (0..n).map(of_axis).collect()
    }

    /// [1] Largest motion of any joint while no axis moves by more than one.
    pub fn spread(&self) -> f64 {
        self.inverse.row_iter().map(|row| row.iter().map(|value| value.abs()).sum()).fold(0.0, f64::max)
    }

    /// Reads the table `[coupling]`: one row for each axis that does not move only its own joint.
    ///
    /// # Errors
    /// A joint is unknown, a coefficient is not a number, or the matrix is singular.
    pub(super) fn read(root: &Table<'_>, bodies: &[Body]) -> Result<Option<Self>> {
        let Some(table) = root.optional_table("coupling")? else { return Ok(None) };
        let mut matrix = DMatrix::identity(bodies.len(), bodies.len());
        for (name, row) in table.named_tables()? {
            let axis = index(&table, name, bodies)?;
            matrix.row_mut(axis).fill(0.0);
            for name in row.keys() {
                matrix[(axis, index(&row, name, bodies)?)] = row.number(name, &COEFFICIENT)?;
            }
        }
        let expected = "linearly independent rows: C in θ = C q must be invertible";
        Self::new(matrix).map(Some).ok_or_else(|| root.error("coupling", expected))
    }

    /// Rows of the matrix that differ from the identity: the axis, and its coefficients by joint.
    pub(super) fn rows(&self) -> impl Iterator<Item = (usize, Vec<(usize, f64)>)> + '_ {
        let n = self.matrix.nrows();
        let of_axis = move |axis: usize| {
            let row = (0..n).map(|joint| (joint, self.matrix[(axis, joint)])).filter(|(_, value)| *value != 0.0);
            (axis, row.collect::<Vec<_>>())
        };
        (0..n).map(of_axis).filter(|(axis, row)| *row != [(*axis, 1.0)])
    }
}

/// Index of the joint that a key names.
fn index(table: &Table<'_>, name: &str, bodies: &[Body]) -> Result<usize> {
    let found = bodies.iter().position(|body| body.joint.name == name);
    found.ok_or_else(|| unknown(table, name, bodies))
}

fn unknown(table: &Table<'_>, name: &str, bodies: &[Body]) -> Error {
    let names: Vec<&str> = bodies.iter().map(|body| body.joint.name.as_str()).collect();
    let near = nearest(name, names.iter().copied()).map_or_else(|| names.join(", "), str::to_owned);
    table.error(name, format!("a joint of this model: {near}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrist() -> Coupling {
        Coupling::new(DMatrix::from_row_slice(3, 3, &[1.0, 0.0, 0.0, 0.5, 1.0, 0.0, -0.25, 1.0, 2.0])).unwrap()
    }

    /// `τ_θ · δθ = τ_q · δq` for any displacement.
    #[test]
    fn property_both_sides_do_the_same_virtual_work() {
        let coupling = wrist();
        let (dq, on_axes) = ([0.3, -0.7, 0.2], [4.0, -1.0, 2.5]);
        let (mut dtheta, mut on_joints, mut back, mut again) = ([0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]);
        coupling.axes(&dq, &mut dtheta);
        coupling.joint_torques(&on_axes, &mut on_joints);
        coupling.joints(&dtheta, &mut back);
        coupling.axis_torques(&on_joints, &mut again);
        let work = |tau: &[f64], d: &[f64]| tau.iter().zip(d).map(|(a, b)| a * b).sum::<f64>();
        // Rounding of a few products of numbers below 10.
        assert!((work(&on_axes, &dtheta) - work(&on_joints, &dq)).abs() < 1e-14);
        for k in 0..3 {
            assert!((back[k] - dq[k]).abs() < 1e-14 && (again[k] - on_axes[k]).abs() < 1e-14);
        }
    }

    #[test]
    fn equivalent_a_matrix_seen_from_the_axes() {
        let coupling = wrist();
        let m = DMatrix::from_row_slice(3, 3, &[3.0, 0.2, 0.1, 0.4, 2.0, 0.3, 0.5, 0.6, 1.0]);
        let mut found = m.clone();
        coupling.axis_matrix(&mut found, &mut [0.0; 3]);
        let expected = coupling.inverse.transpose() * m * &coupling.inverse;
        assert!((found - expected).amax() < 1e-14);
    }

    #[test]
    fn property_a_matrix_without_an_inverse_is_none() {
        assert!(Coupling::new(DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0])).is_none());
        assert!(Coupling::new(DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, f64::NAN])).is_none());
        assert!(Coupling::new(DMatrix::zeros(2, 3)).is_none());
    }
}

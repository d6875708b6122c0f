//! Inertia of each joint with its rotor.

use nalgebra::DMatrix;

use crate::dynamics::Dynamics;
use crate::robot::Model;

/// Inertia of each joint with its rotor at q = 0: it converts noise of the acceleration into torque.
pub fn typical_inertia(model: &Model) -> Vec<f64> {
    let dof = model.joints.len();
    let mut mass = DMatrix::zeros(dof, dof);
    Dynamics::new(&model.robot).mass_matrix(&vec![0.0; dof], &mut mass);
    (0..dof).map(|joint| mass[(joint, joint)] + model.joints[joint].reflected_inertia()).collect()
}

//! A first model of a URDF that can be simulated.
//!
//! ```text
//!   M(0) = L D Lᵀ    D_i: inertia of joint i while the joints before it are free
//! ```
//! `M` is positive definite where each `D_i > 0`. Links without an inertia do no harm within a chain whose last link has one; three axes
//! that meet and carry a point mass do: about the line through the mass nothing resists. The last of such joints is held.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::DMatrix;

use super::Plant;
use crate::dynamics::Dynamics;
use crate::error::Result;
use crate::robot::Model;

/// [1] Least `D_i` as a share of `M_ii`. Rounding leaves some 1e-15 where it is zero; joints of real arms keep more than 1e-4.
const LEAST_SHARE: f64 = 1e-9;

/// A model of every joint that turns or slides and has an inertia to move, with gears and drives of common size. A gear whose common stiffness is too
/// much for the inertia of its link, as in a finger, is left unknown and counts as rigid.
///
/// # Errors
/// The file cannot be read, or is refused as in [`Model::load`].
pub fn first_model(file: &Path) -> Result<Model> {
    let mut held = BTreeMap::new();
    let mut model = Model::from_urdf(file)?;
    while let Some(joint) = without_inertia(&model) {
        let reason = "no inertia resists it while the joints before it are free, and it is held at zero; give the links behind it a tensor of \
                      inertia if it is to move";
        held.insert(model.joints[joint].name.clone(), reason.to_owned());
        model = Model::from_urdf_holding(file, &held)?;
    }
    // Each pass leaves one gear less.
    while let Some(joint) = Plant::too_fast(&model)? {
        let own = &mut model.joints[joint];
        if own.gear_stiffness.is_none() {
            break;
        }
        (own.gear_stiffness, own.gear_damping) = (None, None);
    }
    Ok(model)
}

/// The first joint `i` with `D_i = 0`.
fn without_inertia(model: &Model) -> Option<usize> {
    let n = model.joints.len();
    let mut d = DMatrix::zeros(n, n);
    Dynamics::new(&model.robot).mass_matrix(&vec![0.0; n], &mut d);
    let diagonal = d.diagonal();
    for i in 0..n {
        if d[(i, i)] <= LEAST_SHARE * diagonal[i] {
            return Some(i);
        }
        for row in i + 1..n {
            let share = d[(row, i)] / d[(i, i)];
            for column in i + 1..n {
                d[(row, column)] -= share * d[(i, column)];
            }
        }
    }
    None
}

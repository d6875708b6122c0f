//! Inertia of rigid bodies: changes of frame, composition, and the check that it is physically possible.

use nalgebra::{Isometry3, Matrix3, Matrix4, Vector3};

use super::Inertia;

/// [1] Least eigenvalue of a pseudo-inertia, as a share of the sum of all: a tenth of the rounding error of a URDF with six digits.
const LEAST_PSEUDO: f64 = 1e-7;

/// [1] Rounding of a file's digits that is tolerated in a tensor, as a share of its largest moment.
const SLACK: f64 = 1e-6;

/// [1] Rounding error of a change of frame, as a share of `m |c|²`: a tensor about the centre of mass is a difference of such numbers.
/// About ten operations before the file is written, and as many after it is read, add 1e-16 each.
const ROUNDING: f64 = 1e-14;

impl Inertia {
    /// Number of a body's [parameters](Self::parameters).
    pub const NUMBERS: usize = 10;

    /// No mass.
    pub fn zero() -> Self {
        Self { mass: 0.0, com: Vector3::zeros(), tensor: Matrix3::zeros() }
    }

    /// The same body in another frame; `pose` is the pose of the body's frame in it: `R I Rᵀ`.
    pub fn seen_from(&self, pose: &Isometry3<f64>) -> Self {
        let r = pose.rotation.to_rotation_matrix();
        Self {
            mass: self.mass,
            com: (pose * nalgebra::Point3::from(self.com)).coords,
            tensor: r * self.tensor * r.transpose(),
        }
    }

    /// Two bodies fixed to each other, both given in the same frame: tensors about the common centre of mass.
    pub fn joined(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        let com = if mass > 0.0 { (self.com * self.mass + other.com * other.mass) / mass } else { self.com };
        Self { mass, com, tensor: self.tensor_about(&com) + other.tensor_about(&com) }
    }

    /// Tensor about a point [kg·m²]: `I + m (d² E − d dᵀ)`, `d` from the centre of mass to the point (Steiner).
    pub fn tensor_about(&self, point: &Vector3<f64>) -> Matrix3<f64> {
        let d = point - self.com;
        self.tensor + (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * self.mass
    }

    /// The ten numbers in which the equations of motion are linear: `m`, `m c` and the tensor about the frame's origin,
    /// `[m, m c_x, m c_y, m c_z, I_xx, I_xy, I_xz, I_yy, I_yz, I_zz]`.
    pub fn parameters(&self) -> [f64; Self::NUMBERS] {
        let h = self.com * self.mass;
        let i = self.tensor_about(&Vector3::zeros());
        [self.mass, h.x, h.y, h.z, i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]]
    }

    /// The pseudo-inertia `[[Σ, h], [hᵀ, m]]`, `Σ = ½ tr(I) E − I`, of ten [parameters](Self::parameters), in which it is linear.
    /// It is positive semidefinite for every body, and for nothing else.
    pub fn pseudo(parameters: &[f64; Self::NUMBERS]) -> Matrix4<f64> {
        let [m, hx, hy, hz, xx, xy, xz, yy, yz, zz] = *parameters;
        let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let mut pseudo = Matrix4::zeros();
        pseudo.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * (0.5 * tensor.trace()) - tensor));
        for (k, h) in [hx, hy, hz].into_iter().enumerate() {
            (pseudo[(k, 3)], pseudo[(3, k)]) = (h, h);
        }
        pseudo[(3, 3)] = m;
        pseudo
    }

    /// The body of these ten [parameters](Self::parameters), or the nearest one that a rigid body can have.
    ///
    /// Eigenvalues of the [pseudo-inertia](Self::pseudo) below 1e-7 of their sum are raised to it, which is the nearest such matrix in the
    /// Frobenius norm.
    /// Reference: P. Wensing, S. Kim, J.-J. Slotine (2018), Linear matrix inequalities for physically consistent inertial parameter
    /// identification.
    pub fn nearest(parameters: &[f64; Self::NUMBERS]) -> Self {
        let mut pseudo = Self::pseudo(parameters);
        let mut eigen = pseudo.symmetric_eigen();
        let least = LEAST_PSEUDO * eigen.eigenvalues.iter().map(|value| value.abs()).sum::<f64>();
        if eigen.eigenvalues.iter().any(|value| *value < least) {
            eigen.eigenvalues.iter_mut().for_each(|value| *value = value.max(least));
            pseudo = eigen.recompose();
        }
        let mass = pseudo[(3, 3)];
        let com = Vector3::new(pseudo[(0, 3)], pseudo[(1, 3)], pseudo[(2, 3)]) / mass.max(f64::MIN_POSITIVE);
        let sigma = pseudo.fixed_view::<3, 3>(0, 0).into_owned();
        let about_origin = Matrix3::identity() * sigma.trace() - sigma;
        let steiner = (Matrix3::identity() * com.norm_squared() - com * com.transpose()) * mass;
        Self { mass, com, tensor: about_origin - steiner }
    }

    /// This inertia if a rigid body can have it; else the nearest possible one with the same mass and centre of mass.
    ///
    /// `Σ = ½ tr(I) E − I`, the second moment `∫ r rᵀ dm` about the centre of mass, of a body is positive semidefinite; with `m > 0` this is all
    /// that a pseudo-inertia needs (Schur complement). Its negative eigenvalues are raised to zero, which is the nearest such matrix
    /// in the Frobenius norm; then `I = tr(Σ) E − Σ`. [`nearest`](Self::nearest) changes mass and centre as well: it is for estimates,
    /// where none of the ten numbers is reliable. Mass and centre that a file gives are not changed.
    /// Reference: P. Wensing, S. Kim, J.-J. Slotine (2018), Linear matrix inequalities for physically consistent inertial parameter
    /// identification.
    #[must_use]
    pub fn physical(&self) -> Self {
        let sigma = Matrix3::identity() * (0.5 * self.tensor.trace()) - self.tensor;
        let mut eigen = sigma.symmetric_eigen();
        // The largest moment is the sum of the two largest eigenvalues. If σ_min < 0, a moment exceeds the sum of the others by 2 |σ_min|.
        let largest = (eigen.eigenvalues.sum() - eigen.eigenvalues.min()).abs();
        if eigen.eigenvalues.min() >= -0.5 * SLACK * largest {
            return *self;
        }
        eigen.eigenvalues.iter_mut().for_each(|value| *value = value.max(0.0));
        let sigma = eigen.recompose();
        Self { tensor: Matrix3::identity() * sigma.trace() - sigma, ..*self }
    }

    /// [kg·m²] Tolerance of the conditions on principal moments, for a tensor whose largest moment is this.
    fn slack(&self, largest: f64) -> f64 {
        SLACK * largest.abs() + ROUNDING * self.mass.abs() * self.com.norm_squared()
    }

    /// Why no rigid body can have this inertia; `None` if one can.
    ///
    /// Mass ≥ 0; principal moments ≥ 0, and none above the sum of the other two (equality is a flat body).
    /// Rounding of the file's digits is tolerated.
    pub fn fault(&self) -> Option<String> {
        if self.mass < 0.0 {
            return Some(format!("mass {} kg; expected ≥ 0", self.mass));
        }
        let mut moments = self.tensor.symmetric_eigenvalues();
        moments.as_mut_slice().sort_by(f64::total_cmp);
        let [small, middle, large] = [moments[0], moments[1], moments[2]];
        let slack = self.slack(large);
        if small < -slack || !large.is_finite() {
            return Some(format!("principal moments {small:.4e}, {middle:.4e}, {large:.4e} kg·m²; expected all ≥ 0"));
        }
        if large > small + middle + slack {
            return Some(format!(
                "principal moments {small:.4e}, {middle:.4e}, {large:.4e} kg·m²; expected none above the sum of the others"
            ));
        }
        (self.mass == 0.0 && large > 0.0).then(|| "moments of inertia without a mass".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body() -> Inertia {
        let tensor = Matrix3::new(0.03, 0.002, -0.001, 0.002, 0.02, 0.003, -0.001, 0.003, 0.035);
        Inertia { mass: 2.0, com: Vector3::new(0.1, -0.05, 0.2), tensor }
    }

    #[test]
    fn equivalent_a_body_is_nearest_to_itself() {
        let found = Inertia::nearest(&body().parameters());
        // Sums of numbers below 2 round to 4e-16; the difference of two tensors loses one digit.
        assert!((found.mass - 2.0).abs() < 1e-14 && (found.com - body().com).amax() < 1e-14);
        assert!((found.tensor - body().tensor).amax() < 1e-14);
    }

    #[test]
    fn property_what_no_body_has_becomes_a_body_near_by() {
        let mut parameters = body().parameters();
        parameters[9] = 0.2;
        assert!(Inertia::nearest(&parameters).fault().is_none());
        let far = [-1.0, 0.3, 0.0, 0.0, 1e-3, 0.0, 0.0, 1e-3, 0.0, 1.0];
        assert!(Inertia::nearest(&far).fault().is_none());
    }
}

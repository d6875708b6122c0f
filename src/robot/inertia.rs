//! Inertia of rigid bodies: changes of frame, composition, and the check that a body can have it.

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::Inertia;

impl Inertia {
    /// No mass.
    pub fn zero() -> Self {
        Self { mass: 0.0, com: Vector3::zeros(), tensor: Matrix3::zeros() }
    }

    /// The same body seen from the frame in which its own frame has this pose: `R I Rᵀ`.
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
    pub fn parameters(&self) -> [f64; 10] {
        let h = self.com * self.mass;
        let i = self.tensor_about(&Vector3::zeros());
        [self.mass, h.x, h.y, h.z, i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]]
    }

    /// Why no rigid body can have this inertia; `None` if one can.
    ///
    /// Mass ≥ 0; principal moments ≥ 0, and none above the sum of the other two (equality is a flat body).
    /// Rounding of the file's digits is tolerated up to 10⁻⁶ of the largest moment.
    pub fn fault(&self) -> Option<String> {
        if self.mass < 0.0 {
            return Some(format!("mass {} kg; expected ≥ 0", self.mass));
        }
        let mut moments = self.tensor.symmetric_eigenvalues();
        moments.as_mut_slice().sort_by(f64::total_cmp);
        let [small, middle, large] = [moments[0], moments[1], moments[2]];
        let slack = 1e-6 * large.abs();
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

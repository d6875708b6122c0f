//! The equations of motion as a product: `τ = Y(q, v, a) π`, where `π` has ten numbers per body.
//!
//! With the column `J = [w; l]` of a joint in a body's motion, `J · [N; F]` of the Newton-Euler equations is
//!
//! ```text
//!   m    l · p̈
//!   h    Aᵀ l + p̈ × w,                 A = [α]× + [ω]× [ω]×
//!   I    w · I α + (w × ω) · I ω
//! ```
//! Reference: C. Atkeson, C. An, J. Hollerbach (1986).

use nalgebra::{DMatrix, Vector3};

use super::{Dynamics, Motion, Twist};

impl Dynamics {
    /// `Y(q, v, a)`, `n` rows and `10 n` columns; body `i` has the columns from `10 i`, in the order of
    /// [`Inertia::parameters`](crate::robot::Inertia::parameters).
    pub fn regressor(&mut self, q: &[f64], v: &[f64], a: &[f64], y: &mut DMatrix<f64>) {
        if self.axes.is_some() {
            return self.regressor_on_axes(q, v, a, y);
        }
        self.place(q);
        self.update_columns();
        self.move_bodies(v, |i| a[i]);
        y.fill(0.0);
        let n = self.dof();
        for i in 0..n {
            let mut joint = Some(i);
            while let Some(k) = joint {
                let row = row(&self.motions[i], &self.columns[i * n + k]);
                for (column, value) in row.into_iter().enumerate() {
                    y[(k, 10 * i + column)] = value;
                }
                joint = self.links[k].parent;
            }
        }
    }
}

/// Effort of one joint per unit of each of the ten parameters of a body.
fn row(motion: &Motion, column: &Twist) -> [f64; 10] {
    let Motion { omega, alpha, acceleration } = motion;
    let (w, l) = (&column.omega, &column.v);
    // Aᵀ l = l × α + ω × (ω × l), as A is the sum of a skew and a symmetric matrix.
    let h: Vector3<f64> = l.cross(alpha) + omega.cross(&omega.cross(l)) + acceleration.cross(w);
    let u = w.cross(omega);
    let product = |r: usize, c: usize| {
        let both = |x: &Vector3<f64>, y: &Vector3<f64>| if r == c { x[r] * y[r] } else { x[r] * y[c] + x[c] * y[r] };
        both(w, alpha) + both(&u, omega)
    };
    let [xx, xy, xz] = [product(0, 0), product(0, 1), product(0, 2)];
    let [yy, yz, zz] = [product(1, 1), product(1, 2), product(2, 2)];
    [l.dot(acceleration), h.x, h.y, h.z, xx, xy, xz, yy, yz, zz]
}

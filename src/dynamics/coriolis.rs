//! Coriolis matrix with `Ḣ − 2 C` skew-symmetric, which equation 20 of the paper needs.
//!
//! In its own frame a body with velocity `V = [ω; u]` and momentum `M V = [L; P]` obeys
//!
//! ```text
//!   [N; F] = M V̇ + B V,     B = − ⎡ [L]×  [P]× ⎤ ,     Bᵀ = −B
//!                                 ⎣ [P]×    0  ⎦
//!   C = Σ Jᵀ (M J̇ + B J)
//! ```
//! `M` is constant, so `Ḣ − 2 C = Σ (J̇ᵀ M J − Jᵀ M J̇ − 2 Jᵀ B J)` is skew-symmetric term by term. `J̇` of the column of
//! joint `k`: `−(V − V_k) × J_k`, `V_k` the velocity of body `k` carried to this body.
//! Reference: G. Kirchhoff's equations of a body in its own frame; S. Echeandia, P. Wensing (2021).

use nalgebra::DMatrix;

use super::{Dynamics, Twist, Wrench};

impl Dynamics {
    /// `C(q, v)` with `C v + G` the bias and `Ḣ − 2 C` skew-symmetric.
    pub fn coriolis_matrix(&mut self, q: &[f64], v: &[f64], c: &mut DMatrix<f64>) {
        if self.axes.is_some() {
            return self.coriolis_matrix_on_axes(q, v, c);
        }
        self.place(q);
        self.update_columns();
        c.fill(0.0);
        let n = self.dof();
        for i in 0..n {
            let momentum = self.links[i].moments.times(&self.twist(i, v));
            self.update_column_rates(i, v);
            let mut column = Some(i);
            while let Some(k) = column {
                let wrench = self.coriolis_wrench(i, k, &momentum);
                let mut row = Some(i);
                while let Some(j) = row {
                    c[(j, k)] += self.columns[i * n + j].dot(&wrench);
                    row = self.links[j].parent;
                }
                column = self.links[k].parent;
            }
        }
    }

    /// `J̇` of body `i`. The velocity of the body relative to body `k` is what the joints below `k` add.
    fn update_column_rates(&mut self, i: usize, v: &[f64]) {
        let n = self.dof();
        let zero = nalgebra::Vector3::zeros();
        let mut relative = Twist { omega: zero, v: zero };
        let mut joint = Some(i);
        while let Some(k) = joint {
            let column = self.columns[i * n + k];
            self.column_rates[i * n + k] = Twist {
                omega: -relative.omega.cross(&column.omega),
                v: -(relative.omega.cross(&column.v) + relative.v.cross(&column.omega)),
            };
            relative.omega += column.omega * v[k];
            relative.v += column.v * v[k];
            joint = self.links[k].parent;
        }
    }

    /// `M J̇_k + B J_k` of body `i`.
    fn coriolis_wrench(&self, i: usize, k: usize, momentum: &Wrench) -> Wrench {
        let at = i * self.dof() + k;
        let column = &self.columns[at];
        let mut wrench = self.links[i].moments.times(&self.column_rates[at]);
        wrench.torque -= momentum.torque.cross(&column.omega) + momentum.force.cross(&column.v);
        wrench.force -= momentum.force.cross(&column.omega);
        wrench
    }
}

//! Mass matrix: composite-rigid-body algorithm.
//!
//! If only joint `i` accelerates, everything beyond it is one body; `H_ij` is the effort that holds joint `j` still. A
//! body seen from its parent, with `h' = R h`:
//!
//! ```text
//!   m,   h' + m p,   R I Rᵀ + 2 (h' · p) E − h' pᵀ − p h'ᵀ + m (p² E − p pᵀ)
//! ```
//! Reference: M. Walker, D. Orin (1982).

use nalgebra::{DMatrix, Matrix3};

use super::{Dynamics, Frame, Moments};

impl Dynamics {
    /// `H(q)` [kg·m², kg·m or kg], symmetric and positive definite.
    pub fn mass_matrix(&mut self, q: &[f64], h: &mut DMatrix<f64>) {
        if self.axes.is_some() {
            return self.mass_matrix_on_axes(q, h);
        }
        self.place(q);
        self.composite(h);
    }

    /// `H(q)` and `C(q, v) v + G(q)` at once: cheaper than one after the other.
    pub fn mass_matrix_and_bias(&mut self, q: &[f64], v: &[f64], h: &mut DMatrix<f64>, tau: &mut [f64]) {
        if self.axes.is_some() {
            return self.mass_matrix_and_bias_on_axes(q, v, h, tau);
        }
        self.place(q);
        self.newton_euler(v, |_| 0.0, tau);
        self.composite(h);
    }

    pub(super) fn composite(&mut self, h: &mut DMatrix<f64>) {
        h.fill(0.0);
        for (composite, link) in self.composites.iter_mut().zip(&self.links) {
            *composite = link.moments;
        }
        for i in (0..self.links.len()).rev() {
            let link = &self.links[i];
            let mut wrench = self.composites[i].times(&link.axis());
            h[(i, i)] = link.effort(&wrench);
            let mut below = i;
            while let Some(j) = self.links[below].parent {
                wrench = self.frames[below].wrench_in_parent(&wrench);
                let value = self.links[j].effort(&wrench);
                h[(i, j)] = value;
                h[(j, i)] = value;
                below = j;
            }
            if let Some(parent) = link.parent {
                let seen = self.frames[i].moments_in_parent(&self.composites[i]);
                self.composites[parent].add(&seen);
            }
        }
    }
}

impl Frame {
    /// Mass, first moment and tensor of the body about the parent's origin.
    pub(super) fn moments_in_parent(&self, body: &Moments) -> Moments {
        let Self { r, p } = self;
        let h = r * body.h;
        let cross = h * p.transpose();
        let shift = Matrix3::from_diagonal_element(2.0 * h.dot(p) + body.m * p.norm_squared())
            - cross
            - cross.transpose()
            - p * p.transpose() * body.m;
        Moments { m: body.m, h: h + p * body.m, i: r * body.i * r.transpose() + shift }
    }
}

impl Moments {
    fn add(&mut self, other: &Self) {
        self.m += other.m;
        self.h += other.h;
        self.i += other.i;
    }
}

//! Inverse dynamics: recursive Newton-Euler.
//!
//! ```text
//!   outwards   ω = Rᵀ ω_p + s v                        (turning; a sliding joint adds nothing to ω and α)
//!              α = Rᵀ α_p + (Rᵀ ω_p) × s v + s a
//!              p̈ = Rᵀ (p̈_p + α_p × p + ω_p × (ω_p × p))  + 2 ω × s v + s a   (the last two: sliding)
//!   body       F = m p̈ + α × h + ω × (ω × h)
//!              N = I α + ω × I ω + h × p̈
//!   inwards    τ = s · N or s · F, and the wrench goes to the parent
//! ```
//! Reference: J. Luh, M. Walker, R. Paul (1980).

use nalgebra::Vector3;

use super::{Dynamics, Motion, Wrench};
use crate::units::JointKind;

impl Dynamics {
    /// `τ = H(q) a + C(q, v) v + G(q)` [N·m or N].
    ///
    /// # Panics
    /// A slice is shorter than the number of joints, as in every method here.
    pub fn inverse(&mut self, q: &[f64], v: &[f64], a: &[f64], tau: &mut [f64]) {
        if self.axes.is_some() {
            return self.inverse_on_axes(q, v, a, tau);
        }
        self.place(q);
        self.newton_euler(v, |i| a[i], tau);
    }

    /// `C(q, v) v + G(q)` [N·m or N]: the effort that keeps the joint velocities constant.
    pub fn bias(&mut self, q: &[f64], v: &[f64], tau: &mut [f64]) {
        if self.axes.is_some() {
            return self.bias_on_axes(q, v, tau);
        }
        self.place(q);
        self.newton_euler(v, |_| 0.0, tau);
    }

    /// `G(q)` [N·m or N]: the effort that holds the robot still.
    pub fn gravity(&mut self, q: &[f64], tau: &mut [f64]) {
        if self.axes.is_some() {
            return self.gravity_on_axes(q, tau);
        }
        self.place(q);
        for i in 0..self.links.len() {
            let frame = &self.frames[i];
            let above = self.links[i].parent.map_or(-self.gravity, |parent| self.motions[parent].acceleration);
            self.motions[i].acceleration = frame.r.tr_mul(&above);
            let moments = &self.links[i].moments;
            let acceleration = self.motions[i].acceleration;
            self.wrenches[i] = Wrench { torque: moments.h.cross(&acceleration), force: acceleration * moments.m };
        }
        self.gather(tau);
    }

    pub(super) fn newton_euler(&mut self, v: &[f64], a: impl Fn(usize) -> f64, tau: &mut [f64]) {
        self.move_bodies(v, a);
        for ((wrench, motion), link) in self.wrenches.iter_mut().zip(&self.motions).zip(&self.links) {
            let Motion { omega, alpha, acceleration } = motion;
            let (m, h, i) = (link.moments.m, &link.moments.h, &link.moments.i);
            *wrench = Wrench {
                torque: i * alpha + omega.cross(&(i * omega)) + h.cross(acceleration),
                force: acceleration * m + alpha.cross(h) + omega.cross(&omega.cross(h)),
            };
        }
        self.gather(tau);
    }

    /// Motion of every body, after all poses are set.
    pub(super) fn move_bodies(&mut self, v: &[f64], a: impl Fn(usize) -> f64) {
        let base = Motion { omega: Vector3::zeros(), alpha: Vector3::zeros(), acceleration: -self.gravity };
        for i in 0..self.links.len() {
            let (link, frame) = (&self.links[i], &self.frames[i]);
            let above = link.parent.map_or(&base, |parent| &self.motions[parent]);
            let (sv, sa) = (link.s * v[i], link.s * a(i));
            let omega = frame.r.tr_mul(&above.omega);
            let alpha = frame.r.tr_mul(&above.alpha);
            let acceleration = frame.r.tr_mul(
                &(above.acceleration + above.alpha.cross(&frame.p) + above.omega.cross(&above.omega.cross(&frame.p))),
            );
            self.motions[i] = match link.kind {
                JointKind::Revolute => Motion { omega: omega + sv, alpha: alpha + omega.cross(&sv) + sa, acceleration },
                JointKind::Prismatic => {
                    Motion { omega, alpha, acceleration: acceleration + omega.cross(&sv) * 2.0 + sa }
                }
            };
        }
    }

    /// Passes the wrenches inwards, and takes the component of each joint.
    fn gather(&mut self, tau: &mut [f64]) {
        for i in (0..self.links.len()).rev() {
            let link = &self.links[i];
            tau[i] = link.effort(&self.wrenches[i]);
            if let Some(parent) = link.parent {
                let wrench = self.frames[i].wrench_in_parent(&self.wrenches[i]);
                self.wrenches[parent].add(&wrench);
            }
        }
    }
}

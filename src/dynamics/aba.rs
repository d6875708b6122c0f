//! Forward dynamics: articulated-body algorithm with three passes (outwards, inwards, outwards); its cost is linear in
//! the number of joints.
//!
//! A body and everything that hangs from it responds to a wrench like a rigid body with inertia `[A Bᵀ; B D]` (angular
//! and linear blocks) and a wrench of its own. With `U = I_A S`, `d = S · U` and `u = τ − S · p_A`:
//!
//! ```text
//!   a = (u − U · a') / d          a' the body's acceleration if the joint were locked
//! ```
//! Reference: R. Featherstone (1983).

use nalgebra::{Matrix3, Vector3};

use super::{Dynamics, Frame, Moments, Twist, Wrench};
use crate::units::JointKind;

/// Articulated inertia: `torque = a ω̇ + b v̇`, `force = bᵀ ω̇ + d v̇`; and the joint's terms.
#[derive(Debug, Clone, Copy)]
pub(super) struct Articulated {
    a: Matrix3<f64>,
    b: Matrix3<f64>,
    d: Matrix3<f64>,
    /// `U = I_A S`.
    axis: Wrench,
    /// `u / d`, `d = S · U`.
    share: f64,
    per_inertia: f64,
    /// Acceleration of the body relative to its parent due to velocities alone.
    drift: Twist,
}

impl Dynamics {
    /// `a = H(q)⁻¹ (τ − C v − G)`.
    pub fn forward(&mut self, q: &[f64], v: &[f64], tau: &[f64], a: &mut [f64]) {
        if self.axes.is_some() {
            return self.forward_on_axes(q, v, tau, a);
        }
        self.place(q);
        // The wrench of every body, and its acceleration, for zero joint accelerations.
        self.move_bodies(v, |_| 0.0);
        for i in 0..self.links.len() {
            self.articulated[i] = Articulated::rigid(&self.links[i].moments);
            self.wrenches[i] = self.velocity_wrench(i);
            self.articulated[i].drift = self.drift(i, v[i]);
        }
        for i in (0..self.links.len()).rev() {
            self.close_joint(i, tau[i]);
        }
        for i in 0..self.links.len() {
            let above = self.links[i].parent.map_or_else(
                || Twist { omega: Vector3::zeros(), v: -self.gravity },
                |parent| Twist { omega: self.motions[parent].alpha, v: self.motions[parent].acceleration },
            );
            let mut motion = self.frames[i].twist_in_child(&above);
            let articulated = &self.articulated[i];
            motion.omega += articulated.drift.omega;
            motion.v += articulated.drift.v;
            a[i] = articulated.share - motion.dot(&articulated.axis) * articulated.per_inertia;
            let axis = self.links[i].axis();
            self.motions[i].alpha = motion.omega + axis.omega * a[i];
            self.motions[i].acceleration = motion.v + axis.v * a[i];
        }
    }

    /// `[N; F]` due to velocity alone: `ω × I ω`, `ω × (ω × h)`.
    fn velocity_wrench(&self, i: usize) -> Wrench {
        let Moments { h, i: tensor, .. } = &self.links[i].moments;
        let omega = &self.motions[i].omega;
        Wrench { torque: omega.cross(&(tensor * omega)), force: omega.cross(&omega.cross(h)) }
    }

    /// Acceleration of body `i` due to velocities alone, in addition to that of its parent.
    fn drift(&self, i: usize, v: f64) -> Twist {
        let (link, frame) = (&self.links[i], &self.frames[i]);
        let above = link.parent.map_or_else(Vector3::zeros, |parent| self.motions[parent].omega);
        let sv = link.s * v;
        let omega = frame.r.tr_mul(&above);
        let centripetal = frame.r.tr_mul(&above.cross(&above.cross(&frame.p)));
        match link.kind {
            JointKind::Revolute => Twist { omega: omega.cross(&sv), v: centripetal },
            JointKind::Prismatic => Twist { omega: Vector3::zeros(), v: centripetal + omega.cross(&sv) * 2.0 },
        }
    }

    /// Prepares joint `i`, and passes the articulated inertia of its body to the parent.
    fn close_joint(&mut self, i: usize, tau: f64) {
        let link = &self.links[i];
        let mut own = self.articulated[i];
        own.axis = own.times(&link.axis());
        own.per_inertia = 1.0 / link.effort(&own.axis);
        own.share = (tau - link.effort(&self.wrenches[i])) * own.per_inertia;
        self.articulated[i] = own;
        let Some(parent) = link.parent else { return };
        let rest = own.without_axis();
        let mut wrench = rest.times(&own.drift);
        wrench.add(&self.wrenches[i]);
        wrench.torque += own.axis.torque * own.share;
        wrench.force += own.axis.force * own.share;
        let wrench = self.frames[i].wrench_in_parent(&wrench);
        self.wrenches[parent].add(&wrench);
        let seen = rest.in_parent(&self.frames[i]);
        let above = &mut self.articulated[parent];
        above.a += seen.a;
        above.b += seen.b;
        above.d += seen.d;
    }
}

impl Articulated {
    pub(super) fn zero() -> Self {
        Self::rigid(&Moments { m: 0.0, h: Vector3::zeros(), i: Matrix3::zeros() })
    }

    /// A rigid body: `N = I ω̇ + h × v̇`, `F = −h × ω̇ + m v̇`.
    fn rigid(body: &Moments) -> Self {
        let zero = Vector3::zeros();
        Self {
            a: body.i,
            b: body.h.cross_matrix(),
            d: Matrix3::from_diagonal_element(body.m),
            axis: Wrench { torque: zero, force: zero },
            share: 0.0,
            per_inertia: 0.0,
            drift: Twist { omega: zero, v: zero },
        }
    }

    fn times(&self, twist: &Twist) -> Wrench {
        Wrench {
            torque: self.a * twist.omega + self.b * twist.v,
            force: self.b.tr_mul(&twist.omega) + self.d * twist.v,
        }
    }

    /// `I_A − U Uᵀ / d`: the inertia that is felt through a free joint.
    fn without_axis(&self) -> Self {
        let Wrench { torque, force } = self.axis;
        Self {
            a: self.a - torque * torque.transpose() * self.per_inertia,
            b: self.b - torque * force.transpose() * self.per_inertia,
            d: self.d - force * force.transpose() * self.per_inertia,
            ..*self
        }
    }

    /// About the parent's origin and in its axes: with `P = [p]×`,
    /// `a + P bᵀ − b P − P d P`, `b + P d`, `d`, all turned by `R`.
    fn in_parent(&self, frame: &Frame) -> Self {
        let Frame { r, p } = frame;
        let turned = |block: &Matrix3<f64>| r * block * r.transpose();
        let (a, b, d) = (turned(&self.a), turned(&self.b), turned(&self.d));
        let p = p.cross_matrix();
        Self { a: a + p * b.transpose() - b * p - p * d * p, b: b + p * d, d, ..*self }
    }
}

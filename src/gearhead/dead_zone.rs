//! The flanks of a gear with a gap: compliance outside it, nothing inside it, and a tooth never pulls.
//!
//! With the wind-up `x = θ − q` between rotor and link, and the compression `p = x ∓ b/2` of the flank ±,
//!
//! ```text
//!        ⎧  max(0, k p + d ṗ)    x >  b/2,  p = x − b/2      T
//!   T =  ⎨  0                    |x| ≤ b/2                    |        /
//!        ⎩  min(0, k p + d ṗ)    x < −b/2,  p = x + b/2      |_______/_______ x
//!                                                            /   −b/2  b/2
//! ```
//!
//! Without a gap (`b = 0`) both flanks touch under preload and nothing is one-sided: `T = k x + d ẋ`.
//! Sign: `T` positive drives the link positively; `p` and `ṗ` of a flank are positive towards positive torque.
//! State: none. The integrator stores which flank touches and evaluates that [`Flank`] alone. A perfect gear has `p = x ∓ b/2`;
//! [`Mesh`](super::Mesh) gives `p` of other gears.
//! Left out: tooth mesh stiffness that changes with angle, and hysteresis of the material.
//! Reference: Modelica Standard Library, `Rotational.Components.ElastoBacklash`; the dead zone is equations 2 and 3 of
//! L. Márton, B. Lantos (2009) with a compliance.

/// A gear's gap and its stiffness outside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeadZone {
    /// `b` [rad or m] total gap at the joint, ≥ 0.
    pub backlash: f64,
    /// `k` [N·m/rad or N/m] stiffness outside the gap, > 0.
    pub stiffness: f64,
    /// `d` [N·m·s/rad or N·s/m] damping outside the gap, ≥ 0.
    pub damping: f64,
}

/// Compression of a flank and its rate, positive towards positive torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flank {
    /// +1 for the flank that drives positively, −1 for the other; 0 between them.
    pub side: f64,
    /// `p` [rad or m].
    pub p: f64,
    /// `ṗ` [rad/s or m/s].
    pub p_dot: f64,
}

impl DeadZone {
    /// The flank of a perfect gear at a wind-up and its rate.
    #[inline(always)]
    pub fn flank(&self, x: f64, x_dot: f64, side: f64) -> Flank {
        Flank { side, p: x - 0.5 * side * self.backlash, p_dot: x_dot }
    }

    /// `k p + d ṗ` [N·m or N] of a flank that touches.
    #[inline(always)]
    pub fn push(&self, flank: &Flank) -> f64 {
        self.stiffness * flank.p + self.damping * flank.p_dot
    }

    /// Distance [rad or m] of a flank from the change between contact and separation, positive in contact. Contact needs both: teeth
    /// that overlap, and a force that pushes.
    #[inline(always)]
    pub fn overlap(&self, flank: &Flank) -> f64 {
        let (p, p_dot) = (flank.side * flank.p, flank.side * flank.p_dot);
        p.min(p + p_dot * self.damping / self.stiffness)
    }

    /// `k p²/2` [J] of a flank that touches.
    pub fn energy(&self, flank: &Flank) -> f64 {
        0.5 * self.stiffness * flank.p * flank.p
    }

    /// `T(x, ẋ)` [N·m or N] of a perfect gear.
    pub fn torque(&self, x: f64, x_dot: f64) -> f64 {
        if self.backlash == 0.0 { self.push(&self.flank(x, x_dot, 0.0)) } else { self.of_flanks(x, x_dot) }
    }

    /// As [`torque`](Self::torque) with both flanks one-sided, whatever the gap: they press against each other where `b < 0`.
    #[inline]
    pub fn of_flanks(&self, x: f64, x_dot: f64) -> f64 {
        let [positive, negative] = [1.0, -1.0].map(|side| self.flank(x, x_dot, side));
        let pushed = if positive.p > 0.0 { self.push(&positive).max(0.0) } else { 0.0 };
        let pulled = if negative.p < 0.0 { self.push(&negative).min(0.0) } else { 0.0 };
        pushed + pulled
    }

    /// The flank that touches: +1, 0, −1. `flank` gives the state of the flank on each side. A gear without a gap is always in contact.
    pub fn touching(&self, flank: impl Fn(f64) -> Flank) -> i8 {
        if self.backlash == 0.0 || self.overlap(&flank(1.0)) > 0.0 {
            1
        } else if self.overlap(&flank(-1.0)) > 0.0 {
            -1
        } else {
            0
        }
    }

    /// As [`touching`](Self::touching) of a perfect gear.
    pub fn contact(&self, x: f64, x_dot: f64) -> i8 {
        self.touching(|side| self.flank(x, x_dot, side))
    }
}

//! The gap between the flanks of a gear: compliance outside it, nothing inside it, and a tooth never pulls.
//!
//! With the wind-up `x = θ − q` between rotor and link and `p = k (|x| − b/2)` the compression of the touching flank,
//!
//! ```text
//!        ⎧  max(0, k (x − b/2) + d ẋ)    x >  b/2      T
//!   T =  ⎨  0                           |x| ≤ b/2      |        /
//!        ⎩  min(0, k (x + b/2) + d ẋ)    x < −b/2      |_______/_______ x
//!                                                      /   −b/2  b/2
//! ```
//!
//! Without a gap (`b = 0`) both flanks touch under preload and nothing is one-sided: `T = k x + d ẋ`.
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

impl DeadZone {
    /// `T(x, ẋ)` [N·m or N], positive when it drives the link positively.
    pub fn torque(&self, x: f64, x_dot: f64) -> f64 {
        if self.backlash == 0.0 { self.pressed(x, x_dot) } else { self.of_flanks(x, x_dot) }
    }

    /// As [`torque`](Self::torque) with both flanks one-sided, whatever the gap: they press against each other where `b < 0`.
    pub fn of_flanks(&self, x: f64, x_dot: f64) -> f64 {
        let [p, n] = [1.0, -1.0].map(|side| self.compression(x, side));
        let positive = if p > 0.0 { self.pressed(p, x_dot).max(0.0) } else { 0.0 };
        let negative = if n < 0.0 { self.pressed(n, x_dot).min(0.0) } else { 0.0 };
        positive + negative
    }

    /// The flank that touches: +1, 0, −1. A gear without a gap is always in contact.
    pub fn contact(&self, x: f64, x_dot: f64) -> i8 {
        let overlap = |side: f64| self.overlap(side * x - 0.5 * self.backlash, side * x_dot);
        if self.backlash == 0.0 || overlap(1.0) > 0.0 {
            1
        } else if overlap(-1.0) > 0.0 {
            -1
        } else {
            0
        }
    }

    /// `p` [rad or m] of a flank (`side` ±1; 0: `x` itself), signed towards positive torque.
    #[inline(always)]
    pub fn compression(&self, x: f64, side: f64) -> f64 {
        x - 0.5 * side * self.backlash
    }

    /// `k p + d ṗ` [N·m or N] of a flank that touches.
    #[inline(always)]
    pub fn pressed(&self, p: f64, p_dot: f64) -> f64 {
        self.stiffness * p + self.damping * p_dot
    }

    /// How far [rad or m] a flank is from touching, or from letting go, `p` and `ṗ` counted into the flank: positive where it touches,
    /// which needs both, teeth that overlap and a force that pushes.
    #[inline(always)]
    pub fn overlap(&self, p: f64, p_dot: f64) -> f64 {
        p.min(p + p_dot * self.damping / self.stiffness)
    }
}

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
        let half = 0.5 * self.backlash;
        if self.backlash == 0.0 {
            self.stiffness * x + self.damping * x_dot
        } else if x > half {
            (self.stiffness * (x - half) + self.damping * x_dot).max(0.0)
        } else if x < -half {
            (self.stiffness * (x + half) + self.damping * x_dot).min(0.0)
        } else {
            0.0
        }
    }
}

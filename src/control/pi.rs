//! Plain proportional-integral velocity control, joint by joint.
//!
//! ```text
//!   τ = −K_P ė − K_I ∫ė dt,    ė = q̇ − q̇_d,  ∫ė dt = q − q_d
//! ```
//! It has no model of the arm: its integral compensates gravity and friction.

use super::{Controller, Motion, Target, Terms};

/// Gains of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PiGains {
    /// `K_P` [N·m·s/rad or N·s/m] > 0.
    pub proportional: f64,
    /// `K_I` [N·m/rad or N/m] ≥ 0.
    pub integral: f64,
}

/// One PI controller per joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Pi {
    gains: Vec<PiGains>,
}

impl Pi {
    /// One set of gains per joint.
    pub fn new(gains: Vec<PiGains>) -> Self {
        Self { gains }
    }
}

impl Controller for Pi {
    fn torque(&mut self, target: &[Target], Motion { q, v }: Motion, _terms: &Terms, tau: &mut [f64]) {
        for (i, PiGains { proportional, integral }) in self.gains.iter().enumerate() {
            tau[i] = -proportional * (v[i] - target[i].velocity) - integral * (q[i] - target[i].position);
        }
    }
}

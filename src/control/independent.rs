//! Control of each joint by itself, with the weight of the arm compensated: what most arms have.
//!
//! ```text
//!   S = ė + λ ∫ė dt,    ė = q̇ − q̇_d,  ∫ė dt = q − q_d
//!   τ_i = H_ii q̈_d + G_i(q) − K_S sat(S_i/Φ)
//! ```
//! It is [`SlidingMode`](super::SlidingMode) without the coupling of the joints: where gears yield, torques for the motion of a heavy link reach
//! the rotor of a light one before the motion does, and throw it off.
//! Within `|S| < Φ` it is linear: velocity gain `K_S/Φ`, position gain `λ K_S/Φ`. Coupling of the joints and friction are disturbances.

use super::{Controller, Motion, SlidingGains, Target, Terms, sat};

/// One controller per joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Independent {
    gains: Vec<SlidingGains>,
}

impl Independent {
    /// One set of gains per joint.
    pub fn new(gains: Vec<SlidingGains>) -> Self {
        Self { gains }
    }
}

impl Controller for Independent {
    fn torque(&mut self, target: &[Target], Motion { q, v }: Motion, Terms { h, g, .. }: &Terms, tau: &mut [f64]) {
        for (i, SlidingGains { lambda, switching, boundary }) in self.gains.iter().enumerate() {
            let s = v[i] - target[i].velocity + lambda * (q[i] - target[i].position);
            tau[i] = h[(i, i)] * target[i].acceleration + g[i] - switching * sat(s / boundary);
        }
    }
}

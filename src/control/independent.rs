//! Feedback of each joint by itself, with the torque of the planned motion and of the weight fed forward: what most arms have.
//!
//! ```text
//!   S = ė + λ ∫ė dt,    ė = q̇ − q̇_d,  ∫ė dt = q − q_d
//!   τ = H(q) q̈_d + G(q) − K_S sat(S/Φ)
//! ```
//! It is [`SlidingMode`](super::SlidingMode) without the coupling of errors, `H Λ ė` and `C Λ ∫ė dt`: where gears yield, the torque that a heavy link's
//! error asks of a light one reaches its rotor before the link moves, and throws it off.
//! Within `|S| < Φ` it is linear: velocity gain `K_S/Φ`, position gain `λ K_S/Φ`. Coriolis torques and friction are disturbances.

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
            let planned: f64 = target.iter().enumerate().map(|(j, target)| h[(i, j)] * target.acceleration).sum();
            tau[i] = planned + g[i] - switching * sat(s / boundary);
        }
    }
}

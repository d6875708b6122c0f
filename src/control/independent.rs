//! Independent feedback of each joint, with feedforward of gravity and of the planned motion's torque: the controller of most arms.
//!
//! ```text
//!   S = ė + λ ∫ė dt,    ė = q̇ − q̇_d,  ∫ė dt = q − q_d
//!   τ = H(q) q̈_d + G(q) − K_S sat(S/Φ)
//! ```
//! It is [`SlidingMode`](super::SlidingMode) without the coupling of errors, `H Λ ė` and `C Λ ∫ė dt`. With elastic gears, this coupling
//! is harmful: an error of a heavy link commands torque at a light joint, which drives away that joint's rotor before its link moves.
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

//! Sliding-mode velocity control with an integral term: equations 16 to 18 of the paper.
//!
//! ```text
//!   S = ė + Λ ∫ė dt,    ė = q̇ − q̇_d                                                      (16)
//!   τ = H(q)(q̈_d − Λ ė) + C(q, q̇)(q̇_d − Λ ∫ė dt) + G(q) − K_S sat(S/Φ)                   (18)
//! ```
//!
//! With `H q̈ + C q̇ + G + d = τ` (17) the error obeys `H Ṡ = −C S − K_S sat(S/Φ) − d`, and since `Ḣ − 2 C` is skew-symmetric
//! `V = ½ Sᵀ H S` (19) falls outside the boundary layer `|S_i| > Φ_i` while `|d_i| ≤ D_i < K_Si` (23).
//! Inside the layer it is linear: velocity gain `K_S/Φ + H Λ`, position gain `Λ K_S/Φ`. Where friction falls with speed
//! (`dF/dv < 0`), the layer stabilises the velocity only while `K_S/Φ > −dF/dv`.
//!
//! The integral of the velocity error is computed as a difference of positions, `∫ė dt = q − q_d`: it is exact if the
//! motion starts on its reference, and has no drift from errors of a measured velocity.
//! Left out: the gap; within it, `H` is too large by the inertia of the link.
//! Reference: L. Márton, B. Lantos (2009), section III.C.

use super::{Controller, Motion, Target, Terms};

/// Gains of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlidingGains {
    /// `λ` [1/s] > 0.
    pub lambda: f64,
    /// `K_S` [N·m or N] > 0, above the bound `D` of friction and everything else that the model lacks.
    pub switching: f64,
    /// `Φ` [rad/s or m/s] > 0.
    pub boundary: f64,
}

/// `sat(x)`: x within ±1, its sign outside.
pub fn sat(x: f64) -> f64 {
    x.clamp(-1.0, 1.0)
}

/// The controller of equation 18.
#[derive(Debug, Clone, PartialEq)]
pub struct SlidingMode {
    gains: Vec<SlidingGains>,
    /// `q̈_d − Λ ė`.
    acceleration: Vec<f64>,
    /// `q̇_d − Λ ∫ė`.
    velocity: Vec<f64>,
}

impl SlidingMode {
    /// One set of gains per joint.
    pub fn new(gains: Vec<SlidingGains>) -> Self {
        let zero = vec![0.0; gains.len()];
        Self { gains, acceleration: zero.clone(), velocity: zero }
    }

    /// `S` of a joint [rad/s or m/s].
    pub fn error_metric(&self, joint: usize, target: &Target, q: f64, v: f64) -> f64 {
        v - target.velocity + self.gains[joint].lambda * (q - target.position)
    }
}

impl Controller for SlidingMode {
    fn torque(&mut self, target: &[Target], Motion { q, v }: Motion, Terms { h, c, g }: &Terms, tau: &mut [f64]) {
        let n = self.gains.len();
        for i in 0..n {
            let lambda = self.gains[i].lambda;
            self.acceleration[i] = target[i].acceleration - lambda * (v[i] - target[i].velocity);
            self.velocity[i] = target[i].velocity - lambda * (q[i] - target[i].position);
        }
        for i in 0..n {
            let SlidingGains { switching, boundary, .. } = self.gains[i];
            let s = self.error_metric(i, &target[i], q[i], v[i]);
            let rigid: f64 = (0..n).map(|j| h[(i, j)] * self.acceleration[j] + c[(i, j)] * self.velocity[j]).sum();
            tau[i] = rigid + g[i] - switching * sat(s / boundary);
        }
    }
}

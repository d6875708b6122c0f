//! Positions of the flanks of a gear: the wind-up between rotor and link, and the lever at which a touching flank acts.
//!
//! ```text
//!   x = θ + ε(θ, t) − q          p = x ∓ g(θ) on the flank ±          ε = 0, g = b/2 for a perfect gear
//!   ṗ = λ θ̇ + ∂ε/∂t − q̇,         λ = 1 + ∂ε/∂θ ∓ ∂g/∂θ
//! ```
//! Virtual work: the torque `T = k p + d ṗ` drives the link, and `λ T` brakes the rotor. An offset that changes in time does work at
//! the rate `T ∂ε/∂t`.
//! Sign: a positive `ε` puts the link ahead of the rotor.
//! State: none; `ε` and `g` are functions of angle and time, altered by effects.
//! Left out: an offset that depends on the link's angle as well; the two angles differ by the wind-up alone.

use super::Flank;

/// Offset and half gap of a gear at an instant, with their slopes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mesh {
    /// `ε` [rad or m].
    pub offset: f64,
    /// `∂ε/∂θ` [1].
    pub offset_slope: f64,
    /// `∂ε/∂t` [rad/s or m/s].
    pub offset_rate: f64,
    /// `g` [rad or m] half the gap, ≥ 0.
    pub half_gap: f64,
    /// `∂g/∂θ` [1].
    pub half_gap_slope: f64,
}

impl Mesh {
    /// A perfect gear with this gap `b` [rad or m].
    pub const fn with_gap(backlash: f64) -> Self {
        Self { offset: 0.0, offset_slope: 0.0, offset_rate: 0.0, half_gap: 0.5 * backlash, half_gap_slope: 0.0 }
    }

    /// A flank (`side` ±1) under a rotor at `[θ, θ̇]` and a link at `[q, q̇]`.
    pub fn flank(&self, [theta, omega]: [f64; 2], [q, v]: [f64; 2], side: f64) -> Flank {
        Flank {
            side,
            p: theta + self.offset - q - side * self.half_gap,
            p_dot: self.lever(side) * omega + self.offset_rate - v,
        }
    }

    /// `λ` of a flank.
    pub fn lever(&self, side: f64) -> f64 {
        1.0 + self.offset_slope - side * self.half_gap_slope
    }
}

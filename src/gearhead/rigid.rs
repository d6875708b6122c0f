//! The spring of a gear whose stiffness is unknown: it counts as rigid outside its gap, as far as an integrator can follow.
//!
//! ```text
//!   k = min(ω²(J + M), ω_max²/A)       rotor J and link M at the joint
//!   A = 1/J + W                        rotor against link, W the acceleration of the link per torque, the other joints free
//!   d = T k
//! ```
//! With the first term, the spring yields by the share `(f/50 Hz)²` of a motion at frequency `f`: 4 % at 10 Hz, which is beyond the
//! bandwidth of a joint's controller. The second term limits the frequency `√(k A)` at which the rotor oscillates against the link,
//! which would otherwise need too many steps; it acts where a rotor has less than about a hundredth of its link's inertia.

use std::f64::consts::TAU;

use super::DeadZone;

/// `ω` [rad/s] Rotor and link together on the spring: 50 Hz, five times the 10 Hz that controllers of joints reach.
pub const OMEGA: f64 = TAU * 50.0;

/// `ω_max` [rad/s] Fastest oscillation of rotor against link: 500 Hz, some seven Runge-Kutta steps a millisecond.
pub const OMEGA_MAX: f64 = TAU * 500.0;

/// `T` [s] Damping over stiffness of a gear whose damping is unknown as well. The damping ratio `T ω/2` is 0.79 at 500 Hz: the fastest
/// mode dies out within a period and is not overdamped, which would need shorter steps.
pub const RELAXATION: f64 = 5e-4;

/// [1] Inertia of an unknown rotor at the joint, as a share of the link's. The acceleration needs a rotor's inertia in the
/// simulation. A twentieth is a third of the error (1σ 15 %) of a URDF's inertias, so that it hides nothing that was
/// known; a smaller share makes the rotor oscillate faster on its spring.
pub const ROTOR_SHARE: f64 = 0.05;

impl DeadZone {
    /// The flanks of a rigid gear: `inertia` is `J + M` [kg·m² or kg], `mobility` is `A` [1/(kg·m²) or 1/kg].
    pub fn rigid(backlash: f64, inertia: f64, mobility: f64) -> Self {
        let stiffness = (OMEGA * OMEGA * inertia).min(OMEGA_MAX * OMEGA_MAX / mobility);
        Self { backlash, stiffness, damping: RELAXATION * stiffness }
    }
}

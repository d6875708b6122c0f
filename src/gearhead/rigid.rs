//! The spring of a gear whose stiffness is unknown: it counts as rigid outside its gap, as far as an integrator can follow.
//!
//! ```text
//!   A = 1/J + W        rotor J against link, W the acceleration of the link per torque, the other joints free
//!   k = ω²/A           the rotor oscillates against the link at ω
//!   d = T k            damping ratio ζ = T ω/2 = 0.31
//! ```
//! Below ω the spring yields by `(f/100 Hz)²` of what is accelerated: 1 % at 10 Hz, the bandwidth of a joint's controller.

use std::f64::consts::TAU;

use super::DeadZone;

/// `ω` [rad/s] Mode of rotor against link: 100 Hz. Controllers of joints reach some 10 Hz, recordings at 1 kHz resolve 100 Hz with ten
/// samples a period, and the plant, which takes at least two steps a millisecond, follows 100 Hz without a further step.
pub const OMEGA: f64 = TAU * 100.0;

/// `T` [s] Damping over stiffness of a gear whose damping is unknown as well. The mode dies out within two periods, as that of a
/// lubricated gear does, and is not overdamped, which would need shorter steps.
pub const RELAXATION: f64 = 1e-3;

/// [1] Inertia of an unknown rotor at the joint, as a share of the link's. The acceleration needs a rotor's inertia in the
/// simulation. A twentieth is a third of the error (1σ 15 %) of a URDF's inertias, so that it hides nothing that was
/// known; a smaller share makes the spring that oscillates at [`OMEGA`] softer in the same proportion.
pub const ROTOR_SHARE: f64 = 0.05;

impl DeadZone {
    /// The flanks of a rigid gear: `mobility` is `A` [1/(kg·m²) or 1/kg].
    pub fn rigid(backlash: f64, mobility: f64) -> Self {
        let stiffness = OMEGA * OMEGA / mobility;
        Self { backlash, stiffness, damping: RELAXATION * stiffness }
    }
}

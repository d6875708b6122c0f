//! A gearhead with its parameters: friction on both sides of a gap, and the flanks between them.
//!
//! ```text
//!   F_r = (1 − s) F(θ̇)         rotor side, s = `link_share`
//!   T(x, ẋ)                    flanks: `dead_zone`
//!   F_l = s F(q̇) + F_b         link side, F_b: friction of the link's own bearing
//! ```
//! Sign: a side's friction opposes its velocity; `T` positive drives the link positively.
//! State: the slip of each side, or that it sticks ([`Slip`](super::Slip)); which flank touches; the memory of the friction.
//! Left out: effects, which alter these laws where a machine has them.
//! Reference: L. Márton, B. Lantos (2009), equations 2 to 6, with the friction split between the sides of the gap.

use super::{DeadZone, Friction, Grip, Memory};

/// The component between rotor and link.
#[derive(Debug, Clone, PartialEq)]
pub struct Gearhead {
    /// Gap, stiffness and damping of the flanks.
    pub dead_zone: DeadZone,
    /// Friction of the rotor side.
    pub rotor: Grip,
    /// Friction of the link side.
    pub link: Grip,
    /// Memory of the friction of the rotor side; `None`: it has none.
    pub memory: Option<Memory>,
}

impl Gearhead {
    /// A gear with this friction. `bearing` [N·m or N] ≥ 0 is the friction of the link's own bearing, the same at any speed.
    pub fn new(dead_zone: DeadZone, friction: Option<&Friction>, bearing: f64) -> Self {
        let [rotor, link] = friction.map_or([0.0; 2], |friction| [1.0 - friction.link_share, friction.link_share]);
        Self {
            dead_zone,
            rotor: Grip::new(friction, rotor, 0.0),
            link: Grip::new(friction, link, bearing),
            memory: None,
        }
    }
}

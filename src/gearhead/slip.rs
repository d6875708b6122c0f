//! Modes of a body under dry friction: it sticks, or it slips in one direction or the other.
//!
//! ```text
//!   stuck        v = 0, F takes any value in [−F(0⁻), F(0⁺)]
//!   slips ±      ± v ≥ 0, F = ± F(|v|)                          fast: beyond the kink of a law of two lines
//! ```
//! Within a mode friction is a smooth function of the velocity: an integrator steps within the mode and locates its end.
//! Sign: that of the velocity.

use super::Direction;

/// Which way a body slips against its friction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slip {
    /// There is no friction.
    Free,
    /// It rests, and friction holds it.
    Stuck,
    /// It slips, v ≥ 0.
    Positive,
    /// It slips, v ≤ 0.
    Negative,
    /// It slips, v ≥ the kink of its law.
    FastPositive,
    /// It slips, v ≤ −the kink of its law.
    FastNegative,
}

impl Slip {
    /// Slips in a direction, beyond the kink of its law or before it.
    pub const fn of(direction: Direction, fast: bool) -> Self {
        match (direction, fast) {
            (Direction::Positive, false) => Self::Positive,
            (Direction::Negative, false) => Self::Negative,
            (Direction::Positive, true) => Self::FastPositive,
            (Direction::Negative, true) => Self::FastNegative,
        }
    }

    /// The direction, while it slips against friction.
    pub const fn direction(self) -> Option<Direction> {
        match self {
            Self::Positive | Self::FastPositive => Some(Direction::Positive),
            Self::Negative | Self::FastNegative => Some(Direction::Negative),
            Self::Free | Self::Stuck => None,
        }
    }

    /// Whether it slips beyond the kink of its law.
    pub const fn is_fast(self) -> bool {
        matches!(self, Self::FastPositive | Self::FastNegative)
    }

    /// +1 or −1 while it slips against friction, else 0.
    #[inline(always)]
    pub const fn sign(self) -> f64 {
        [0.0, 0.0, 1.0, -1.0, 1.0, -1.0][self as usize]
    }

    /// Begins to slip in the direction of a torque.
    pub const fn towards(torque: f64) -> Self {
        if torque < 0.0 { Self::Negative } else { Self::Positive }
    }
}

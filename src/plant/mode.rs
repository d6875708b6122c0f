//! Modes of a joint: within a mode all laws are smooth, and a margin that turns negative ends it.

use crate::gearhead::Direction;

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
}

impl Slip {
    /// The direction, while it slips against friction.
    pub const fn direction(self) -> Option<Direction> {
        match self {
            Self::Positive => Some(Direction::Positive),
            Self::Negative => Some(Direction::Negative),
            Self::Free | Self::Stuck => None,
        }
    }

    /// Slips in the direction of a torque.
    pub const fn towards(torque: f64) -> Self {
        if torque < 0.0 { Self::Negative } else { Self::Positive }
    }

    /// Distance from the end of the mode, negative beyond it: the speed while it slips; while it sticks, what friction can
    /// still take above the torque `hold` that it balances, `holds` being its breakaway level in a direction.
    pub fn margin(self, velocity: f64, hold: f64, holds: impl Fn(Direction) -> f64) -> f64 {
        match self {
            Self::Free => f64::INFINITY,
            Self::Positive => velocity,
            Self::Negative => -velocity,
            Self::Stuck => holds(Direction::of(hold)) - hold.abs(),
        }
    }
}

/// The modes of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mode {
    /// Flank that touches: +1, 0 in the gap, −1.
    pub contact: i8,
    /// Friction of the rotor.
    pub rotor: Slip,
    /// Friction of the link.
    pub link: Slip,
    /// Voltage limit that is met: +1, 0, −1.
    pub saturation: i8,
}

/// What can end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// A flank is touched or left.
    Contact,
    /// The rotor comes to rest or breaks away.
    Rotor,
    /// The link comes to rest or breaks away.
    Link,
    /// The voltage limit is met or left.
    Saturation,
}

impl Change {
    /// All, in the order of [`Margins`].
    pub const ALL: [Self; 4] = [Self::Contact, Self::Rotor, Self::Link, Self::Saturation];
}

/// Whose mode ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// One of a joint.
    Joint(usize, Change),
    /// A barrier is touched or left.
    Barrier(usize),
}

/// Distances from the ends of a joint's modes, in the order of [`Change::ALL`]; negative beyond the end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margins(pub [f64; 4]);

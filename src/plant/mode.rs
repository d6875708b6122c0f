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
    /// The rotor comes to rest or breaks away, or passes the kink of its friction law.
    Rotor,
    /// The link comes to rest or breaks away, or passes the kink of its friction law.
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

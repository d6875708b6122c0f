//! Modes of a joint: within a mode all laws are smooth, and a margin that turns negative ends it.

use crate::gearhead::Slip;

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

/// Which mode of a joint ends.
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
    /// A mode of a joint.
    Joint(usize, Change),
    /// A barrier is touched or left.
    Barrier(usize),
}

/// Distances from the ends of a joint's modes, in the order of [`Change::ALL`]; negative beyond the end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margins(pub [f64; 4]);

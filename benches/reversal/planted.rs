//! A machine by seed with one of the effects of the reversal zone in it, or with none: the sets of the blind tests, in memory.

use lostmotion::robot::{EffectEntry, Model};
use lostmotion::timeseries::TimeSeries;

use super::drawn::Drawn;
use super::hidden::Order;

/// Recordings of one machine.
pub struct Set {
    /// What the program is given.
    pub nominal: Model,
    /// Staircase and three fast runs.
    pub sessions: Vec<TimeSeries>,
    /// What is in the machine.
    pub entries: Vec<EffectEntry>,
}

/// Draws a machine, puts the effect in it, and records it.
pub fn set(order: &Order) -> Set {
    let drawn = Drawn::new(order);
    let sessions = drawn.sessions().collect();
    Set { nominal: drawn.nominal, sessions, entries: drawn.entries }
}

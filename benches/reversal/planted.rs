//! A machine by seed with one of the effects of the reversal zone in it, or with none: the sets of the blind tests, in memory.

use std::path::Path;

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
    let machine = &drawn.machine;
    let nominal =
        Model::from_texts(&machine.nominal(), &machine.urdf(), Path::new("model.toml")).expect("a good model");
    Set { nominal, sessions: drawn.sessions().collect(), entries: drawn.entries }
}

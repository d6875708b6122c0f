//! Recordings → phenomena that the torque of smooth rows does not show.
//!
//! An instrument measures; it does not know which effects there are. What it measures is a [`Sighting`](claims::Sighting), and the effect of the
//! catalogue that [claims](crate::effects::Effect::claims) the phenomenon is named. What no effect claims is unexplained.
//! `ripple` and `reversal` have no phenomenon of their own: they fit effects, on narrow rows and on rows around turns.
//!
//! | instrument | looks at | for |
//! |---|---|---|
//! | `current_lag` | transients of torque and acceleration | a current that is recorded late |
//! | `lines` | samples while flanks touch | lines at a fixed frequency |
//! | `ripple`, `order_lines` | narrow rows while a joint moves on | lines of many periods a turn |
//! | `command` | commands and currents | a dead band of the drive |
//! | `slip` | throws of the rotor against the link | a coupling that slips once |
//! | `two_encoders` | motor against link encoder | delay, wind-up, gap |
//! | `reversal` | turns, against a simulation of the gear | what friction and gear do there |

mod as_recorded;
pub mod claims;
pub mod command;
pub mod current_lag;
pub mod lines;
mod order_lines;
pub mod preparation;
pub mod removal;
pub mod reversal;
pub mod ripple;
pub mod slip;
pub mod two_encoders;

use crate::diagnose::fit::problem::Problem;
use crate::diagnose::options::Options;
use crate::diagnose::result::Findings;
use crate::diagnose::rows::division::Division;
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::TimeSeries;
use as_recorded::AsRecorded;
use two_encoders::Encoders;

/// An instrument that reads a scene: the [`Recordings`] themselves, or [`FittedRows`] of them.
pub trait Instrument<S>: Sync {
    /// Measures.
    ///
    /// # Errors
    /// A session lacks a channel of a joint, or there is too little motion.
    fn measure(&self, scene: &S) -> Result<Measurement>;
}

/// What is measured before rows are made, each on recordings without what those before it have found: one disturbs the next.
pub const ON_RECORDINGS: [&dyn for<'s> Instrument<Recordings<'s>>; 3] =
    [&current_lag::CurrentLag, &lines::Lines, &ripple::Ripple];

/// What is measured beside the fit.
pub const ON_ROWS: [&dyn for<'s> Instrument<FittedRows<'s>>; 4] =
    [&command::Command, &slip::Slip, &two_encoders::TwoEncoders, &reversal::Reversal];

/// Recordings before rows are made.
pub struct Recordings<'s> {
    /// The nominal machine.
    pub model: &'s Model,
    /// The sessions.
    pub sessions: &'s [&'s TimeSeries],
    /// Which part of them is trained on.
    pub division: Division,
    /// What can be chosen.
    pub options: &'s Options,
}

/// Recordings with the rows and the fit that were made of them.
pub struct FittedRows<'s> {
    /// Rows and zones.
    pub problem: &'s Problem<'s>,
    /// The sessions.
    pub sessions: &'s [&'s TimeSeries],
    /// Which part of them is trained on.
    pub division: Division,
    /// What can be chosen.
    pub options: &'s Options,
    /// Torque that the fit leaves over, `left[joint][row]` [N·m or N].
    pub left: &'s [Vec<f64>],
    /// Whether a fast torque was taken off: what is left of it shakes the joints where they turn around, and no turn is judged.
    pub shaken: bool,
}

/// What an instrument has found.
#[derive(Default)]
pub struct Measurement {
    /// Effects, and what no effect explains.
    pub findings: Findings,
    /// The sessions without it; empty where nothing was taken off.
    pub corrected: Vec<TimeSeries>,
    /// Whether a fast torque was taken off.
    pub shaken: bool,
    /// Joint and order of each line that was taken off.
    pub lines: Vec<(usize, f64)>,
    /// The nominal model beside the recordings as they are, where that is known.
    pub as_recorded: Option<AsRecorded>,
    /// What second encoders say.
    pub encoders: Option<Encoders>,
}

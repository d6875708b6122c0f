//! Recordings → phenomena that the torque of smooth rows does not show.
//!
//! An instrument measures and does not know the effects. Its result is a [`Sighting`](claims::Sighting); the effect of the
//! catalogue that [claims](crate::effects::Effect::claims) the phenomenon is named. A phenomenon that no effect claims is unexplained.
//! `ripple` and `reversal` have no phenomenon of their own: they fit effects, on narrow rows and on rows around reversals.
//!
//! | instrument | uses | measures |
//! |---|---|---|
//! | `current_lag` | transients of torque and acceleration | the delay of a late current |
//! | `lines` | samples while a joint keeps moving | lines at a fixed frequency |
//! | `ripple`, `order_lines` | narrow rows while a joint keeps moving | lines of many periods per turn |
//! | `command` | commands and currents | the dead band of a drive |
//! | `slip` | jumps of the rotor against the link | a coupling that slips once |
//! | `velocity_lag` | velocity channel against the derivative of the position | its delay and low-pass |
//! | `two_encoders` | motor encoder against link encoder | delay, wind-up, gap |
//! | `reversal` | reversals, against a simulation of the gear | friction and gear at reversals |
//!
//! `preparation` runs the first three before the rows are made. `removal` subtracts the torque of named effects from recordings,
//! `as_recorded` keeps the residual of the nominal model on the original recordings, and `claims` assigns phenomena to effects.

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
pub mod velocity_lag;

use crate::diagnose::fit::problem::Problem;
use crate::diagnose::options::Options;
use crate::diagnose::result::Findings;
use crate::diagnose::rows::division::Division;
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::TimeSeries;
use as_recorded::AsRecorded;
use two_encoders::Encoders;

/// An instrument for a scene: the [`Recordings`], or [`FittedRows`] made from them.
pub trait Instrument<S>: Sync {
    /// Runs the measurement.
    ///
    /// # Errors
    /// A session lacks a channel of a joint, or there is too little motion.
    fn measure(&self, scene: &S) -> Result<Measurement>;
}

/// Instruments that run before rows are made. Each uses the recordings corrected by the previous ones, because one phenomenon disturbs the next.
pub const ON_RECORDINGS: &[&dyn for<'s> Instrument<Recordings<'s>>] =
    &[&current_lag::CurrentLag, &lines::Lines, &ripple::Ripple];

/// The same where the delay of currents is left to the rows.
pub const WITHOUT_DELAY: &[&dyn for<'s> Instrument<Recordings<'s>>] = &[&lines::Lines, &ripple::Ripple];

/// Instruments that run beside the fit.
pub const ON_ROWS: [&dyn for<'s> Instrument<FittedRows<'s>>; 5] =
    [&command::Command, &slip::Slip, &two_encoders::TwoEncoders, &velocity_lag::VelocityLag, &reversal::Reversal];

/// Instruments of a comparison. The others name effects of the problem's catalogue, which is empty there: they would use memory and time for nothing.
pub const ON_ROWS_OF_TWO: [&dyn for<'s> Instrument<FittedRows<'s>>; 2] =
    [&two_encoders::TwoEncoders, &velocity_lag::VelocityLag];

/// Recordings before rows are made.
pub struct Recordings<'s> {
    /// The nominal machine.
    pub model: &'s Model,
    /// The sessions.
    pub sessions: &'s [&'s TimeSeries],
    /// Division into training and held-out data.
    pub division: Division,
    /// Options of the diagnosis.
    pub options: &'s Options,
}

/// Recordings with their rows and the fit.
pub struct FittedRows<'s> {
    /// Rows and zones.
    pub problem: &'s Problem<'s>,
    /// The sessions.
    pub sessions: &'s [&'s TimeSeries],
    /// Division into training and held-out data.
    pub division: Division,
    /// Options of the diagnosis.
    pub options: &'s Options,
    /// Residual torque of the fit, `left[joint][row]` [N·m or N].
    pub left: &'s [Vec<f64>],
    /// Whether a fast torque was removed: its remainder shakes the joints at their reversals, so no reversal is judged.
    pub shaken: bool,
}

/// Result of an instrument.
#[derive(Default)]
pub struct Measurement {
    /// Effects that are named or withdrawn, and what no effect explains.
    pub findings: Findings,
    /// The corrected sessions; empty where nothing was removed.
    pub corrected: Vec<TimeSeries>,
    /// [s] How much earlier their currents are.
    pub delay: f64,
    /// Whether a fast torque was removed.
    pub shaken: bool,
    /// Joint and order of each line that was removed.
    pub lines: Vec<(usize, f64)>,
    /// The nominal model on the original recordings, where it is known.
    pub as_recorded: Option<AsRecorded>,
    /// Results of second encoders.
    pub encoders: Option<Encoders>,
}

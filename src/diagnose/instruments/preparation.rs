//! Recordings without phenomena that disturb wide rows: a late current, lines at a fixed frequency, fast ripple.
//!
//! Wide rows do not show these phenomena correctly, and each of them disturbs the fit there. Each is measured in the training data, and removed
//! where that gains on held-out data.

use std::borrow::Cow;

use super::as_recorded::AsRecorded;
use super::{Instrument, Measurement, Recordings};
use crate::diagnose::options::Options;
use crate::diagnose::result::Findings;
use crate::diagnose::rows::division::Division;
use crate::error::Result;
use crate::robot::{Masses, Model};
use crate::timeseries::TimeSeries;

/// Recordings prepared for wide rows.
pub struct Prepared<'s> {
    /// The recordings, original or corrected.
    pub sessions: Vec<Cow<'s, TimeSeries>>,
    /// [s] How much earlier their currents are.
    pub delay: f64,
    /// What was named or withdrawn before the rows.
    pub earlier: Findings,
    /// Whether a fast torque was removed.
    pub shaken: bool,
    /// Joint and order of each ripple that was removed.
    pub ripple: Vec<(usize, f64)>,
    /// The nominal model on the original recordings, if they were corrected.
    pub as_recorded: Option<AsRecorded>,
}

/// Runs the instruments on the recordings, in the order in which one phenomenon disturbs the next.
///
/// # Errors
/// A session lacks a channel of a joint, or there is too little motion.
pub fn prepare<'s>(
    model: &Model,
    recorded: &[&'s TimeSeries],
    division: Division,
    options: &Options,
    instruments: &[&dyn for<'r> Instrument<Recordings<'r>>],
) -> Result<Prepared<'s>> {
    let sessions = recorded.iter().map(|session| Cow::Borrowed(*session)).collect();
    let (earlier, ripple, as_recorded) = (Findings::default(), Vec::new(), None);
    let mut prepared = Prepared { sessions, delay: 0.0, earlier, shaken: false, ripple, as_recorded };
    // With estimated masses, the torque is no evidence for an effect.
    if model.masses == Masses::Estimated {
        return Ok(prepared);
    }
    for instrument in instruments {
        let sessions = prepared.borrowed();
        let reading = instrument.measure(&Recordings { model, sessions: &sessions, division, options })?;
        prepared.take(reading);
    }
    let corrected = prepared.sessions.iter().any(|session| matches!(session, Cow::Owned(_)));
    if corrected && prepared.as_recorded.is_none() {
        prepared.as_recorded = Some(AsRecorded::new(model, recorded, division, options)?);
    }
    Ok(prepared)
}

impl Prepared<'_> {
    /// The recordings.
    fn borrowed(&self) -> Vec<&TimeSeries> {
        self.sessions.iter().map(AsRef::as_ref).collect()
    }

    /// Adds a measurement and its corrected recordings.
    fn take(&mut self, reading: Measurement) {
        self.earlier.merge(reading.findings);
        self.delay += reading.delay;
        self.shaken |= reading.shaken;
        self.ripple.extend(reading.lines);
        self.as_recorded = self.as_recorded.take().or(reading.as_recorded);
        if !reading.corrected.is_empty() {
            self.sessions = reading.corrected.into_iter().map(Cow::Owned).collect();
        }
    }
}

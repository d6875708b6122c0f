//! Recordings without what disturbs wide rows: a late current, lines in time, fast ripple.
//!
//! None of them shows in wide rows as what it is, and each disturbs what is judged there. Each is found in what is trained on, and taken off
//! where it gains on what is held out.

use std::borrow::Cow;

use super::as_recorded::AsRecorded;
use super::{Measurement, ON_RECORDINGS, Recordings};
use crate::diagnose::options::Options;
use crate::diagnose::result::Findings;
use crate::diagnose::rows::division::Division;
use crate::error::Result;
use crate::robot::{Masses, Model};
use crate::timeseries::TimeSeries;

/// Recordings ready for wide rows.
pub struct Prepared<'s> {
    /// The recordings, as they are or corrected.
    pub sessions: Vec<Cow<'s, TimeSeries>>,
    /// What was named, or withdrawn.
    pub earlier: Findings,
    /// Whether a fast torque was taken off.
    pub shaken: bool,
    /// Joint and order of each ripple that was taken off.
    pub ripple: Vec<(usize, f64)>,
    /// The nominal model beside the recordings as they are, where they were corrected.
    pub as_recorded: Option<AsRecorded>,
}

/// Looks for what has to be taken off, in the order in which one disturbs the next.
///
/// # Errors
/// A session lacks a channel of a joint, or there is too little motion.
pub fn prepare<'s>(
    model: &Model,
    recorded: &[&'s TimeSeries],
    division: Division,
    options: &Options,
) -> Result<Prepared<'s>> {
    let sessions = recorded.iter().map(|session| Cow::Borrowed(*session)).collect();
    let mut prepared =
        Prepared { sessions, earlier: Findings::default(), shaken: false, ripple: Vec::new(), as_recorded: None };
    // Where masses are a guess, no torque is evidence of anything.
    if model.masses == Masses::Estimated {
        return Ok(prepared);
    }
    for instrument in ON_RECORDINGS {
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

    /// Takes what was measured off the recordings.
    fn take(&mut self, reading: Measurement) {
        self.earlier.merge(reading.findings);
        self.shaken |= reading.shaken;
        self.ripple.extend(reading.lines);
        self.as_recorded = self.as_recorded.take().or(reading.as_recorded);
        if !reading.corrected.is_empty() {
            self.sessions = reading.corrected.into_iter().map(Cow::Owned).collect();
        }
    }
}

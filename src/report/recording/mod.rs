//! A document and the motions behind it as a recording for the Rerun viewer: the arm moving, its traces, the plots and the result.
//!
//! The only place that names rerun. Without the feature `rerun` there are no recordings, and [`encode`] returns `None`.

mod traces;

#[cfg(feature = "rerun")]
mod arm;
#[cfg(feature = "rerun")]
mod blueprint;
#[cfg(feature = "rerun")]
mod canvas;
#[cfg(feature = "rerun")]
mod stream;

use crate::error::Result;
use crate::robot::Robot;
use crate::timeseries::TimeSeries;

use super::document::Document;

pub use traces::Trace;

/// A machine in motion.
#[derive(Debug, Clone)]
pub struct Motion<'a> {
    /// The machine.
    pub robot: &'a Robot,
    /// One session of it; joints that it lacks stand at zero.
    pub session: &'a TimeSeries,
    /// What is shown beside the channels of the session: residuals, predictions.
    pub traces: Vec<Trace>,
}

impl<'a> Motion<'a> {
    /// A session without further traces.
    pub const fn new(robot: &'a Robot, session: &'a TimeSeries) -> Self {
        Self { robot, session, traces: Vec::new() }
    }
}

/// The content of `trace.rrd`: motions one after the other on one time line, all plots, and the document as text. `None` without the feature `rerun`.
///
/// # Errors
/// The recording cannot be encoded.
#[cfg(feature = "rerun")]
pub fn encode(document: &Document, motions: &[Motion<'_>]) -> Result<Option<Vec<u8>>> {
    stream::encode(document, motions).map(Some)
}

/// No recording without the feature `rerun`.
///
/// # Errors
/// None.
#[cfg(not(feature = "rerun"))]
pub const fn encode(_document: &Document, _motions: &[Motion<'_>]) -> Result<Option<Vec<u8>>> {
    Ok(None)
}

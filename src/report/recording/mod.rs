//! A document and the motions behind it as a recording for the Rerun viewer: the arm moving, its traces, the plots and the result.
//!
//! The only place that names rerun. Without the feature `rerun` there are no recordings, and [`encode`] returns `None`.

#[cfg(feature = "rerun")]
mod arm;
#[cfg(feature = "rerun")]
mod blueprint;
#[cfg(feature = "rerun")]
mod canvas;
#[cfg(feature = "rerun")]
mod stream;
#[cfg(feature = "rerun")]
mod traces;

use crate::error::Result;
use crate::plant::Obstacle;
use crate::robot::Robot;
use crate::timeseries::TimeSeries;

use super::document::Document;
use super::plot::Role;

/// A machine in motion.
#[derive(Debug, Clone)]
pub struct Motion<'a> {
    /// The machine.
    pub robot: &'a Robot,
    /// One session of it; joints that it lacks stand at zero.
    pub session: &'a TimeSeries,
    /// What stands in its way.
    pub obstacles: &'a [Obstacle],
    /// What is shown beside the channels of the session: residuals, predictions.
    pub traces: Vec<Trace>,
}

/// A curve over time of one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// The joint.
    pub joint: String,
    /// Curves of the same panel share an axis: "velocity", "residual".
    pub panel: &'static str,
    /// What it is; also the last part of its path in the recording.
    pub label: &'static str,
    /// Decides its colour.
    pub role: Role,
    /// [s] Sample times.
    pub time: Vec<f64>,
    /// Values, in the unit of the panel.
    pub values: Vec<f64>,
}

impl<'a> Motion<'a> {
    /// A session without further traces.
    pub const fn new(robot: &'a Robot, session: &'a TimeSeries) -> Self {
        Self { robot, session, obstacles: &[], traces: Vec::new() }
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

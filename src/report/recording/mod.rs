//! A document and its motions as a recording for the Rerun viewer: the moving arm, its traces, the plots and the
//! result.
//!
//! The only place that names rerun. Without the feature `rerun` there are no recordings, and [`encode`] returns `None`.

#[cfg(feature = "rerun")]
mod arm;
#[cfg(feature = "rerun")]
mod blueprint;
#[cfg(feature = "rerun")]
mod canvas;
#[cfg(feature = "rerun")]
mod entities;
#[cfg(feature = "rerun")]
mod stream;
#[cfg(feature = "rerun")]
mod traces;

use crate::error::Result;
use crate::plant::Obstacle;
use crate::robot::Robot;
use crate::timeseries::{Drawn, Envelope};

use super::document::Document;
use super::plot::{Frame, Plot, Role};

/// A machine in motion.
#[derive(Debug, Clone)]
pub struct Motion<'a> {
    /// The machine.
    pub robot: &'a Robot,
    /// One session, reduced for display; joints that it lacks are drawn at zero.
    pub session: Drawn,
    /// Obstacles.
    pub obstacles: &'a [Obstacle],
    /// Curves beside the channels of the session: residuals, predictions.
    pub traces: Vec<Trace>,
}

/// A curve over time of one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// The joint.
    pub joint: String,
    /// Curves of the same panel share an axis: "velocity", "residual".
    pub panel: &'static str,
    /// Its label; also the last part of its path in the recording.
    pub label: &'static str,
    /// Determines its colour.
    pub role: Role,
    /// [s] Sample times.
    pub time: Vec<f64>,
    /// Values, in the unit of the panel.
    pub values: Vec<f64>,
}

impl Trace {
    /// Its samples, reduced for display: lowest and highest of each short stretch. A trace that is already reduced
    /// stays unchanged.
    #[must_use]
    pub fn thinned(self) -> Self {
        let Envelope { time, values, .. } = Envelope::of(&self.time, self.values.iter().copied());
        Self { time, values, ..self }
    }
}

impl<'a> Motion<'a> {
    /// A session without further traces.
    pub const fn new(robot: &'a Robot, session: Drawn) -> Self {
        Self { robot, session, obstacles: &[], traces: Vec::new() }
    }
}

/// Width and height of the canvas of a plot.
const CANVAS: [f64; 2] = [640.0, 400.0];

/// The frame of a plot.
pub fn canvas_frame(plot: &Plot) -> Frame {
    let labelled = plot.layers.iter().filter(|layer| !layer.points.is_empty() && !layer.label.is_empty());
    #[expect(clippy::cast_precision_loss, reason = "a handful")]
    let rows = labelled.count().div_ceil(2) as f64;
    Frame::new(plot, [70.0, CANVAS[0] - 15.0], [15.0 + 22.0 * rows, CANVAS[1] - 55.0])
}

/// The content of `trace.rrd`: motions in sequence on one time line, all plots, and the document as text. `None`
/// without the feature `rerun`.
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

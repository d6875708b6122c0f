//! Residuals in the result of a diagnosis: shares, maps, spectra, series.

use serde::Serialize;

use super::Split;
use crate::units::JointKind;

/// The error of one joint before any effect is fitted: the nominal model with its free parameters fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointShares {
    /// The joint.
    pub joint: String,
    /// `torque` or `force`.
    pub quantity: &'static str,
    /// Unit of the errors.
    pub unit: &'static str,
    /// RMS error over the rigid zone of the held-out data.
    pub rms: f64,
    /// [%] The same, relative to the RMS of the measured torque.
    pub torque_percent: f64,
    /// RMS error that sensor noise and quantisation alone would leave there.
    pub floor: f64,
    /// Shares of the zones in the squared torque error of the simulated nominal model; `None` until it has been replayed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zones: Option<ZoneShares>,
    /// Share of the squared error over the rigid zone of all data that each single quantity explains, simplest quantity first.
    pub axes: Vec<AxisShare>,
}

/// Zone of a row of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Zone {
    /// The link is known to follow the rotor.
    Rigid,
    /// From shortly before to 0.4 s after a reversal.
    Reversal,
    /// A change of flank, a reversal of another joint, or standstill.
    Rest,
}

/// Parts of a squared error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ZoneShares {
    /// [%] where the link is known to follow the rotor.
    pub rigid_percent: f64,
    /// [%] from shortly before to 0.4 s after reversals.
    pub reversal_percent: f64,
    /// [%] elsewhere: changes of flank, reversals of other joints, standstill.
    pub rest_percent: f64,
    /// [%] of the time that each of the three takes, in this order.
    pub time_percent: [f64; 3],
}

/// Share of the squared error that one quantity explains beyond chance: by its binned mean, tested on other data than it was computed from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AxisShare {
    /// The quantity.
    pub axis: Axis,
    /// [%] explained, with separate means for the two directions of motion.
    pub share_percent: f64,
    /// [%] explained by the part that is equal in both directions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alike_percent: Option<f64>,
    /// [%] explained by the part that changes its sign with the direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opposed_percent: Option<f64>,
    /// [Hz] Frequency of the strongest line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency: Option<f64>,
}

/// A quantity on which a residual may depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// No dependence: a constant.
    Constant,
    /// Sign of the velocity: −1 or 1.
    Direction,
    /// [rad/s or m/s]
    Velocity,
    /// [rad or m]
    Position,
    /// [N·m or N] torque through the gear.
    Load,
    /// [rad] angle of the motor shaft within a turn.
    MotorAngle,
    /// [rad/s² or m/s²]
    Acceleration,
    /// [s] since the last reversal, or before the next one.
    ReversalPhase,
    /// [s] since the start of a session.
    Time,
    /// [Hz]
    Frequency,
}

/// Mean residual in bins of one quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResidualMap {
    /// The joint.
    pub joint: String,
    /// The quantity of the bins.
    pub axis: Axis,
    /// Centre of each bin; bins without samples are left out.
    #[serde(serialize_with = "rounded")]
    pub centre: Vec<f64>,
    /// Samples in each bin.
    pub count: Vec<usize>,
    /// Mean residual of the nominal model.
    #[serde(serialize_with = "rounded")]
    pub before: Vec<f64>,
    /// Mean residual of the extended model.
    #[serde(serialize_with = "rounded")]
    pub after: Vec<f64>,
    /// Nominal model: half the sum of the mean residuals of both directions of motion; NaN (`null`) where one of them is missing.
    #[serde(serialize_with = "rounded", skip_serializing_if = "Vec::is_empty")]
    pub alike: Vec<f64>,
    /// Half their difference, positive minus negative direction.
    #[serde(serialize_with = "rounded", skip_serializing_if = "Vec::is_empty")]
    pub opposed: Vec<f64>,
    /// RMS that sensor noise and quantisation alone would leave in a sample of the bin.
    #[serde(serialize_with = "rounded")]
    pub floor: Vec<f64>,
}

/// Amplitude against the order of the motor angle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OrderSpectrum {
    /// The joint.
    pub joint: String,
    /// Periods per turn of the motor.
    pub order: Vec<f64>,
    /// [N·m or N] amplitude in the residual of the nominal model.
    #[serde(serialize_with = "rounded")]
    pub before: Vec<f64>,
    /// [N·m or N] amplitude in the residual of the extended model.
    #[serde(serialize_with = "rounded")]
    pub after: Vec<f64>,
    /// [N·m or N] amplitude that sensor noise and quantisation alone would show.
    pub floor: f64,
}

/// Amplitude against frequency in time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrequencySpectrum {
    /// The joint.
    pub joint: String,
    /// [Hz]
    pub frequency: Vec<f64>,
    /// [N·m or N] amplitude in the residual of the nominal model.
    #[serde(serialize_with = "rounded")]
    pub before: Vec<f64>,
    /// [N·m or N] amplitude in the residual of the extended model.
    #[serde(serialize_with = "rounded")]
    pub after: Vec<f64>,
    /// [N·m or N] amplitude that sensor noise and quantisation alone would show.
    pub floor: f64,
}

/// Residual of one joint in one session, one value per row.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualSeries {
    /// Name of the session.
    pub session: String,
    /// The joint.
    pub joint: String,
    /// Rotary or sliding joint.
    pub kind: JointKind,
    /// Part of the data.
    pub split: Split,
    /// [s]
    pub time: Vec<f64>,
    /// [rad or m] Smoothed motor position on the joint side.
    pub position: Vec<f64>,
    /// [rad/s or m/s]
    pub velocity: Vec<f64>,
    /// [rad] angle of the motor shaft.
    pub motor_angle: Vec<f64>,
    /// [N·m or N] torque through the gear.
    pub load: Vec<f64>,
    /// [N·m or N] Smoothed measured motor torque.
    pub torque: Vec<f64>,
    /// [N·m or N] Measured minus nominal torque.
    pub before: Vec<f64>,
    /// [N·m or N] Measured minus extended torque.
    pub after: Vec<f64>,
    /// Whether the row lies in the rigid zone, over which the errors are computed.
    pub rigid: Vec<bool>,
    /// The zone of the row.
    pub zone: Vec<Zone>,
}

/// Rounds to five significant digits, enough for a plot, which halves the size of the file. NaN becomes `null`.
fn rounded<S: serde::Serializer>(values: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(values.iter().map(|value| format!("{value:.4e}").parse::<f64>().unwrap_or(f64::NAN)))
}

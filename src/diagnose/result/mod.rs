//! What a diagnosis returns: the content of `report.json`, the extended model, and the series that a plot needs.

use std::collections::BTreeMap;

use serde::Serialize;

mod effects;
mod findings;
mod mistake;
mod parts;

pub use effects::{EffectGain, FoundEffect, Standing, Withdrawn};
pub use findings::Findings;
pub use mistake::Mistake;
pub use parts::Parts;

use crate::effects::Catalogue;
use crate::replay::Gain;
use crate::robot::Model;
use crate::timeseries::Estimate;
use crate::units::JointKind;

/// What the simulation gets wrong, and why.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// Always [`SCHEMA`](Self::SCHEMA).
    pub schema: &'static str,
    /// Versions of what made it.
    pub versions: BTreeMap<&'static str, &'static str>,
    /// The answer in one word.
    pub verdict: Verdict,
    /// Errors of data or model file that are likelier than physics; no effect is named then.
    pub mistakes: Vec<Mistake>,
    /// What was found, strongest first.
    pub effects: Vec<FoundEffect>,
    /// What is another size than it was, where two recordings are compared: `effects` are then those that were not there before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub changes: Option<Vec<Change>>,
    /// Torque errors before and after, per joint and part of the data.
    pub fit: Vec<FitError>,
    /// Errors of simulations beside the data, per joint and channel; empty until they have been replayed.
    pub replay: Vec<ReplayError>,
    /// Free parameters of the nominal model as fitted, by joint.
    pub baseline: BTreeMap<String, BaselineEstimate>,
    /// What second encoders behind the gears say; empty where there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub two_encoders: Vec<TwoEncoders>,
    /// Structure that remains and no effect of the catalogue explains.
    pub unexplained: Vec<Unexplained>,
    /// Effects that the training data support, without a gain on data held out or outside the range of a parameter.
    pub withdrawn: Vec<Withdrawn>,
    /// Every candidate that was tried, and what became of it.
    pub candidates: Vec<CandidateRecord>,
    /// How the data were read: filter, zones, held-out part.
    pub method: Method,
    /// Where the error of the nominal model lies, and what it depends on, per joint.
    pub shares: Vec<JointShares>,
    /// Maps of the residual against what may explain it, per joint.
    pub maps: Vec<ResidualMap>,
    /// Amplitude of the residual against the order of the motor angle, per joint.
    pub order_spectrum: Vec<OrderSpectrum>,
    /// Amplitude of the residual against frequency, per joint.
    pub frequency_spectrum: Vec<FrequencySpectrum>,
    /// The nominal model with the fitted baseline and the effects found: every command accepts it.
    #[serde(skip)]
    pub extended_model: Model,
    /// The nominal model with the fitted baseline alone.
    #[serde(skip)]
    pub baseline_model: Model,
    /// The effects that could be named.
    #[serde(skip)]
    pub catalogue: Catalogue,
    /// Residuals sample by sample, one for each session and joint.
    #[serde(skip)]
    pub series: Vec<ResidualSeries>,
}

impl Diagnosis {
    /// Version of the report's layout.
    pub const SCHEMA: &'static str = "lostmotion/diagnosis/1";
}

/// The answer in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Effects of the catalogue explain what the nominal model gets wrong.
    EffectsFound,
    /// The nominal model explains the data.
    NothingFound,
    /// Structure remains, and no effect of the catalogue explains it.
    Unexplained,
    /// Data or model file hold a mistake that is likelier than physics.
    MistakeSuspected,
}

impl Verdict {
    /// The verdict where something was named, or something remains.
    pub fn of(named: bool, remains: bool) -> Self {
        match (named, remains) {
            (true, _) => Self::EffectsFound,
            (false, true) => Self::Unexplained,
            (false, false) => Self::NothingFound,
        }
    }
}

/// A value with its uncertainty and unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measured {
    /// Estimate, SI.
    pub value: f64,
    /// Standard error, same unit, the autocorrelation of the residual counted.
    pub std_error: f64,
    /// Unit.
    pub unit: &'static str,
}

impl Measured {
    /// An estimate with its unit.
    pub const fn of(estimate: Estimate, unit: &'static str) -> Self {
        Self { value: estimate.value, std_error: estimate.std_error, unit }
    }
}

/// A quantity of the machine that is not what it was.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// `viscous`, `coulomb`, `breakaway`, `stribeck_velocity`, `rotor_inertia`, `torque_offset`, `backlash`.
    pub quantity: String,
    /// The joint.
    pub joint: String,
    /// What it was.
    pub reference: Measured,
    /// What it is.
    pub now: Measured,
    /// [%] of what it was, positive where there is more of it; what both sides get wrong alike is not in its standard error.
    pub change_percent: Measured,
    /// [standard errors] by which it has changed, what is natural from day to day counted as error.
    pub standing: f64,
    /// Probability that it has changed, 0 to 1.
    pub probability: f64,
}

/// Part of the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Split {
    /// Used for the fit.
    Train,
    /// Kept away from it.
    HeldOut,
}

/// RMS torque error of one joint over its rigid zone, or RMS error of its link's position where a second encoder shows it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitError {
    /// The joint.
    pub joint: String,
    /// `torque`, `force` or `link_position`.
    pub quantity: &'static str,
    /// Unit of the errors.
    pub unit: &'static str,
    /// Part of the data.
    pub split: Split,
    /// RMS error of the nominal model with its free parameters fitted.
    pub before: f64,
    /// RMS error of the extended model.
    pub after: f64,
    /// RMS error that sensor noise and quantisation alone would leave.
    pub floor: f64,
    /// [%] `before` relative to the RMS of the measured torque; of the difference of the two encoders for `link_position`.
    pub before_percent: f64,
    /// [%] `after` relative to the same.
    pub after_percent: f64,
    /// By how much `after` is below `before`, and whether that is more than chance.
    #[serde(flatten)]
    pub gain: Gain,
}

/// Error of a simulation in closed loop beside the data.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReplayError {
    /// The joint.
    pub joint: String,
    /// The channel: `position`, `velocity`, `torque` (`force` of a joint that slides).
    pub quantity: &'static str,
    /// Unit of the errors.
    pub unit: &'static str,
    /// Part of the data.
    pub split: Split,
    /// RMS error of the nominal model.
    pub before: f64,
    /// RMS error of the extended model.
    pub after: f64,
    /// By how much `after` is below `before`, and whether that is more than chance.
    #[serde(flatten)]
    pub gain: Gain,
}

/// Free parameters of the nominal model of one joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BaselineEstimate {
    /// `coulomb`, `breakaway`, `stribeck_velocity`, `viscous`.
    pub friction: BTreeMap<&'static str, Measured>,
    /// Total gap at the joint; `None` where the data could not tell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash: Option<Measured>,
    /// Why no gap was measured, where something that was found stands against it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash_left_out: Option<String>,
    /// Constant of the torque channel per session, where a torque rather than a current was recorded.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub torque_offset: BTreeMap<String, Measured>,
}

/// What the encoders before and behind a gear say together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TwoEncoders {
    /// The joint.
    pub joint: String,
    /// How late the second encoder is recorded, from this joint alone; negative where the first one is.
    pub link_delay: Measured,
    /// [%] of the square of their difference, a constant aside, that a delay alone explains.
    pub explained_by_delay_percent: f64,
    /// Wind-up per torque through the gear.
    pub wind_up: Measured,
    /// Its inverse, where the wind-up is more than twice its standard error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<Measured>,
    /// Total gap after the delay, unconstrained: less than 0 is noise. `None` where the load stays on one flank.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash: Option<Measured>,
    /// What the encoders differ more after a turn of the motion than friction before the gear makes them, where masses are estimated: a gap
    /// shows in it as far as the link follows the direction of motion and not the load.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost_motion: Option<Measured>,
    /// The gap that a fit without a delay would report.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash_without_delay: Option<Measured>,
}

/// Structure that no effect explains.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unexplained {
    /// The joint.
    pub joint: String,
    /// Its shape in words and numbers.
    pub pattern: String,
}

/// What became of a candidate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CandidateRecord {
    /// Name of the catalogue.
    pub effect: String,
    /// Joints it was tried on.
    pub joints: Vec<String>,
    /// [%] by which it alone lowers the squared residual of the baseline, cross-validated.
    pub gain_percent: f64,
    /// The gain at which clean data would name it once in a hundred [%].
    pub threshold_percent: f64,
    /// Whether it was named.
    pub named: bool,
    /// Why, in words.
    pub reason: String,
}

/// How the data were read.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Method {
    /// The kernel that torque and motion pass.
    pub filter: String,
    /// [s] smallest and largest half width of the kernel.
    pub half_width: [f64; 2],
    /// What of each session was left out, and why.
    pub zones: String,
    /// What the baseline frees.
    pub baseline: String,
    /// What was held out.
    pub held_out: String,
}

/// What the simulation gets wrong on one joint, before any cause is looked for: the nominal model with its free parameters fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointShares {
    /// The joint.
    pub joint: String,
    /// `torque` or `force`.
    pub quantity: &'static str,
    /// Unit of the errors.
    pub unit: &'static str,
    /// RMS error over the rigid zone of what is held out.
    pub rms: f64,
    /// [%] the same relative to the RMS of the measured torque.
    pub torque_percent: f64,
    /// RMS error that sensor noise and quantisation alone would leave there.
    pub floor: f64,
    /// Where the squared torque error of the nominal model in simulation lies; `None` until it has been replayed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zones: Option<ZoneShares>,
    /// What one quantity alone explains of the squared error over the rigid zone of all data, the simplest first.
    pub axes: Vec<AxisShare>,
}

/// What a joint does in a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Zone {
    /// The link is known to follow the rotor.
    Rigid,
    /// From shortly before to 0.4 s after a reversal.
    Reversal,
    /// A change of flank, a reversal of another joint, standstill.
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

/// What one quantity alone explains of the squared error, beyond chance: its binned mean on data that it was not made from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AxisShare {
    /// The quantity.
    pub axis: Axis,
    /// [%] explained, both directions of motion apart.
    pub share_percent: f64,
    /// [%] explained by what does not care about direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alike_percent: Option<f64>,
    /// [%] explained by what changes its sign with direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opposed_percent: Option<f64>,
    /// [Hz] of the strongest line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency: Option<f64>,
}

/// What a residual may depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// Nothing: the same everywhere.
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
    /// What the bins are of.
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
    /// Nominal model: half the sum of the means of both directions of motion; NaN (`null`) where one of them is missing.
    #[serde(serialize_with = "rounded", skip_serializing_if = "Vec::is_empty")]
    pub alike: Vec<f64>,
    /// Half their difference, positive less negative direction.
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

/// Five significant digits: what a plot can show, in half the bytes. NaN becomes `null`.
fn rounded<S: serde::Serializer>(values: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(values.iter().map(|value| format!("{value:.4e}").parse::<f64>().unwrap_or(f64::NAN)))
}

/// Residual of one joint in one session, one value a row.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualSeries {
    /// Name of the session.
    pub session: String,
    /// The joint.
    pub joint: String,
    /// Turning or sliding.
    pub kind: JointKind,
    /// Part of the data.
    pub split: Split,
    /// [s]
    pub time: Vec<f64>,
    /// [rad or m] smooth motor position on the joint side.
    pub position: Vec<f64>,
    /// [rad/s or m/s]
    pub velocity: Vec<f64>,
    /// [rad] angle of the motor shaft.
    pub motor_angle: Vec<f64>,
    /// [N·m or N] torque through the gear.
    pub load: Vec<f64>,
    /// [N·m or N] measured motor torque, smooth.
    pub torque: Vec<f64>,
    /// [N·m or N] measured minus nominal.
    pub before: Vec<f64>,
    /// [N·m or N] measured minus extended.
    pub after: Vec<f64>,
    /// Whether the row lies in the rigid zone, where the errors are judged.
    pub rigid: Vec<bool>,
    /// The zone of the row.
    pub zone: Vec<Zone>,
}

//! The result of a diagnosis: the content of `report.json`, the extended model, and the series for plots.
//!
//! Takes the findings of all stages and gives one `Diagnosis`.
//! - `effects`: named and withdrawn effects, with their gains
//! - `findings`: what a stage has found
//! - `judgement`: what the score of every sample says
//! - `mistake`: a suspected mistake in the data or in the model file
//! - `residuals`: shares, maps, spectra and series of residuals
//! - `parts`: the parts of a diagnosis, and the one place that assembles them

use std::collections::BTreeMap;

use serde::Serialize;

mod effects;
mod findings;
mod judgement;
mod mistake;
mod parts;
mod residuals;

pub use effects::{EffectGain, FoundEffect, Standing, Withdrawn};
pub use findings::Findings;
pub use judgement::{
    Distance, JudgedEffect, JudgedMachine, JudgedName, JudgedSet, JudgedWindow, Judgement, is_supported,
};
pub use mistake::Mistake;
pub use parts::Parts;
pub use residuals::{
    Axis, AxisShare, FrequencySpectrum, JointShares, OrderSpectrum, ResidualMap, ResidualSeries, Zone, ZoneShares,
};

use crate::effects::Catalogue;
use crate::replay::Gain;
use crate::robot::Model;
use crate::timeseries::Estimate;

/// The result of a diagnosis: what the simulation gets wrong, and why.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// Always [`SCHEMA`](Self::SCHEMA).
    pub schema: &'static str,
    /// Versions of the software that made it.
    pub versions: BTreeMap<&'static str, &'static str>,
    /// The verdict in one word.
    pub verdict: Verdict,
    /// Errors of data or model file that are likelier than physics; if there are any, no effect is named.
    pub mistakes: Vec<Mistake>,
    /// Channels that were not used because they are dead; the diagnosis holds for the other joints.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub dead_channels: Vec<Mistake>,
    /// Effects that were found, strongest first.
    pub effects: Vec<FoundEffect>,
    /// Quantities that differ between two recordings, where two are compared. `effects` then lists the effects that are new or changed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub changes: Option<Vec<Change>>,
    /// Torque errors of the nominal and the extended model, per joint and part of the data.
    pub fit: Vec<FitError>,
    /// Errors of simulations against the data, per joint and channel; empty until the models have been replayed.
    pub replay: Vec<ReplayError>,
    /// Fitted free parameters of the nominal model, by joint.
    pub baseline: BTreeMap<String, BaselineEstimate>,
    /// Results of second encoders behind the gears; empty where there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub two_encoders: Vec<TwoEncoders>,
    /// Structure that remains in the residual and that no effect of the catalogue explains.
    pub unexplained: Vec<Unexplained>,
    /// What the score of every sample says, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub judgement: Option<Judgement>,
    /// Effects that the training data support, but that have no gain on held-out data or a parameter outside its range.
    pub withdrawn: Vec<Withdrawn>,
    /// Every candidate that was tried, with its outcome.
    pub candidates: Vec<CandidateRecord>,
    /// How the data were processed: filter, zones, held-out part.
    pub method: Method,
    /// Where the error of the nominal model lies and on which quantities it depends, per joint.
    pub shares: Vec<JointShares>,
    /// Maps of the residual against quantities that may explain it, per joint.
    pub maps: Vec<ResidualMap>,
    /// Amplitude of the residual against the order of the motor angle, per joint.
    pub order_spectrum: Vec<OrderSpectrum>,
    /// Amplitude of the residual against frequency, per joint.
    pub frequency_spectrum: Vec<FrequencySpectrum>,
    /// The nominal model with the fitted baseline and the effects that were found. Every command accepts it.
    #[serde(skip)]
    pub extended_model: Model,
    /// The nominal model with the fitted baseline only.
    #[serde(skip)]
    pub baseline_model: Model,
    /// The catalogue of effects that could be named.
    #[serde(skip)]
    pub catalogue: Catalogue,
    /// Errors of predicted positions over time, for each session, joint and horizon.
    #[serde(skip)]
    pub predictions: Vec<PredictionSeries>,
    /// Residuals sample by sample, one for each session and joint.
    #[serde(skip)]
    pub series: Vec<ResidualSeries>,
}

impl Diagnosis {
    /// Version of the report's layout.
    pub const SCHEMA: &'static str = "lostmotion/diagnosis/1";
}

/// The verdict in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Effects of the catalogue explain what the nominal model gets wrong.
    EffectsFound,
    /// The nominal model explains the data.
    NothingFound,
    /// Structure remains in the residual, and no effect of the catalogue explains it.
    Unexplained,
    /// Data or model file contain a mistake that is likelier than physics.
    MistakeSuspected,
}

impl Verdict {
    /// The verdict from whether an effect is named and whether structure remains.
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
    /// Estimate [SI].
    pub value: f64,
    /// Standard error in the same unit, including the autocorrelation of the residual.
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

/// A quantity of the machine that differs between two recordings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// `viscous`, `coulomb`, `breakaway`, `stribeck_velocity`, `rotor_inertia`, `torque_offset`, `backlash`.
    pub quantity: String,
    /// The joint.
    pub joint: String,
    /// Value in the reference.
    pub reference: Measured,
    /// Value now.
    pub now: Measured,
    /// [%] Change relative to the reference value, positive for an increase. Errors common to both sides are not part of its standard error.
    pub change_percent: Measured,
    /// [standard errors] Size of the change; the natural variation from day to day counts as error.
    pub standing: f64,
    /// Probability that it has changed, 0 to 1.
    pub probability: f64,
}

impl Change {
    /// [nats] Largest gain of a change over none: `z²/2`, with `z` the standing.
    pub const fn evidence_nats(&self) -> f64 {
        0.5 * self.standing * self.standing
    }
}

/// Part of the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Split {
    /// Used for the fit.
    Train,
    /// Held out from the fit.
    HeldOut,
}

/// RMS torque error of one joint over its rigid zone; or RMS error of its link's position, where a second encoder measures it.
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
    /// [%] `before` relative to the RMS of the measured torque; for `link_position`, relative to the difference of the two encoders.
    pub before_percent: f64,
    /// [%] `after` relative to the same quantity.
    pub after_percent: f64,
    /// By how much `after` is below `before`, and whether that is significant.
    #[serde(flatten)]
    pub gain: Gain,
}

/// Error of a closed-loop simulation against the data.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReplayError {
    /// The joint.
    pub joint: String,
    /// The channel: `position`, `velocity`, `torque` (`force` for a sliding joint).
    pub quantity: &'static str,
    /// Unit of the errors.
    pub unit: &'static str,
    /// Part of the data.
    pub split: Split,
    /// [s] How far ahead the simulation predicts from the state that the recording shows, driven by the recorded torque alone; `None`: the whole
    /// recording, with a controller in the loop.
    pub horizon: Option<f64>,
    /// RMS error of the nominal model.
    pub before: f64,
    /// RMS error of the extended model.
    pub after: f64,
    /// RMS error that the sensors alone would leave; `None` without a horizon.
    pub floor: Option<f64>,
    /// By how much `after` is below `before`, and whether that is significant.
    #[serde(flatten)]
    pub gain: Gain,
}

/// Errors of predicted positions over time, for plots.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictionSeries {
    /// The joint.
    pub joint: String,
    /// The session.
    pub session: String,
    /// [s] How far ahead was predicted.
    pub horizon: f64,
    /// Unit of the errors.
    pub unit: &'static str,
    /// [s] Times for which was predicted.
    pub time: Vec<f64>,
    /// Recorded minus predicted position, nominal model.
    pub before: Vec<f64>,
    /// The same, extended model.
    pub after: Vec<f64>,
}

/// Free parameters of the nominal model of one joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BaselineEstimate {
    /// `coulomb`, `breakaway`, `stribeck_velocity`, `viscous`.
    pub friction: BTreeMap<&'static str, Measured>,
    /// Inertia at the motor shaft, where the model file gives none and the data give one above zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor_inertia: Option<Measured>,
    /// Total gap at the joint; `None` where the data do not determine it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash: Option<Measured>,
    /// Why no gap was measured, where another finding prevents it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash_left_out: Option<String>,
    /// Constant offset of the torque channel per session, where a torque was recorded and no current.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub torque_offset: BTreeMap<String, Measured>,
}

/// Result of comparing the encoders before and behind a gear.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TwoEncoders {
    /// The joint.
    pub joint: String,
    /// Delay of the second encoder, from this joint alone; negative where the first encoder is late.
    pub link_delay: Measured,
    /// [%] of the squared difference of the encoders, without its constant part, that a delay alone explains.
    pub explained_by_delay_percent: f64,
    /// Wind-up per torque through the gear.
    pub wind_up: Measured,
    /// Inverse of the wind-up, where the wind-up is more than twice its standard error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<Measured>,
    /// Total gap after the correction of the delay, unconstrained: a negative value is noise. `None` where the load stays on one flank.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash: Option<Measured>,
    /// Increase of the encoder difference after a reversal of the motion, beyond what friction before the gear causes; given where masses
    /// are
    /// estimated. It contains the gap only as far as the link follows the direction of motion and not the load.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost_motion: Option<Measured>,
    /// The gap that a fit without a delay gives.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub backlash_without_delay: Option<Measured>,
}

/// Structure that no effect explains.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unexplained {
    /// The joint.
    pub joint: String,
    /// Description of its shape in words and numbers, what says most first.
    pub pattern: String,
}

impl Unexplained {
    /// The first clause of the description.
    pub fn gist(&self) -> &str {
        self.pattern.split([',', ';', ':', '(']).next().unwrap_or_default().trim_end()
    }
}

/// The outcome of a candidate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CandidateRecord {
    /// Its name in the catalogue.
    pub effect: String,
    /// Joints on which it was tried.
    pub joints: Vec<String>,
    /// [%] by which it alone lowers the error scale of the baseline.
    pub gain_percent: f64,
    /// [%] Gain that an effect needs to be named.
    pub threshold_percent: f64,
    /// Whether it was named.
    pub named: bool,
    /// The reason in words.
    pub reason: String,
}

/// How the data were processed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Method {
    /// The kernel that smooths torque and motion.
    pub filter: String,
    /// [s] Smallest and largest half width of the kernel.
    pub half_width: [f64; 2],
    /// Which parts of each session were left out, and why.
    pub zones: String,
    /// Which parameters of the nominal model are fitted.
    pub baseline: String,
    /// Which part was held out.
    pub held_out: String,
    /// Joints whose torque was not judged, each with the reason.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// What became of the effects that the model file lists.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub listed_effects: Vec<String>,
}

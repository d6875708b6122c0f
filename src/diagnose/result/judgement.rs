//! What the score of every sample says: sets of effects, each with its probability.

use std::collections::BTreeMap;

use serde::Serialize;

use super::Measured;
use crate::robot::Model;
use crate::timeseries::Estimate;

/// Probability above which a name is supported: it is more probable than all else together.
const SUPPORTED: f64 = 0.5;

/// The judgement by simulation, which stands beside the effects that the regression names.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Judgement {
    /// Why recordings and model were not judged; everything else is empty then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_applied: Option<String>,
    /// Effects with their probabilities, the most probable one first; none where a part of the recording remains unexplained.
    pub names: Vec<JudgedName>,
    /// Whether even the best set is far from the floor of the sensors: the machine differs in something that no set contains, and gains decide nothing.
    pub unexplained: bool,
    /// [nat] a reading, on windows that took no part in any fit.
    pub distance: Option<Distance>,
    /// Sets of effects that were fitted, best first.
    pub sets: Vec<JudgedSet>,
    /// Sets that were not tried because the time was over.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_tried: Vec<String>,
    /// Parts of the recordings that were used.
    pub windows: Vec<JudgedWindow>,
    /// Whether the extended model is the machine that was fitted to every sample, since it predicts data held out better.
    pub adopted: bool,
    /// The machine with the most probable set, where the score supports that set and it contains what the regression named.
    #[serde(skip)]
    pub machine: Option<JudgedMachine>,
}

/// A machine with effects that the score of every sample supports.
#[derive(Debug, Clone, PartialEq)]
pub struct JudgedMachine {
    /// The nominal model with everything that is not known exactly fitted by the score, without an effect.
    pub baseline: Model,
    /// The same with the effects.
    pub extended: Model,
    /// The effects, as in the extended model.
    pub effects: Vec<JudgedEffect>,
    /// Its friction and gaps by joint: `coulomb`, `breakaway`, `stribeck_velocity`, `viscous`, `backlash`.
    pub estimates: BTreeMap<String, BTreeMap<&'static str, Measured>>,
}

/// An effect of a [`JudgedMachine`].
#[derive(Debug, Clone, PartialEq)]
pub struct JudgedEffect {
    /// Its name in the catalogue.
    pub effect: String,
    /// Its joint; `None` for the machine.
    pub joint: Option<String>,
    /// Its parameters by name.
    pub parameters: BTreeMap<String, Measured>,
    /// Posterior probability of all sets that contain it on this joint, 0 to 1.
    pub probability: f64,
    /// [nat] Gain of the set over the best one without it, on windows that took no part in the fit.
    pub gain_nats: f64,
    /// Effects of other sets that are about as probable.
    pub confusable_with: Vec<String>,
    /// The machine with that best set without it.
    pub without: Model,
}

/// An effect with the probability of all sets that contain it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JudgedName {
    /// Its name in the catalogue.
    pub effect: String,
    /// Joints on which it acts in the most probable set that contains it; empty for the machine.
    pub joints: Vec<String>,
    /// Posterior probability, 0 to 1.
    pub probability: f64,
    /// Effects of other sets that are about as probable.
    pub confusable_with: Vec<String>,
}

/// How far the best set is from what an exact model reaches.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Distance {
    /// [nat] a reading: score of the nominal model with friction, gap and everything that is not known exactly fitted.
    pub baseline: f64,
    /// [nat] a reading: score of the best set.
    pub best: f64,
    /// [nat] a reading: score that this set has on average if it is right; `None` where, without a torque beside its own, it loses the recording's track.
    pub floor: Option<f64>,
    /// [1] One per joint, for the best set: torque that it misses, relative to the noise of the measured current or torque.
    pub missed_torque: Vec<f64>,
}

/// A set of effects as it was fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JudgedSet {
    /// The effects with their joints, as one name; `nothing` for none.
    pub name: String,
    /// Names of its effects in the catalogue.
    pub effects: Vec<String>,
    /// [nat] Gain over no effect on windows that took no part in the fit.
    pub gain_nats: f64,
    /// Posterior probability, 0 to 1; `None` where gains decide nothing.
    pub probability: Option<f64>,
    /// Sizes of its effects.
    pub sizes: BTreeMap<String, Estimate>,
}

/// A part of a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JudgedWindow {
    /// Name of the session.
    pub session: String,
    /// [s] Start and end since the start of the session.
    pub from: f64,
    /// See [`from`](Self::from).
    pub to: f64,
    /// Whether sets were fitted to it; otherwise they were judged by it.
    pub fitted: bool,
}

impl Judgement {
    /// A stage that does not apply, for this reason.
    pub fn not_applied(reason: impl Into<String>) -> Self {
        Self { not_applied: Some(reason.into()), ..Self::default() }
    }

    /// Whether an effect is more probable than not.
    pub fn supports(&self, effect: &str) -> bool {
        self.names.iter().any(|name| name.effect == effect && name.is_supported())
    }
}

impl JudgedName {
    /// Whether it is more probable than not.
    pub fn is_supported(&self) -> bool {
        is_supported(self.probability)
    }
}

/// Whether an effect of this probability is more probable than not.
pub fn is_supported(probability: f64) -> bool {
    probability > SUPPORTED
}

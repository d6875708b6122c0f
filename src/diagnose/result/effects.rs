//! Effects in the result of a diagnosis: named, or withdrawn.

use std::collections::BTreeMap;

use serde::Serialize;

use super::Measured;
use crate::effects::{About, Kind};
use crate::replay::Gain;

/// An effect that the evidence supports.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundEffect {
    /// Its name in the catalogue.
    pub effect: String,
    /// Joints on which it acts; all joints for an effect of the machine.
    pub joints: Vec<String>,
    /// Whether it belongs to the machine or to the measurement.
    pub kind: Kind,
    /// Its parameters by name.
    pub parameters: BTreeMap<String, Measured>,
    /// Probability that this effect is the true one, 0 to 1.
    pub probability: f64,
    /// [nats] Its evidence in the training data.
    pub evidence_nats: f64,
    /// Its gain on held-out data, significantly above zero.
    #[serde(flatten)]
    pub gain: EffectGain,
    /// Effects that explain the data almost as well.
    pub confusable_with: Vec<String>,
    /// The experiment that would separate them.
    pub separate_by: String,
}

/// Probability, evidence and gain of an effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Standing {
    /// Probability that this effect is the true one, 0 to 1.
    pub probability: f64,
    /// [nats] Its evidence in the training data.
    pub evidence_nats: f64,
    /// Its gain on held-out data.
    pub gain: EffectGain,
}

impl FoundEffect {
    /// An effect on these joints, without rivals.
    pub fn new(about: &About, joints: Vec<String>, parameters: BTreeMap<String, Measured>, standing: Standing) -> Self {
        let Standing { probability, evidence_nats, gain } = standing;
        Self {
            effect: about.name.to_owned(),
            joints,
            kind: about.kind,
            parameters,
            probability,
            evidence_nats,
            gain,
            confusable_with: Vec::new(),
            separate_by: about.separate_by.to_owned(),
        }
    }

    /// The effect with its rivals, which explain the data almost as well; the proposed experiment then separates it from them.
    pub fn beside(mut self, rivals: Vec<String>) -> Self {
        if !rivals.is_empty() {
            self.separate_by = format!("against {}: {}", rivals.join(", "), self.separate_by);
        }
        self.confusable_with = rivals;
        self
    }
}

/// By how much an effect lowers an error on held-out data.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectGain {
    /// [%] By how much the RMS error with all effects is lower than without this one.
    pub gain_percent: f64,
    /// [%] Ends of its 95 % interval.
    pub gain_interval_percent: [f64; 2],
    /// Which error: `torque` along the measured motion, or the error in which the effect shows.
    pub gain_of: String,
    /// [%] Fall of each joint's RMS torque error when the effect is added to the stronger ones, relative to the nominal error.
    /// The sum over all effects is the gain of the joint.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub gain_by_joint: BTreeMap<String, f64>,
}

impl EffectGain {
    /// The gain in an error other than the torque along the measured motion.
    pub fn of(gain: Gain, error: &str) -> Self {
        Self {
            gain_percent: gain.gain_percent,
            gain_interval_percent: gain.interval_percent,
            gain_of: error.to_owned(),
            gain_by_joint: BTreeMap::new(),
        }
    }

    /// Whether its interval lies above zero.
    pub fn shown(&self) -> bool {
        self.gain_interval_percent[0] > 0.0
    }
}

/// An effect that the training data support and that is not named.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Withdrawn {
    /// Its name in the catalogue.
    pub effect: String,
    /// Joints on which it was tried.
    pub joints: Vec<String>,
    /// Why it is not named: its gain on held-out data, or a parameter outside its range.
    pub reason: String,
}

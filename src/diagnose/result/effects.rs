//! Effects as a diagnosis reports them: named, or withdrawn.

use std::collections::BTreeMap;

use serde::Serialize;

use super::Measured;
use crate::effects::{About, Kind};
use crate::replay::Gain;

/// An effect that the evidence supports.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundEffect {
    /// Name of the catalogue.
    pub effect: String,
    /// Joints it acts on; all for an effect of the machine.
    pub joints: Vec<String>,
    /// Machine or measurement.
    pub kind: Kind,
    /// Its parameters by name.
    pub parameters: BTreeMap<String, Measured>,
    /// Probability that it is what is named, 0 to 1.
    pub probability: f64,
    /// [nats] Evidence for it in the training data.
    pub evidence_nats: f64,
    /// What it gains on data held out, above zero by more than chance.
    #[serde(flatten)]
    pub gain: EffectGain,
    /// Effects that explain the data almost as well.
    pub confusable_with: Vec<String>,
    /// The experiment that would separate them.
    pub separate_by: String,
}

/// How sure an effect is, and what it gains.
#[derive(Debug, Clone, PartialEq)]
pub struct Standing {
    /// Probability that it is what is named, 0 to 1.
    pub probability: f64,
    /// [nats] Evidence for it in the training data.
    pub evidence_nats: f64,
    /// What it gains on data held out.
    pub gain: EffectGain,
}

impl FoundEffect {
    /// An effect on these joints, beside which no other explains the data.
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

    /// With the effects that explain the data almost as well; the experiment is then named as that against them.
    pub fn beside(mut self, rivals: Vec<String>) -> Self {
        if !rivals.is_empty() {
            self.separate_by = format!("against {}: {}", rivals.join(", "), self.separate_by);
        }
        self.confusable_with = rivals;
        self
    }
}

/// By how much an effect lowers an error on data held out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectGain {
    /// [%] by which the RMS error is lower with all effects than without this one.
    pub gain_percent: f64,
    /// [%] ends of its 95 % interval.
    pub gain_interval_percent: [f64; 2],
    /// Which error: `torque` along the measured motion, or that in which the effect is seen.
    pub gain_of: String,
    /// [%] of each joint's nominal RMS torque error that goes when the effect is added to the stronger ones: these add up to the gain of the joint.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub gain_by_joint: BTreeMap<String, f64>,
}

impl EffectGain {
    /// A gain of an error that is not the torque along the measured motion.
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

/// An effect that the training data support and that is not named all the same.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Withdrawn {
    /// Name of the catalogue.
    pub effect: String,
    /// Joints it was sought on.
    pub joints: Vec<String>,
    /// Why it is not named: its gain on data held out, or the parameter that lies outside its range.
    pub reason: String,
}

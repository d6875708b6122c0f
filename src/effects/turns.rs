//! Effects that show only at the reversals of a joint: a diagnosis simulates the gear along the measured motion, once with the
//! effect and once without, and checks whether the difference explains the recording.

use super::{Effect, Motion};

/// Known quantities of a joint before an effect is tried there.
#[derive(Debug, Clone)]
pub struct Turns<'a> {
    /// The motion.
    pub motion: &'a Motion<'a>,
    /// Index of the joint.
    pub joint: usize,
    /// `b` [rad or m] Its gap, as fitted without the effect.
    pub gap: f64,
    /// [s] Duration of the rotor's rest before each start.
    pub rests: Vec<f64>,
}

/// Parameters to start from.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// In the order of [`About::parameters`](super::About::parameters); parameters with a default may be missing at the end, and are then not fitted.
    pub values: Vec<f64>,
    /// Possible error of each value; zero keeps the value.
    pub scales: Vec<f64>,
    /// Whether its torque is proportional to the first parameter.
    pub proportional: bool,
}

/// An effect that shows at the reversals of a joint, by the actions on gear and friction that [`Effect::install`] returns.
pub trait AtTurns: Effect {
    /// Whether the nominal model lacks it on this joint and the recording could show it.
    fn applies(&self, _seen: &Turns) -> bool {
        true
    }

    /// Starting parameters over the whole plausible range.
    fn trials(&self, seen: &Turns) -> Vec<Trial>;

    /// Starting parameters of the same effect without the dependence that its name claims. What it explains with them is no evidence for the name.
    fn without_claim(&self, _seen: &Turns, _values: &[f64]) -> Vec<Trial> {
        Vec::new()
    }

    /// [nats] Evidence that it needs beyond that of other effects, if it can fit any soft behaviour at a reversal.
    fn reserve(&self) -> f64 {
        0.0
    }

    /// [1] Logarithm by which it has to lower the error scale around reversals, if more than for other effects.
    fn least_fall(&self) -> f64 {
        0.0
    }

    /// Whether its effect with these parameters is large enough to show in the recording.
    fn visible(&self, _seen: &Turns, _values: &[f64]) -> bool {
        true
    }
}

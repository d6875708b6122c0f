//! How a diagnosis tells effects that show only where joints turn around: it simulates the gear along the measured motion, once with the
//! effect and once without, and asks whether the difference explains the recording.

use super::{Effect, Motion};

/// What is known of a joint before an effect is tried there.
#[derive(Debug, Clone)]
pub struct Turns<'a> {
    /// The motion.
    pub motion: &'a Motion<'a>,
    /// Index of the joint.
    pub joint: usize,
    /// `b` [rad or m] its gap, as fitted without the effect.
    pub gap: f64,
    /// [s] How long the rotor rested before each start.
    pub rests: Vec<f64>,
}

/// Parameters to start from.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// In the order of [`About::parameters`](super::About::parameters); those with a default may be missing at the end, and stay there.
    pub values: Vec<f64>,
    /// How far each may be off.
    pub scales: Vec<f64>,
    /// Whether what it does to the torque is proportional to the first of them.
    pub proportional: bool,
}

/// An effect that shows where a joint turns around, by the actions that [`Effect::install`] returns for gear and friction.
pub trait AtTurns: Effect {
    /// Whether the nominal model lacks it on this joint and the recording could show it.
    fn applies(&self, _seen: &Turns) -> bool {
        true
    }

    /// Parameters to start from, everywhere that they might be.
    fn trials(&self, seen: &Turns) -> Vec<Trial>;

    /// [nats] Evidence that it needs beyond that of any effect: for one that fits whatever is soft about a turn.
    fn reserve(&self) -> f64 {
        0.0
    }

    /// [1] Logarithm by which it has to lower the scale of the error around turns, where that is more than of any effect.
    fn least_fall(&self) -> f64 {
        0.0
    }

    /// Whether what it does with these parameters is large enough for the recording to show it.
    fn visible(&self, _seen: &Turns, _values: &[f64]) -> bool {
        true
    }
}

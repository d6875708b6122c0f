//! What can be chosen about a diagnosis, and the thresholds at which an effect is named.

use crate::effects::Catalogue;

/// What can be chosen about a diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// When an effect is named.
    pub rules: Rules,
    /// Part at the end of each session that is held out where no session is, 0 to 1.
    pub held_out_share: f64,
    /// Whether gaps that the model file leaves out are measured too; it takes most of the time.
    pub backlash: bool,
    /// Effects that may be named.
    pub catalogue: Catalogue,
}

impl Default for Options {
    fn default() -> Self {
        Self { rules: Rules::default(), held_out_share: 0.3, backlash: true, catalogue: Catalogue::default() }
    }
}

/// Thresholds, calibrated on clean machines made by seed (see `tests/diagnose.rs`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// [nats] evidence that a joint's effect needs.
    pub nats: f64,
    /// [nats] evidence that an effect needs where it lowers the error by no more than laws of the catalogue get wrong themselves
    /// (a fall of its logarithm by 0.12).
    pub slight: f64,
    /// [nats] `slight` beside an effect that was named, or taken off the recording, before: what a law that is not quite
    /// right leaves behind can be picked up by others. That reached 12 to 25 nats (tuning seeds 1403, 1410, 3600, 4602, 6802).
    pub further: f64,
    /// [1] logarithm by which the error scale has to fall on the joint where it helps most.
    pub log_scale: f64,
    /// [1] Share of the stronger evidence within which the simpler effect is taken.
    pub tie: f64,
    /// [1] Part of the strongest effect's torque on a joint that a further effect has to move there: an effect whose law is not
    /// quite the catalogue's leaves a residue of a few per cent that others can pick up.
    pub residue: f64,
    /// [1] The same for a further effect that looks like the strongest one: its residue looks like that.
    pub alike_residue: f64,
    /// [1] Part of the RMS torque of a joint that a physical effect has to move there: less is what no friction law gets right.
    pub least_torque: f64,
    /// Most effects that are taken.
    pub most: usize,
}

impl Default for Rules {
    fn default() -> Self {
        Self {
            nats: 12.0,
            slight: 12.0,
            further: 30.0,
            log_scale: 0.02,
            tie: 0.02,
            residue: 0.06,
            alike_residue: 0.2,
            least_torque: 0.0025,
            most: 6,
        }
    }
}

impl Rules {
    /// For what is named beside something else.
    pub fn beside_another(self) -> Self {
        Self { slight: self.further, ..self }
    }

    /// Whether evidence [nats] and the logarithm of the fall of the error support an effect.
    pub fn support(&self, nats: f64, log_scale: f64) -> bool {
        nats > self.nats && log_scale > self.log_scale && (nats > self.slight || log_scale > MODEL_ERROR)
    }
}

/// [1] Logarithm of the error scale that the laws of the catalogue get wrong themselves: a rival that leaves less than this more on every
/// joint of the effect cannot be rejected. On 85 tuning machines (seeds 2000 to 7101 of `benches/blind`) the truth was never further
/// than 0.10 behind what was named.
pub const MODEL_ERROR: f64 = 0.12;

//! The options of a diagnosis, and the thresholds at which an effect is named.

use crate::effects::{About, Catalogue, Kind, Scope};

/// The options of a diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// When an effect is named.
    pub rules: Rules,
    /// [1] Part at the end of each training session that is held out when there are no held-out sessions, 0 to 1.
    pub held_out_share: f64,
    /// Whether gaps that the model file leaves out are measured too. This takes most of the computing time.
    pub backlash: bool,
    /// Effects that may be named.
    pub catalogue: Catalogue,
}

impl Default for Options {
    fn default() -> Self {
        Self { rules: Rules::default(), held_out_share: 0.3, backlash: true, catalogue: Catalogue::default() }
    }
}

/// Thresholds, calibrated on simulated machines without effects (see `tests/diagnosis/diagnose.rs`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// [nats] Evidence that an effect needs on a joint.
    pub nats: f64,
    /// [nats] Evidence that an effect needs where it lowers the error only slightly, by no more than the inaccuracy of the catalogue's laws
    /// (0.12 in the logarithm of the error).
    pub slight: f64,
    /// [nats] As `slight`, where another effect is already named or already removed from the recording. A law that is only approximately
    /// right leaves a residue, and other effects can fit it: their evidence reached 12 to 25 nats (tuning seeds 1403, 1410, 3600, 4602, 6802).
    pub further: f64,
    /// [1] Logarithm by which the error scale has to fall, on the joint where it falls most.
    pub log_scale: f64,
    /// [1] Part by which evidence for one effect has to exceed that for another to be more, beyond a fixed margin (see [`Rules::tied`]).
    pub tie: f64,
    /// [1] Torque that a further effect has to move on a joint, relative to the torque of the strongest effect there. An effect whose true
    /// law differs a little from the catalogue's leaves a residue of a few per cent, which other effects can fit.
    pub residue: f64,
    /// [1] The same for a further effect whose torque resembles that of the strongest one, and so resembles its residue too.
    pub alike_residue: f64,
    /// [1] Part of the RMS torque of a joint that a physical effect has to move there. No friction law is accurate below this.
    pub least_torque: f64,
    /// Largest number of effects that are selected.
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
    /// [1] Torque that an effect has to move on a joint, relative to the RMS torque there.
    pub fn torque_of(&self, about: &About) -> f64 {
        if about.kind == Kind::Measurement { 0.0 } else { self.least_torque }
    }

    /// What is within the inaccuracy of the laws. An effect of the whole machine is imitated by the nominal model's deviations, so that a part
    /// of it decides; what an effect of one joint moves is judged by [`torque_of`](Self::torque_of).
    pub fn inaccuracy(&self, about: &About) -> Inaccuracy {
        let torque = if about.scope == Scope::Machine { self.least_torque } else { 0.0 };
        Inaccuracy { log_scale: self.log_scale, torque }
    }

    /// The rules for an effect that is named beside another one.
    pub fn beside_another(self) -> Self {
        Self { slight: self.further, ..self }
    }

    /// [nats] Difference from the strongest evidence up to which a simpler effect is as good.
    pub fn tied(&self, strongest: f64) -> f64 {
        self.tie * strongest + UNIT
    }

    /// Whether evidence [nats] and the fall of the error's logarithm support an effect.
    pub fn support(&self, nats: f64, log_scale: f64) -> bool {
        nats > self.nats && log_scale > self.log_scale && (nats > self.slight || log_scale > MODEL_ERROR)
    }
}

/// What an effect has to exceed on a joint beside free deviations of the nominal model: less is within the inaccuracy of the friction laws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inaccuracy {
    /// [1] Fall of the error's logarithm.
    pub log_scale: f64,
    /// [1] Torque that the deviations cannot imitate, relative to the RMS torque of the joint.
    pub torque: f64,
}

impl Inaccuracy {
    /// Laws that are exact.
    pub const NONE: Self = Self { log_scale: 0.0, torque: 0.0 };
}

/// [nats] Difference of evidence that tells two effects apart three times in four: a name's probability has this unit
/// ([`probability`](super::select::certainty::probability)).
pub const UNIT: f64 = 3.0;

/// [1] Inaccuracy of the catalogue's laws, as a logarithm of the error scale. A rival whose error is larger by less than this
/// on every joint of the effect cannot be rejected. On 85 tuning machines (seeds 2000 to 7101 of `benches/blind`) the error of the true
/// effect was never more than 0.10 above that of the named one.
pub const MODEL_ERROR: f64 = 0.12;

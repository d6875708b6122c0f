//! What an instrument of a diagnosis measures on a recording, whatever causes it.
//!
//! An instrument does not know the catalogue: it measures. An effect that shows as a phenomenon claims it ([`Effect::claims`](super::Effect::claims))
//! and says what its parameters then are. A phenomenon that no effect claims is reported as unexplained.

use crate::timeseries::Estimate;

/// A measured phenomenon of one joint, or of all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Phenomenon {
    /// The current lags behind the motion, on all joints alike; negative where it is ahead.
    CurrentLag {
        /// [s]
        lag: Estimate,
    },
    /// The encoder behind the gear lags behind that of the motor, on all joints alike; negative where it is ahead.
    LinkEncoderLag {
        /// [s]
        lag: Estimate,
    },
    /// A joint feels `a sin(2π f t + φ)`, `t` since the start of the session, whatever its speed.
    Line {
        /// `f` [Hz]
        frequency: Estimate,
        /// `a` [N·m or N]
        amplitude: Estimate,
        /// `φ` [rad]
        phase: Estimate,
    },
    /// The drive of a joint makes no current of commands smaller than `u0`.
    DeadBand {
        /// `u0` [A]
        width: Estimate,
    },
    /// A link steps against its rotor once, at one time since the start of each session; positive where it is ahead afterwards.
    Step {
        /// [rad or m]
        jump: Estimate,
        /// [s]
        time: Estimate,
    },
    /// Two encoders see a gear that is softer than the model says.
    WindUp {
        /// [N·m/rad or N/m]
        stiffness: Estimate,
    },
    /// Two encoders see a gap `b + a cos(n θ + φ)`.
    UnevenGap {
        /// `a` [rad or m]
        amplitude: Estimate,
        /// `n` [1/turn or 1/m]
        order: Estimate,
        /// `φ` [rad]
        phase: Estimate,
    },
}

/// Parameters of an effect, by name.
pub type Claim = Vec<(&'static str, Estimate)>;

/// A size and an error for [`Phenomenon::KINDS`].
const ONE: Estimate = Estimate { value: 1.0, std_error: 1.0 };

impl Phenomenon {
    /// One of each kind: an effect is asked by it whether it claims that kind at all.
    pub const KINDS: [Self; 7] = [
        Self::CurrentLag { lag: ONE },
        Self::LinkEncoderLag { lag: ONE },
        Self::Line { frequency: ONE, amplitude: ONE, phase: ONE },
        Self::DeadBand { width: ONE },
        Self::Step { jump: ONE, time: ONE },
        Self::WindUp { stiffness: ONE },
        Self::UnevenGap { amplitude: ONE, order: ONE, phase: ONE },
    ];

    /// Whether only a second encoder behind the gear shows it.
    pub const fn needs_link_encoder(&self) -> bool {
        matches!(self, Self::LinkEncoderLag { .. } | Self::WindUp { .. } | Self::UnevenGap { .. })
    }
}

/// Parameters that a lag of either sign gives: the first where it is positive, the second where it is negative.
pub fn of_either_sign(lag: Estimate, behind: &'static str, ahead: &'static str) -> Claim {
    let name = if lag.value > 0.0 { behind } else { ahead };
    vec![(name, Estimate { value: lag.value.abs(), ..lag })]
}

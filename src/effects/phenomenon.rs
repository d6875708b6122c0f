//! Phenomena: what an instrument of a diagnosis measures on a recording, independent of the cause.
//!
//! An instrument measures and does not know the catalogue. An effect that shows as a phenomenon claims it ([`Effect::claims`](super::Effect::claims))
//! and gives its own parameters for it. A phenomenon that no effect claims is reported as unexplained.

use crate::timeseries::Estimate;

/// A measured phenomenon of one joint, or of all joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Phenomenon {
    /// The current lags behind the motion, equally on all joints; negative if it is ahead.
    CurrentLag {
        /// [s]
        lag: Estimate,
    },
    /// The encoder behind the gear lags behind that of the motor, equally on all joints; negative if it is ahead.
    LinkEncoderLag {
        /// [s]
        lag: Estimate,
    },
    /// The velocity channel of a joint follows the derivative of its position late; both lags are given if the data do not separate them.
    VelocityLag {
        /// `T` [s] a delay.
        delay: Option<Estimate>,
        /// `τ` [s] of a first-order low-pass, beyond that of the model's sensor.
        time_constant: Option<Estimate>,
        /// `g` [1] reading of a constant velocity, relative to it.
        gain: Estimate,
    },
    /// A joint feels `a sin(2π f t + φ)` at any speed, `t` since the start of the session.
    Line {
        /// `f` [Hz]
        frequency: Estimate,
        /// `a` [N·m or N]
        amplitude: Estimate,
        /// `φ` [rad]
        phase: Estimate,
    },
    /// The drive of a joint gives no current for commands below `u0`.
    DeadBand {
        /// `u0` [A]
        width: Estimate,
    },
    /// A link steps against its rotor once, at the same time since the start of each session; positive if the link is ahead afterwards.
    Step {
        /// [rad or m]
        jump: Estimate,
        /// [s]
        time: Estimate,
    },
    /// Two encoders show a gear that is softer than in the model.
    WindUp {
        /// [N·m/rad or N/m]
        stiffness: Estimate,
    },
    /// Two encoders show a gap `b + a cos(n θ + φ)`.
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

/// Value and error for the phenomena in [`Phenomenon::KINDS`].
const ONE: Estimate = Estimate { value: 1.0, std_error: 1.0 };

impl Phenomenon {
    /// One phenomenon of each kind, to test whether an effect claims that kind.
    pub const KINDS: [Self; 8] = [
        Self::CurrentLag { lag: ONE },
        Self::LinkEncoderLag { lag: ONE },
        Self::VelocityLag { delay: Some(ONE), time_constant: Some(ONE), gain: ONE },
        Self::Line { frequency: ONE, amplitude: ONE, phase: ONE },
        Self::DeadBand { width: ONE },
        Self::Step { jump: ONE, time: ONE },
        Self::WindUp { stiffness: ONE },
        Self::UnevenGap { amplitude: ONE, order: ONE, phase: ONE },
    ];

    /// Whether it shows only with a second encoder behind the gear.
    pub const fn needs_link_encoder(&self) -> bool {
        matches!(self, Self::LinkEncoderLag { .. } | Self::WindUp { .. } | Self::UnevenGap { .. })
    }
}

/// Parameters for a lag of either sign: the first is set if it is positive, the second if it is negative.
pub fn of_either_sign(lag: Estimate, behind: &'static str, ahead: &'static str) -> Claim {
    let name = if lag.value > 0.0 { behind } else { ahead };
    vec![(name, Estimate { value: lag.value.abs(), ..lag })]
}

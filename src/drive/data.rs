//! Data of a drive and its sensors, as in the model file.

/// A DC motor. Motor torque on the joint side is `ratio · K_t · i`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motor {
    /// `K_t` [N·m/A] torque constant at the motor shaft, > 0; its back-EMF constant [V·s/rad] is the same number.
    pub torque_constant: f64,
    /// `R` [Ω] winding resistance; `None`: the current follows its command at once.
    pub resistance: Option<f64>,
    /// `L` [H] winding inductance.
    pub inductance: Option<f64>,
}

/// The power stage. Its current loop demands `u = R i + K_t ω_m + L (i_cmd − i)/T_i`, within its limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplifier {
    /// [V] supply, > 0; infinite where not given.
    pub voltage_limit: f64,
    /// [A] largest current command, > 0; infinite where not given.
    pub current_limit: f64,
    /// `T_i` [s] time constant of the current loop, > 0.
    pub current_time_constant: f64,
}

/// An incremental encoder on the motor shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Encoder {
    /// Counts per turn of the motor shaft, after quadrature, > 0.
    pub counts_per_turn: f64,
}

/// A second encoder on the link, behind the gear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkEncoder {
    /// [rad or m] size of a count at the joint, > 0.
    pub resolution: f64,
}

/// How the velocity channel is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum VelocitySensor {
    /// Encoder differences through a first-order low-pass of this time constant [s].
    LowPass(f64),
    /// Pulse-frequency measurement: one count over the time between the last two edges of equal direction, outdated between edges.
    PulsePeriod,
}

/// Whether the sign of the current is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sensing {
    /// The sign is measured.
    Signed,
    /// A shunt below the bridge: the magnitude only.
    Absolute,
}

/// The current sensor with its converter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurrentSensor {
    /// [A] standard deviation of its noise, ≥ 0.
    pub noise: f64,
    /// [A] step of its converter, ≥ 0; 0 if there is none.
    pub resolution: f64,
    /// Whether the sign is measured.
    pub sensing: Sensing,
}

//! Command to current: a DC motor with a current loop of limited voltage.
//!
//! ```text
//!   L di/dt = u − R i − K ω        K = ratio · K_t, ω the rotor's velocity at the joint: K_t ω_m = K ω
//!   u* = R i + K ω + L (i_cmd − i)/T_i,   u = clamp(u*, ±V)      so, while |u*| ≤ V: di/dt = (i_cmd − i)/T_i
//! ```
//!
//! With `R` but no `L`: `i = i_cmd` while `|R i_cmd + K ω| ≤ V`, else `i = (±V − K ω)/R`. Without `R`: `i = i_cmd`.
//! While no limit is active, the response of the loop to a constant command is known:
//! `i(t + h) = i_cmd + (i(t) − i_cmd) e^{−h/T_i}`.
//! Sign: positive current drives the joint positively. The command is clamped to ±`current_limit` beforehand.
//! Left out: switching ripple, dead time of the bridge, heating of the winding.

use super::{Amplifier, Motor};

/// A motor with its amplifier, on the joint side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerStage {
    /// `K` [N·m/A = V·s/rad] torque per ampere and voltage per velocity, both at the joint.
    pub torque_per_ampere: f64,
    /// `V` [V].
    pub voltage_limit: f64,
    /// [A] largest command.
    pub current_limit: f64,
    /// Electrical model of the winding.
    pub winding: Winding,
}

/// Electrical model between command and current.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Winding {
    /// Nothing: `i = i_cmd`.
    Ideal,
    /// `R` [Ω] alone: the current jumps, within the limits of the voltage.
    Resistive {
        /// `R` [Ω] > 0.
        resistance: f64,
    },
    /// `R` and `L`: the current is a state.
    Inductive {
        /// `R` [Ω] ≥ 0.
        resistance: f64,
        /// `L` [H] > 0.
        inductance: f64,
        /// `T_i` [s] > 0.
        time_constant: f64,
    },
}

impl PowerStage {
    /// From the numbers of the model file and `K = ratio · K_t`. Without a motor a command is a torque at the joint, and limits in
    /// volts and amperes do not apply.
    pub fn new(motor: Option<&Motor>, amplifier: &Amplifier, torque_per_ampere: f64) -> Self {
        let Some(motor) = motor else {
            let (voltage_limit, current_limit) = (f64::INFINITY, f64::INFINITY);
            return Self { torque_per_ampere, voltage_limit, current_limit, winding: Winding::Ideal };
        };
        let winding = match (motor.resistance, motor.inductance) {
            (Some(resistance), Some(inductance)) if inductance > 0.0 => {
                Winding::Inductive { resistance, inductance, time_constant: amplifier.current_time_constant }
            }
            (Some(resistance), _) if resistance > 0.0 => Winding::Resistive { resistance },
            _ => Winding::Ideal,
        };
        Self {
            torque_per_ampere,
            voltage_limit: amplifier.voltage_limit,
            current_limit: amplifier.current_limit,
            winding,
        }
    }

    /// Command within the current limit [A].
    pub fn clamp(&self, command: f64) -> f64 {
        command.clamp(-self.current_limit, self.current_limit)
    }

    /// `u*` [V] that the current loop demands; 0 if the model has no voltage.
    pub fn demand(&self, command: f64, current: f64, velocity: f64) -> f64 {
        match self.winding {
            Winding::Ideal => 0.0,
            Winding::Resistive { resistance } => resistance * command + self.torque_per_ampere * velocity,
            Winding::Inductive { resistance, inductance, time_constant } => {
                resistance * current
                    + self.torque_per_ampere * velocity
                    + inductance * (command - current) / time_constant
            }
        }
    }

    /// Limit that a demand [V] exceeds: −1, 0 or +1.
    pub fn saturation(&self, demand: f64) -> i8 {
        if demand > self.voltage_limit {
            1
        } else if demand < -self.voltage_limit {
            -1
        } else {
            0
        }
    }

    /// Current [A] that flows: the state, or the result of command and voltage limit.
    pub fn current(&self, command: f64, state: f64, velocity: f64, saturation: i8) -> f64 {
        match self.winding {
            Winding::Ideal => command,
            Winding::Resistive { resistance } if saturation != 0 => {
                (f64::from(saturation) * self.voltage_limit - self.torque_per_ampere * velocity) / resistance
            }
            Winding::Resistive { .. } => command,
            Winding::Inductive { .. } => state,
        }
    }

    /// `e^{−h/T_i}`: the share of the distance between current and command that remains after `h` [s], while no limit
    /// is active; 1 if the current is not a state.
    pub fn remainder(&self, h: f64) -> f64 {
        match self.winding {
            Winding::Inductive { time_constant, .. } => (-h / time_constant).exp(),
            _ => 1.0,
        }
    }

    /// `T_i` [s], where the current is a state.
    pub fn time_constant(&self) -> Option<f64> {
        match self.winding {
            Winding::Inductive { time_constant, .. } => Some(time_constant),
            _ => None,
        }
    }

    /// `di/dt` [A/s]; 0 where the current is not a state.
    pub fn rate(&self, command: f64, current: f64, velocity: f64, saturation: i8) -> f64 {
        match self.winding {
            Winding::Inductive { time_constant, .. } if saturation == 0 => (command - current) / time_constant,
            Winding::Inductive { resistance, inductance, .. } => {
                let u = f64::from(saturation) * self.voltage_limit;
                (u - resistance * current - self.torque_per_ampere * velocity) / inductance
            }
            _ => 0.0,
        }
    }
}

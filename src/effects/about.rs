//! Description of an effect: the text of `lostmotion explain`, and the ranges of its parameters.

use serde::Serialize;

use crate::toml_input::Range;

/// What differs: the machine itself, only its measurement, or the simulator that made the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The machine moves differently.
    Physics,
    /// The machine moves as before; its sensors read differently.
    Measurement,
    /// No machine does so: the data come from a simulator with a simpler law.
    Simulation,
}

/// What one set of parameters applies to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Scope {
    /// One joint.
    Joint,
    /// All joints of the machine.
    Machine,
}

/// A parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ParameterSpec {
    /// Its key in model files and reports.
    pub name: &'static str,
    /// Its symbol in the equation.
    pub symbol: &'static str,
    /// Its unit for a revolute joint; [`unit_for`](Self::unit_for) gives the unit for a prismatic joint.
    pub unit: &'static str,
    /// Smallest plausible value.
    pub min: f64,
    /// Largest plausible value.
    pub max: f64,
    /// Its value if the model file does not give it; `None`: the model file has to give it.
    pub default: Option<f64>,
    /// Its meaning, with its sign.
    pub meaning: &'static str,
    /// Whether the effect vanishes, or is another one, where this parameter is zero, whatever its other parameters are: the cause of a
    /// constant torque is no spring.
    pub is_size: bool,
}

impl ParameterSpec {
    /// A parameter without a default that may be any number.
    pub const fn new(name: &'static str, symbol: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self { name, symbol, unit, min: f64::NEG_INFINITY, max: f64::INFINITY, default: None, meaning, is_size: false }
    }

    /// With a range, ends included.
    pub const fn between(self, min: f64, max: f64) -> Self {
        Self { min, max, ..self }
    }

    /// With a lower limit.
    pub const fn at_least(self, min: f64) -> Self {
        Self { min, ..self }
    }

    /// As a parameter without which there is no such effect, see [`is_size`](Self::is_size).
    pub const fn as_size(self) -> Self {
        Self { is_size: true, ..self }
    }

    /// With a default value.
    pub const fn or(self, default: f64) -> Self {
        Self { default: Some(default), ..self }
    }

    /// Its range in words, with the unit.
    pub fn range(&self) -> String {
        Range::between(self.min, self.max, self.unit).to_string()
    }

    /// The unit on a joint of this kind: N instead of N·m and m instead of rad on a sliding joint.
    pub fn unit_for(&self, kind: crate::units::JointKind) -> &'static str {
        use crate::units::JointKind::{Prismatic, Revolute};
        match (kind, self.unit) {
            (Revolute, unit) => unit,
            (Prismatic, "N·m") => "N",
            (Prismatic, "N·m/rad") => "N/m",
            (Prismatic, "N·m·s/rad") => "N·s/m",
            (Prismatic, "N·m·s²/rad²") => "N·s²/m²",
            (Prismatic, "rad/s") => "m/s",
            (Prismatic, "1/rad") => "1/m",
            (Prismatic, "rad (joint)") => "m",
            (Prismatic, unit) => unit,
        }
    }
}

/// Description of an effect for the user.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct About {
    /// Its name, which is stable.
    pub name: &'static str,
    /// Summary in one sentence.
    pub summary: &'static str,
    /// Its equation.
    pub equation: &'static str,
    /// What it belongs to: the machine, the measurement, or a simulator.
    pub kind: Kind,
    /// What one set of parameters applies to.
    pub scope: Scope,
    /// Its parameters.
    pub parameters: &'static [ParameterSpec],
    /// How it shows in motor-side data.
    pub signature: &'static str,
    /// Names of effects with a similar signature.
    pub look_alikes: &'static [&'static str],
    /// The experiment that separates them.
    pub separate_by: &'static str,
    /// Literature reference.
    pub reference: &'static str,
}

/// A kind of experiment that can separate effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Experiment {
    /// Fast motion of all joints at once between positions.
    Fast,
    /// One joint accelerates while the others rest.
    OneByOne,
    /// Constant speeds from slow to medium in both directions, after a rest.
    SlowSteps,
    /// Slow motion back and forth through the whole range.
    WideRange,
    /// Fast motion, first without and then with a known mass on the tool.
    AddedMass,
    /// No motion, and no load on the drives.
    AtRest,
}

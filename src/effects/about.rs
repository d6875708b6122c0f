//! What is said about an effect: the text of `lostmotion explain`, and the ranges of its parameters.

use serde::Serialize;

use crate::toml_input::Range;

/// Whether the machine itself differs, or only what is measured of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The machine moves differently.
    Physics,
    /// The machine moves alike; its sensors tell otherwise.
    Measurement,
}

/// What shares one set of parameters.
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
    /// Its unit for a revolute joint; [`unit_for`](Self::unit_for) gives that of a prismatic one.
    pub unit: &'static str,
    /// Smallest value that makes sense.
    pub min: f64,
    /// Largest value that makes sense.
    pub max: f64,
    /// Its value where the model file leaves it out; `None`: it has to be given.
    pub default: Option<f64>,
    /// What it means, with its sign.
    pub meaning: &'static str,
}

impl ParameterSpec {
    /// A parameter that has to be given and may be any number.
    pub const fn new(name: &'static str, symbol: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self { name, symbol, unit, min: f64::NEG_INFINITY, max: f64::INFINITY, default: None, meaning }
    }

    /// Within a range, its ends included.
    pub const fn between(self, min: f64, max: f64) -> Self {
        Self { min, max, ..self }
    }

    /// Not below a value.
    pub const fn at_least(self, min: f64) -> Self {
        Self { min, ..self }
    }

    /// With a value where the model file leaves it out.
    pub const fn or(self, default: f64) -> Self {
        Self { default: Some(default), ..self }
    }

    /// Its range in words, with its unit.
    pub fn range(&self) -> String {
        Range::between(self.min, self.max, self.unit).to_string()
    }

    /// The unit on a joint of this kind: N for N·m and m for rad where it slides.
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

/// What is known about an effect, for people.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct About {
    /// Its name, a contract.
    pub name: &'static str,
    /// One sentence.
    pub summary: &'static str,
    /// Its equation.
    pub equation: &'static str,
    /// Machine or measurement.
    pub kind: Kind,
    /// What shares one set of parameters.
    pub scope: Scope,
    /// Its parameters.
    pub parameters: &'static [ParameterSpec],
    /// How it shows in motor-side data.
    pub signature: &'static str,
    /// Names of effects that can look alike.
    pub look_alikes: &'static [&'static str],
    /// The experiment that tells them apart.
    pub separate_by: &'static str,
    /// Where it is described.
    pub reference: &'static str,
}

/// A kind of experiment that can tell effects apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Experiment {
    /// All joints at once, quickly, from place to place.
    Fast,
    /// One joint accelerates while the others rest.
    OneByOne,
    /// Constant speeds from slow to medium, both directions, after a rest.
    SlowSteps,
    /// Slow ways through the whole range, to and fro.
    WideRange,
    /// Fast, without and then with a known mass on the tool.
    AddedMass,
    /// Nothing moves, and no drive has anything to hold.
    AtRest,
}

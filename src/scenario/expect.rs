//! Expectations of a scenario about its identification.

use std::fmt;

use crate::identify::{Identification, JointIdentification, Method, PerDirection, Quantity};

/// Largest allowed error of one quantity of one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Expectation {
    /// The joint.
    pub joint: String,
    /// Key of the scenario file: a name of `QUANTITIES`.
    pub quantity: &'static str,
    /// [%] of the truth, ≥ 0.
    pub limit_percent: f64,
}

/// An expectation that failed.
#[derive(Debug, Clone, PartialEq)]
pub struct Unmet {
    /// What was expected.
    pub expectation: Expectation,
    /// [%] Largest error found; `None` if the quantity was not identified or its truth is not known.
    pub found_percent: Option<f64>,
}

impl fmt::Display for Unmet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Expectation { joint, quantity, limit_percent } = &self.expectation;
        match self.found_percent {
            Some(found) => write!(f, "{joint}: {quantity} is off by {found:.2} %, expected at most {limit_percent} %"),
            None => write!(f, "{joint}: {quantity} was not identified, expected within {limit_percent} %"),
        }
    }
}

/// Errors [%] of a quantity in both directions; `None` if it or its truth is missing.
type Errors = fn(&JointIdentification) -> Option<[f64; 2]>;

/// Quantities that can be expected, by the name of their key.
pub const QUANTITIES: [(&str, Errors); 15] = [
    ("curve_percent", |joint| {
        let friction = &joint.friction;
        let errors = match friction.preferred {
            crate::identify::LawKind::Exponential => friction.exponential.each().map(|law| law.curve_error_percent),
            crate::identify::LawKind::TwoLines => friction.lines.each().map(|law| law.curve_error_percent),
        };
        Some([errors[0]?, errors[1]?])
    }),
    ("coulomb_percent", |joint| both(&joint.friction.exponential, |law| &law.coulomb)),
    ("breakaway_percent", |joint| both(&joint.friction.exponential, |law| &law.breakaway)),
    ("stribeck_velocity_percent", |joint| both(&joint.friction.exponential, |law| &law.stribeck_velocity)),
    ("viscous_percent", |joint| both(&joint.friction.exponential, |law| &law.viscous)),
    ("a1_percent", |joint| both(&joint.friction.lines, |law| &law.a1)),
    ("b1_percent", |joint| both(&joint.friction.lines, |law| &law.b1)),
    ("a2_percent", |joint| both(&joint.friction.lines, |law| &law.a2)),
    ("b2_percent", |joint| both(&joint.friction.lines, |law| &law.b2)),
    ("backlash_percent", |joint| one(&joint.backlash.as_ref()?.best.mean)),
    ("paper_backlash_percent", |joint| one(&joint.backlash.as_ref()?.paper.mean)),
    ("switching_backlash_percent", |joint| of_method(joint, Method::SwitchingLeastSquares, "gap")),
    ("limit_cycle_backlash_percent", |joint| of_method(joint, Method::LimitCycle, "gap")),
    ("lugre_stiffness_percent", |joint| of_method(joint, Method::Lugre, "stiffness")),
    ("lugre_damping_percent", |joint| of_method(joint, Method::Lugre, "damping")),
];

fn both<T>(laws: &PerDirection<T>, of: impl Fn(&T) -> &Quantity) -> Option<[f64; 2]> {
    let [positive, negative] = laws.each();
    Some([of(positive).error_percent?, of(negative).error_percent?])
}

fn of_method(joint: &JointIdentification, method: Method, quantity: &str) -> Option<[f64; 2]> {
    let found = joint.methods.iter().find(|one| one.method == method.name())?;
    one(found.quantities().find(|(name, _)| *name == quantity)?.1)
}

fn one(quantity: &Quantity) -> Option<[f64; 2]> {
    quantity.error_percent.map(|error| [error, error])
}

impl Expectation {
    /// The failure, if the identification knows the truth ([`Identification::compare`]) and misses the expectation.
    pub fn check(&self, identification: &Identification) -> Option<Unmet> {
        let errors = QUANTITIES.iter().find(|(name, _)| *name == self.quantity).map(|(_, errors)| errors);
        let found = identification.joint(&self.joint).zip(errors).and_then(|(joint, errors)| errors(joint));
        let found_percent = found.map(|[positive, negative]| positive.abs().max(negative.abs()));
        // NaN meets no expectation.
        let met = found_percent.is_some_and(|found| found <= self.limit_percent);
        (!met).then(|| Unmet { expectation: self.clone(), found_percent })
    }
}

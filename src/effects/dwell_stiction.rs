//! Breakaway grows with the time at rest: contacts creep together and the lubricant is squeezed out.
//!
//! ```text
//!   F_dry → F_dry + ΔF φ,   φ̇ = (1 − φ)/T − |v| φ/D          at rest φ = 1 − e^{−t/T}
//! ```
//! `φ` is how far the contacts have grown, zero when the session starts. Sliding renews them: after breakaway the growth is gone over
//! the angle `D`, whatever the speed; at a constant speed `ΔF D/(D + T |v|)` remains. The rotor's motion decides, on both of its sides.
//! Left out: growth with the logarithm of time over many decades, growth that depends on load.
//! Reference: E. Rabinowicz (1958), The intrinsic variables affecting the stick-slip process; J. H. Dieterich (1979), Modeling of rock
//! friction 1.

use std::collections::BTreeMap;

use super::parameters::{need_friction, need_joint};
use super::{About, Action, Effect, Kind, ParameterSpec, Parameters, Scope};
use crate::error::Result;
use crate::gearhead::Memory;
use crate::robot::Model;

static ABOUT: About = About {
    name: "dwell_stiction",
    summary: "Breakaway friction grows with the time at rest.",
    equation: "F_S → F_S + ΔF (1 − e^{−t/T}), t the time at rest; gone over the angle D",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("growth", "ΔF", "N·m", "growth of breakaway after a long rest").at_least(0.0),
        ParameterSpec::new("time_constant", "T", "s", "time at rest over which most of it grows").at_least(1e-3),
        ParameterSpec::new("slip_distance", "D", "rad (joint)", "motion over which sliding takes most of it away")
            .at_least(1e-6)
            .or(1e-3),
    ],
    signature: "a peak of torque at breakaway that depends on the rest before it",
    look_alikes: &["stribeck", "presliding"],
    separate_by: "start the same motion after rests of different length",
    reference: "E. Rabinowicz (1958), The intrinsic variables affecting the stick-slip process",
};

/// Breakaway grows with the time at rest.
pub struct DwellStiction;

impl Effect for DwellStiction {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        need_friction(&ABOUT, model, joint)?;
        let memory = Memory::Rest {
            growth: given.get("growth"),
            time_constant: given.get("time_constant"),
            slip_distance: given.get("slip_distance"),
        };
        Ok(vec![Action::Friction(joint, memory)])
    }
}

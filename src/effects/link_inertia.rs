//! Mass, centre of mass or inertia of a link differ from the nominal values by more than the accuracy that the model states for them.
//!
//! The ten parameters `π = (m, h, I_O)` of the body that a joint moves are `π̄ + Δ`, with `h` the first moments and `I_O` the tensor about the origin of
//! the body's frame. A motion shows only combinations of them with those of other links, the base parameters; what it does not show stays at its nominal value.
//! In a simulation the body is the nearest one that can exist.
//! Reference: M. Gautier, W. Khalil (1990), Direct calculation of minimum set of inertial parameters of serial robots.

use std::collections::BTreeMap;

use super::parameters::need_joint;
use super::{About, Action, Claim, Effect, Experiment, Kind, ParameterSpec, Parameters, Phenomenon, Scope};
use crate::error::Result;
use crate::robot::{Inertia, Model};

const fn difference(name: &'static str, symbol: &'static str, unit: &'static str) -> ParameterSpec {
    ParameterSpec::new(name, symbol, unit, "true less nominal value").between(-1e6, 1e6).or(0.0)
}

static ABOUT: About = About {
    name: "link_inertia",
    summary: "A link is heavier, lighter or otherwise distributed than the model states.",
    equation: "π = π̄ + Δ, π = (m, h, I_O)",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        difference("mass", "Δm", "kg"),
        difference("moment_x", "Δh_x", "kg·m"),
        difference("moment_y", "Δh_y", "kg·m"),
        difference("moment_z", "Δh_z", "kg·m"),
        difference("inertia_xx", "ΔI_xx", "kg·m²"),
        difference("inertia_xy", "ΔI_xy", "kg·m²"),
        difference("inertia_xz", "ΔI_xz", "kg·m²"),
        difference("inertia_yy", "ΔI_yy", "kg·m²"),
        difference("inertia_yz", "ΔI_yz", "kg·m²"),
        difference("inertia_zz", "ΔI_zz", "kg·m²"),
    ],
    signature: "torque of one link's weight and acceleration, on its own joint and on those below it",
    look_alikes: &["payload", "rotor_inertia", "torque_constant_error"],
    separate_by: "weigh the link, or repeat the motion with a known mass on it: what it adds is measured as it is",
    reference: "M. Gautier, W. Khalil (1990), Direct calculation of minimum set of inertial parameters of serial robots",
};

/// A link differs from its nominal inertia.
pub struct LinkInertia;

impl Effect for LinkInertia {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        if let Some(body) = model.robot.bodies.get_mut(joint) {
            let mut parameters = body.inertia.parameters();
            for (value, spec) in parameters.iter_mut().zip(ABOUT.parameters) {
                *value += given.get(spec.name);
            }
            body.inertia = Inertia::nearest(&parameters);
        }
        Ok(Vec::new())
    }

    fn shown_by(&self) -> &'static [Experiment] {
        &[Experiment::AddedMass, Experiment::Fast, Experiment::OneByOne]
    }

    fn claims(&self, phenomenon: &Phenomenon) -> Option<Claim> {
        let Phenomenon::OtherLink { difference } = phenomenon else { return None };
        Some(ABOUT.parameters.iter().zip(difference).map(|(spec, estimate)| (spec.name, *estimate)).collect())
    }
}

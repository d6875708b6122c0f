//! The controller with which a measurement is rehearsed, and the lag that its plan reckons with.
//!
//! ```text
//!   K_S/Φ = max(5/s · J, 2 F_S/(0.22 s λ v_N))      λ = 3.5/s      K_S = 1.3 F      limit of the velocity error 0.4 F_S/(K_S/Φ)
//!   lag at a reversal l = 2 F_S/(λ K_S/Φ)      
//! ```
//! These are the rules behind the gains of scenario 01 (4.8 and 6.6/s, 3.5 and 4/s, 1.3 and 1.3, 0.43 and 0.31), whose README says why they are
//! neither higher nor lower. `F`: largest friction, `J`: inertia of rotor and link. It is written where the friction of all joints is known; else
//! the careful controller of a first experiment is, and the lag is that of its gains.

use std::fmt::Write as _;

use super::information::Possible;
use crate::control::SlidingGains;
use crate::robot::{Model, two_digits};
use crate::toml_input::written_key;

/// [1/s] `K_S/Φ` per inertia.
const DAMPING: f64 = 5.0;
/// [s] Longest time in which the fastest speed `v_N` takes up the lag: joints with much friction for their inertia need a higher gain.
const LAG_TIME: f64 = 0.22;
/// [1/s] `λ`.
const LAMBDA: f64 = 3.5;
/// [1] `K_S` per friction.
const SWITCHING: f64 = 1.3;
/// [1] Torque of the largest velocity error per breakaway friction.
const LIMIT: f64 = 0.4;
/// [1/√s] Random walk of the observer's disturbance per breakaway friction: 0.18 and 0.22 in scenario 01.
const DISTURBANCE: f64 = 0.2;

/// Gains of a joint with what follows from them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Regulation {
    gains: SlidingGains,
    /// [rad/s or m/s] Largest velocity error; infinite: no limit.
    limit: f64,
    /// [N·m/√s or N/√s]
    disturbance: f64,
    /// `l` [rad or m]
    pub lag: f64,
}

impl Regulation {
    /// For a joint with known friction, that moves an inertia [kg·m² or kg] at up to a speed [rad/s or m/s].
    pub fn tuned(possible: &Possible, inertia: f64, fastest: f64) -> Self {
        let at_rest = possible.largest(0.0);
        let gain = (DAMPING * inertia).max(2.0 * at_rest / (LAG_TIME * LAMBDA * fastest));
        let switching = SWITCHING * at_rest.max(possible.largest(fastest));
        let gains = SlidingGains { lambda: LAMBDA, switching, boundary: switching / gain };
        Self { limit: LIMIT * at_rest / gain, disturbance: DISTURBANCE * at_rest, ..Self::with(gains, possible) }
    }

    /// With given gains.
    pub fn with(gains: SlidingGains, possible: &Possible) -> Self {
        let stiffness = gains.lambda * gains.switching / gains.boundary;
        Self { gains, limit: f64::INFINITY, disturbance: 0.0, lag: 2.0 * possible.largest(0.0) / stiffness }
    }
}

/// Writes the tuned controller, one regulation per joint of the model.
pub fn write<'a>(text: &mut String, model: &Model, regulations: impl Iterator<Item = &'a Regulation>) {
    *text += "\n[controller]\nlaw = \"sliding_mode\"\nvelocity = \"observer\"\n";
    for (joint, one) in model.joints.iter().zip(regulations) {
        let Regulation { gains: SlidingGains { lambda, switching, boundary }, limit, disturbance, .. } = one;
        let _ = writeln!(
            text,
            "[controller.joints.{}]\nlambda = {lambda:?}\nswitching = {:?}\nboundary = {:?}\nvelocity_error_limit = {:?}\n\
             disturbance_noise = {:?}",
            written_key(&joint.name),
            two_digits(*switching),
            two_digits(*boundary),
            two_digits(*limit),
            two_digits(*disturbance)
        );
    }
}

//! Friction is a stiff spring before sliding starts: the asperities of the surfaces bend like bristles (LuGre).
//!
//! ```text
//!   ż = v − σ0 |v| z/g(v)        F = σ0 z + σ1 ż + F_V v          g(v) = F_C + (F_S − F_C) e^{−|v|/v_S}
//! ```
//! It replaces the set-valued law of the rotor. For tiny displacements `dF/dθ = σ0`; after a reversal friction follows a hysteresis
//! over the angle `F/σ0`; at constant speed it equals the law. `g` and `F_V` are those of the model, in the rotor's share.
//! Left out: bristles of the link's share, which remains dry friction; `σ1` that decreases with speed.
//! Reference: C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky (1995), A new model for control of systems with friction.

use std::collections::BTreeMap;

use super::parameters::{misfit, need_friction, need_joint};
use super::{About, Action, AtTurns, Effect, Kind, ParameterSpec, Parameters, Scope, Trial, Turns};
use crate::error::Result;
use crate::gearhead::{Direction, Memory};
use crate::robot::Model;

static ABOUT: About = About {
    name: "presliding",
    summary: "Friction yields like a stiff spring before it slips.",
    equation: "ż = v − σ0 |v| z/g(v), F = σ0 z + σ1 ż + F_V v",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("stiffness", "σ0", "N·m/rad", "stiffness of the rotor's friction before it slips")
            .between(1e-6, 1e11),
        ParameterSpec::new("damping", "σ1", "N·m·s/rad", "damping of that spring, about √(σ0 J)").between(0.0, 1e9),
    ],
    signature: "after each reversal a hysteresis of torque against angle, the same at every speed",
    look_alikes: &["joint_compliance", "position_dependent_backlash", "stribeck"],
    separate_by: "strokes smaller than the hysteresis: the torque needed is proportional to the stroke, with a gap it is not",
    reference: "C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky (1995), A new model for control of systems with friction",
};

/// [1/s] Fastest rate of bristles that is simulated: a step of a microsecond.
const FASTEST: f64 = 1e6;

/// Friction yields before sliding starts.
pub struct Presliding;

impl Effect for Presliding {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        let (stiffness, damping) = (given.get("stiffness"), given.get("damping"));
        let friction = *need_friction(&ABOUT, model, joint)?;
        let dry = [Direction::Positive, Direction::Negative].map(|side| friction.law.coulomb(side));
        let dry = (1.0 - friction.link_share) * dry[0].min(dry[1]);
        if dry <= 0.0 {
            let expected = "Coulomb friction on the rotor in both directions: coulomb > 0, link_share < 1".to_owned();
            return Err(misfit(&ABOUT, model, "stiffness", stiffness, expected));
        }
        // The bristles oscillate with the rotor, and follow it while sliding; the integrator has to resolve both.
        // Where the rotor is unknown, the plant takes a share of its link, which the bound on the gear's fastest motion judges.
        let inertia =
            model.joints[joint].rotor_inertia.map_or(f64::INFINITY, |_| model.joints[joint].reflected_inertia());
        let speed = Some(model.robot.bodies[joint].joint.limits.velocity).filter(|limit| limit.is_finite());
        let bound =
            (0.01 * FASTEST * FASTEST * inertia).min(speed.map_or(f64::INFINITY, |speed| FASTEST * dry / speed));
        if stiffness > bound {
            let expected = format!("at most {bound:.3e}, stiffer bristles take steps below a microsecond");
            return Err(misfit(&ABOUT, model, "stiffness", stiffness, expected));
        }
        Ok(vec![Action::Friction(joint, Memory::Bristles { stiffness, damping })])
    }

    fn at_turns(&self) -> Option<&dyn AtTurns> {
        Some(self)
    }
}

/// Angles `F_C/σ0` of bending bristles that are tried, in counts of the encoder.
const BENDS: [f64; 5] = [2.0, 4.0, 8.0, 16.0, 32.0];
/// Value of `σ1/√(σ0 J)` that is tried.
const DAMPED: f64 = 1.0;
/// Least angle `F_C/σ0`, in counts of the encoder. With a smaller angle, bristles cannot be separated from dry friction: within a count the
/// rotor's motion does not show, and the fit describes the blur of a gap. Machines with cogging or a disturbance (tuning seeds
/// 2401, 4601, 4701) were fitted with 0.4 to 1.2 counts, presliding of half the strength (5300, 5301) with 4 and more.
const LEAST_BEND: f64 = 2.0;

/// Least angle `F_C/σ0`, in wind-ups `F_C/k` of the gear as the model states it. Friction `s F_C` of the link that reverses bends the gear by up to
/// `2 F_C/k`, and a gear five times as soft as stated is [`joint_compliance`](super::joint_compliance): up to that, bristles cannot be separated
/// from the gear. Healthy arms under gravity (tuning seeds 62400, 63200) were fitted with one wind-up, presliding of half the strength with twenty
/// and more.
const LEAST_WIND_UPS: f64 = 10.0;

impl AtTurns for Presliding {
    fn trials(&self, seen: &Turns) -> Vec<Trial> {
        let joint = &seen.motion.model.joints[seen.joint];
        let dry = seen.motion.joints[seen.joint].friction.coulomb;
        let count = joint.encoder_step();
        let links = &seen.motion.joints[seen.joint].link_inertia;
        let rotor = joint.rotor_beside(links.first().copied().unwrap_or(0.0));
        let trial = |bend: f64| {
            let stiffness = dry / (bend * count);
            let damping = DAMPED * (stiffness * rotor).sqrt();
            Trial {
                values: vec![stiffness, damping],
                // Smooth motion blurs the damping: its estimate is up to twice too large.
                scales: vec![0.5 * stiffness, 3.0 * damping],
                proportional: false,
            }
        };
        if count > 0.0 && dry > 0.0 { BENDS.into_iter().map(trial).collect() } else { Vec::new() }
    }

    // It fits any soft behaviour at a reversal: a compliant gear reaches 100 nats and a fall of 0.2, presliding of 2 mrad 300 and 0.4.
    fn reserve(&self) -> f64 {
        50.0
    }

    fn least_fall(&self) -> f64 {
        0.25
    }

    fn visible(&self, seen: &Turns, values: &[f64]) -> bool {
        let joint = &seen.motion.model.joints[seen.joint];
        let dry = seen.motion.joints[seen.joint].friction.coulomb;
        shows(values[0], dry, joint.encoder_step(), joint.gear_stiffness)
    }
}

/// Whether bristles of stiffness `σ0` that carry `F_C` bend so far that neither the encoder's counts [rad or m] nor the gear of stiffness
/// `k` can explain the bend. A gear of unknown stiffness may be as soft as the bristles.
fn shows(stiffness: f64, dry: f64, count: f64, gear: Option<f64>) -> bool {
    let bend = dry / stiffness;
    bend > LEAST_BEND * count && gear.is_some_and(|k| bend > LEAST_WIND_UPS * dry / k)
}

#[cfg(test)]
mod tests {
    use super::shows;

    #[test]
    fn property_bristles_show_beyond_counts_and_gear() {
        let (dry, count, gear) = (5.0, 8e-7, Some(3e4));
        assert!(shows(600.0, dry, count, gear));
        // What a healthy gear of 3·10⁴ N·m/rad was fitted with.
        assert!(!shows(29_090.0, dry, count, gear));
        // A gear that is five times as soft as stated.
        assert!(!shows(6_000.0, dry, count, gear));
        // A bend of one count.
        assert!(!shows(dry / 0.01, dry, 0.01, gear));
        assert!(!shows(600.0, dry, count, None));
    }
}

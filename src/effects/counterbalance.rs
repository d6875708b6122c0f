//! A spring balancer between a point of the link and a point of the body before it, as large robots have on their second axis.
//!
//! ```text
//!   τ = −k a b sin φ (1 − l0/L),  φ = q − q0,  L² = a² + b² − 2 a b cos φ      k, l0: spring; a, b: distances of its ends from the axis
//!     ≈ −c sin φ,  c = k a b (1 − l0/b)  for a ≪ b                            on the joint; the motor has to add c sin φ
//! ```
//! Motor-side data identify the first harmonic: amplitude `c` and angle `q0`. Sign: `c` > 0 pulls towards `q0`; a balancer, which is to lift
//! a link, pulls towards the position in which the link stands up.
//! It turns with the angle of its own joint alone: gravity and payloads turn with the sum of the angles of the joints before, and with the
//! base. On a joint that nothing moved carries and whose axis is level, a load on the link is the same torque.
//! Left out: the second harmonic, `c₂/c = a l0/(2 b (b − l0))`, 8 % for `a = b/6` and `l0 = b/2`; friction and mass of the spring.
//! Reference: V. Arakelian (2016), Gravity compensation in robotics.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::parameters::{misfit, need_joint};
use super::{
    About, Action, Diagnosable, Effect, Experiment, JointAction, JointState, Kind, Motion, ParameterSpec, Parameters,
    Scope,
};
use crate::error::Result;
use crate::robot::Model;
use crate::units::JointKind;

static ABOUT: About = About {
    name: "counterbalance",
    summary: "A spring balancer pulls the link towards an angle.",
    equation: "τ = −c sin(q − q0) on the link",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[
        ParameterSpec::new("amplitude", "c", "N·m", "largest torque of the balancer, positive towards its angle")
            .between(0.0, 1e7)
            .as_size(),
        ParameterSpec::new("angle", "q0", "rad (joint)", "angle of the joint towards which it pulls")
            .between(-TAU, TAU),
    ],
    signature: "a torque like a sine of the angle of one joint, whatever direction, speed and pose of the others",
    look_alikes: &["payload", "link_inertia", "base_tilt", "cable_spring", "cogging"],
    separate_by: "repeat the motion with another pose of the joints before it: gravity turns with them, a balancer does not; accelerate: a load is heavy, a spring is not",
    reference: "V. Arakelian (2016), Gravity compensation in robotics",
};

/// A spring balancer.
pub struct Counterbalance;

struct Balancer {
    c: f64,
    q0: f64,
}

impl JointAction for Balancer {
    fn link_torque(&self, state: &JointState) -> f64 {
        -self.c * (state.link_position - self.q0).sin()
    }
}

impl Effect for Counterbalance {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let given = Parameters::check(&ABOUT, model, given)?;
        let joint = need_joint(&ABOUT, model, joint)?;
        let balancer = Balancer { c: given.get("amplitude"), q0: given.get("angle") };
        if model.joints[joint].kind == JointKind::Prismatic {
            let expected = format!("a joint that turns: {} slides", model.joints[joint].name);
            return Err(misfit(&ABOUT, model, "angle", balancer.q0, expected));
        }
        Ok(vec![Action::Joint(joint, Box::new(balancer))])
    }

    fn shown_by(&self) -> &'static [Experiment] {
        &[Experiment::WideRange]
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }
}

/// [rad] Least range `r` of a joint. Over a smaller one a sine of unknown phase is a parabola up to `r³/192` of its amplitude, 0.7 %, and a
/// straight line up to `r²/16`, 8 %: then it is a `cable_spring` for all that can be seen.
const LEAST_RANGE: f64 = 1.1;

impl Diagnosable for Counterbalance {
    fn applies(&self, motion: &Motion, joint: usize) -> bool {
        motion.model.joints[joint].kind == JointKind::Revolute && motion.range(joint) > LEAST_RANGE
    }

    fn loads_link(&self) -> bool {
        true
    }

    // Weights are often wrong, a balancer is seldom forgotten.
    fn yields_to(&self) -> &'static [&'static str] {
        &["link_inertia", "payload"]
    }

    fn columns(&self, motion: &Motion, joint: usize, _shape: &[f64]) -> Vec<Vec<f64>> {
        let q = motion.link(joint);
        vec![q.iter().map(|q| q.sin()).collect(), q.iter().map(|q| q.cos()).collect()]
    }

    fn angles_of_link(&self) -> &'static [&'static str] {
        &["angle"]
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> Vec<f64> {
        // c sin(q − q0) = c cos q0 · sin q − c sin q0 · cos q
        vec![coefficients[0].hypot(coefficients[1]), (-coefficients[1]).atan2(coefficients[0])]
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    /// First and second harmonic of the spring between two points, by its Fourier integrals.
    #[test]
    fn analytic_the_second_harmonic_that_is_left_out() {
        let (k, a, b, l0) = (2e4, 0.1, 0.6, 0.3);
        let torque = |phi: f64| {
            let l = (a * a + b * b - 2.0 * a * b * phi.cos()).sqrt();
            k * a * b * phi.sin() * (1.0 - l0 / l)
        };
        let harmonic = |n: f64| {
            let steps = 720;
            let at = |i: usize| (i as f64 + 0.5) * TAU / steps as f64;
            (0..steps).map(|i| torque(at(i)) * (n * at(i)).sin()).sum::<f64>() * 2.0 / steps as f64
        };
        let (first, second) = (harmonic(1.0), harmonic(2.0));
        let ratio = (second / first).abs();
        println!("first {first:.1} N·m, second {:.1} %", 100.0 * ratio);
        // Both are the first terms of series in a/b, whose next terms are smaller by (a/b)² = 3 %.
        assert!((first / (k * a * b * (1.0 - l0 / b)) - 1.0).abs() < 0.03, "{first}");
        assert!((ratio / (a * l0 / (2.0 * b * (b - l0))) - 1.0).abs() < 0.06, "{ratio}");
    }
}

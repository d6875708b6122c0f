//! Friction of another simulator: smooth through zero velocity, so that a joint creeps under load where it should stick.
//!
//! ```text
//!   F(v) sgn v → F(v) tanh(|v|/v_r) sgn v            F |      ____ F(v)
//!                                                      |   .´
//!   creep under a load τ < F(0):                       | /
//!   v = v_r artanh(τ/F(0))                             +--------- |v|
//!                                                         v_r
//! ```
//! Sets of data made by simulators that cannot stick have it; no machine does. `F` is the law of the model, of rotor and link together.
//! In rows it is a lack of friction at speeds up to some `v_r`, the whole of it at rest; it is averaged over the kernel of a row like the
//! falling part of friction ([`falling`](super::falling())). At reversals it is a friction that passes through zero.
//! Sign: a magnitude that is smaller than the law's; it opposes the motion.
//! Where the model file gives no friction, the free law of the baseline takes most of the lack for a breakaway below Coulomb friction, and
//! the effect is named only if its shape shows: `explain` advises to give the friction.
//! Left out: other regularisations. `v/√(v² + v_r²)` is nearest to a `tanh` of a `v_r` that is 1.16 times as large, within 5 % of `F`.
//! Reference: E. Pennestrì, V. Rossi, P. Salvini, P. P. Valentini (2016), Review and comparison of dry friction force models.

use std::collections::BTreeMap;

use nalgebra::DMatrix;

use super::falling::over_kernel;
use super::parameters::{misfit, need_friction, need_joint};
use super::{
    About, Action, AtTurns, Diagnosable, Effect, Experiment, JointAction, JointMotion, JointState, Kind, Motion,
    ParameterSpec, Parameters, Scope, SymmetricFriction, Trial, Turns,
};
use crate::dynamics::Dynamics;
use crate::error::Result;
use crate::gearhead::Direction;
use crate::robot::Model;

static ABOUT: About = About {
    name: "regularised_friction",
    summary: "Friction is smooth through zero velocity, as in a simulator that cannot stick.",
    equation: "F(v) sgn v → F(v) tanh(|v|/v_r) sgn v",
    kind: Kind::Simulation,
    scope: Scope::Joint,
    parameters: &[ParameterSpec::new(
        "velocity",
        "v_r",
        "rad/s",
        "velocity over which friction rises from zero to its law: three quarters of it at v_r",
    )
    .between(1e-9, 1e4)
    .as_size()],
    signature: "friction that vanishes towards zero velocity, in both directions alike: the joint creeps under load instead of sticking",
    look_alikes: &["presliding", "dwell_stiction", "stribeck", "rotor_inertia", "quadratic_drag"],
    separate_by: "load the joint at rest for seconds: it creeps at a constant speed, where bristles yield once and a machine sticks; give the friction in the model file, or a free law takes part of it",
    reference: "E. Pennestrì, V. Rossi, P. Salvini, P. P. Valentini (2016), Review and comparison of dry friction force models",
};

/// [1/s] Fastest rate of friction that is simulated: a step of a microsecond.
const FASTEST: f64 = 1e6;

/// Friction that is smooth through zero velocity.
pub struct RegularisedFriction;

struct Smooth {
    /// `v_r` [rad/s or m/s].
    velocity: f64,
    /// `F(0)/(v_r J)` [1/s] of the rotor alone: how fast friction brings it to its creep.
    rate: f64,
}

impl JointAction for Smooth {
    fn dry_friction(&self, state: &JointState, level: f64) -> f64 {
        level * (state.motor_velocity.abs() / self.velocity).tanh()
    }

    fn fastest(&self, _speed: f64) -> f64 {
        self.rate
    }
}

impl Effect for RegularisedFriction {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, model: &mut Model, joint: Option<usize>, given: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        let velocity = Parameters::check(&ABOUT, model, given)?.get("velocity");
        let joint = need_joint(&ABOUT, model, joint)?;
        let friction = *need_friction(&ABOUT, model, joint)?;
        let at_rest = [Direction::Positive, Direction::Negative].map(|side| friction.law.magnitude(side, 0.0).max(0.0));
        let dof = model.robot.dof();
        let mut mass = DMatrix::zeros(dof, dof);
        Dynamics::new(&model.robot).mass_matrix(&vec![0.0; dof], &mut mass);
        let inertia = model.joints[joint].rotor_beside(mass[(joint, joint)]);
        let slope = at_rest[0].max(at_rest[1]) / inertia;
        if slope > FASTEST * velocity {
            let expected =
                format!("at least {:.3e}, steeper friction takes steps below a microsecond", slope / FASTEST);
            return Err(misfit(&ABOUT, model, "velocity", velocity, expected));
        }
        Ok(vec![Action::Joint(joint, Box::new(Smooth { velocity, rate: slope / velocity }))])
    }

    fn shown_by(&self) -> &'static [Experiment] {
        &[Experiment::SlowSteps]
    }

    fn diagnosable(&self) -> Option<&dyn Diagnosable> {
        Some(self)
    }

    fn at_turns(&self) -> Option<&dyn AtTurns> {
        Some(self)
    }
}

/// Lack of friction at rest, relative to Coulomb friction: the whole of a law whose breakaway is anything from half to twice of it. A law
/// that only falls or rises with speed lacks less: breakaway friction of a real contact is not below its Coulomb friction.
const LACKS: [f64; 2] = [0.5, 2.5];
/// `tanh` of more is one to the last bit.
const SATURATED: f64 = 20.0;
/// Ratio of one velocity that is tried to the next.
const SCAN_STEP: f64 = 1.4;
/// Slowest velocity that is tried, relative to the speed that one row in twenty is below: a slower one shows in no row.
const SLOWEST: f64 = 0.5;
/// Fastest, relative to the largest speed: a faster one is viscous friction.
const HIGHEST: f64 = 0.2;

/// The speeds [rad/s or m/s] of the rows in motion, in order.
fn speeds(motion: &Motion, joint: usize) -> Vec<f64> {
    let m = &motion.joints[joint];
    let rows = m.v.iter().zip(&m.direction).filter(|(_, direction)| **direction != 0.0);
    let mut speeds: Vec<f64> = rows.map(|(v, _)| v.abs()).collect();
    speeds.sort_by(f64::total_cmp);
    speeds
}

impl Diagnosable for RegularisedFriction {
    /// Friction of a machine sticks. Smooth up to the speeds of a whole motion, the law resembles a drag.
    fn yields_to(&self) -> &'static [&'static str] {
        &["quadratic_drag"]
    }

    fn applies(&self, motion: &Motion, joint: usize) -> bool {
        motion.joints[joint].friction.coulomb > 0.0
    }

    fn shapes(&self, motion: &Motion, joint: usize) -> Vec<Vec<f64>> {
        let speeds = speeds(motion, joint);
        let (Some(fastest), Some(slow)) = (speeds.last(), speeds.get(speeds.len() / 20)) else { return Vec::new() };
        let mut shapes = Vec::new();
        let mut velocity = (SLOWEST * slow).max(1e-5 * fastest);
        while velocity < HIGHEST * fastest {
            shapes.push(vec![velocity]);
            velocity *= SCAN_STEP;
        }
        shapes
    }

    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        let v_r = shape[0].abs().max(1e-12);
        // Without the falling part: a free law that had to take the lack for its own has none that could be believed.
        let SymmetricFriction { coulomb, viscous, .. } = motion.joints[joint].friction;
        let lack = |v: f64| {
            let direction = if v == 0.0 { 0.0 } else { v.signum() };
            (coulomb + viscous * v.abs()) * ((v / v_r).tanh() - direction)
        };
        let row = |m: &JointMotion, row: usize| {
            if m.direction[row] == 0.0 {
                return 0.0;
            }
            let change = m.a.get(row).map_or(0.0, |a| a.abs() * motion.half_width[row]);
            if m.v[row].abs() - change > SATURATED * v_r {
                return 0.0;
            }
            over_kernel(|u| lack(m.v[row] + change * u))
        };
        vec![motion.column(joint, row)]
    }

    fn is_itself(&self, _motion: &Motion, _joint: usize, _shape: &[f64], coefficients: &[f64]) -> bool {
        (LACKS[0]..=LACKS[1]).contains(&coefficients[0])
    }

    fn parameters(&self, _motion: &Motion, _joint: usize, shape: &[f64], _coefficients: &[f64]) -> Vec<f64> {
        vec![shape[0].abs()]
    }
}

/// Velocities that are tried at reversals, relative to the speed that half of the rows are below.
const TRIED: [f64; 4] = [0.003, 0.01, 0.03, 0.1];
/// Least way in counts of the encoder that the rotor covers at `v_r` in a hundredth of a second: below it, a law that passes through zero
/// looks like one that changes its sign.
const LEAST_WAY: f64 = 0.5;

impl AtTurns for RegularisedFriction {
    fn trials(&self, seen: &Turns) -> Vec<Trial> {
        let speeds = speeds(seen.motion, seen.joint);
        let Some(middle) = speeds.get(speeds.len() / 2).filter(|middle| **middle > 0.0) else { return Vec::new() };
        let trial = |velocity: f64| Trial { values: vec![velocity], scales: vec![velocity], proportional: false };
        TRIED.into_iter().map(|part| trial(part * middle)).collect()
    }

    // It fits any soft behaviour at a reversal, as bristles do.
    fn reserve(&self) -> f64 {
        50.0
    }

    fn least_fall(&self) -> f64 {
        0.25
    }

    fn visible(&self, seen: &Turns, values: &[f64]) -> bool {
        0.01 * values[0] > LEAST_WAY * seen.motion.model.joints[seen.joint].encoder_step()
    }
}

//! Whether a model can be simulated: all joints move to and fro for a second in closed loop.
//!
//! ```text
//!   q_d: by w towards the farther end of each joint's room, and back, half a second each     w ≤ 0.04 s² · a/√n, 0.2 s · v
//! ```
//! It begins in the first of four postures in which the joints can hold the arm's weight, among them all joints near zero, and in the middle of
//! their rooms. `a/√n`: all n joints accelerate at once, and each feels the others. A joint follows if it is within half of `w` of its
//! reference at both ends, or where its friction at rest holds against the feedback. Each joint is controlled by itself
//! ([`Independent`](crate::control::Independent)), with gains that follow from its inertia and friction, and with the torque of its
//! link's damping at the planned velocity.

use super::reach::{Reach, reaches, starts};
use super::{ControllerSettings, Feedback, Keep, Law, Regulator, STEPS_A_SECOND, Timing, closed_loop};
use crate::control::{Profile, SlidingGains};
use crate::dynamics::Dynamics;
use crate::error::Result;
use crate::gearhead::{Direction, FrictionLaw};
use crate::plant::{Options, Plant};
use crate::robot::{JointModel, Model};
use crate::units::JointKind;

/// [s] Duration of each move, with the rest before it.
const LEG: f64 = 0.5;

/// [s] Rest before each move.
const REST: f64 = 0.05;

/// [s] Longest duration of a move.
const WAY: f64 = 0.4;

/// [s] Between two readings: rotors that are light for their links need a fast loop.
const PERIOD: f64 = 2.5e-4;

/// [s] Computing time after which a trial is given up.
const PATIENCE: f64 = 60.0;

/// [1/s] Bandwidth of the velocity loop: below the resonance of common gears, above the speed of a careful motion.
const BANDWIDTH: f64 = 20.0;

/// [1] `λ` of the controller as a share of the bandwidth of its velocity loop: the poles of both loops are real and equal.
const LAMBDA: f64 = 0.25;

/// [1] Gain per rotor inertia, times the interval of readings: a rotor alone stays stable within its gap and on its gear.
const OF_ROTOR: f64 = 0.2;

/// [1] Switching torque per friction that the controller has to overcome.
const MARGIN: f64 = 3.0;

/// [rad/s or m/s] Error of velocity at which the switching torque reaches its full value, where friction requires it.
const ALLOWED_ERROR: f64 = 0.1;

/// What a trial shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// [s] that were simulated.
    pub duration: f64,
    /// Joints that moved.
    pub joints: usize,
    /// What failed, one sentence each; empty if every joint followed.
    pub faults: Vec<String>,
}

/// Moves all joints of a model for a second.
///
/// # Errors
/// The machine cannot be built: an effect does not fit, a gear is too fast.
pub fn trial(model: &Model) -> Result<Trial> {
    let share = (model.joints.len().max(1) as f64).sqrt();
    let gentle = |reach: Reach| Reach { acceleration: reach.acceleration / share, ..reach };
    let reaches: Vec<Reach> = reaches(model).into_iter().map(gentle).collect();
    let most_steps = (PATIENCE * STEPS_A_SECOND / reaches.len().max(1) as f64) as usize;
    let mut plant = Plant::new(model, &Options { most_steps, ideal_sensors: true, ..Options::default() })?;
    let (start, mut faults) = begin(model, &reaches);
    let end: Vec<f64> = reaches.iter().zip(&start).map(|(reach, start)| start + way(reach, *start)).collect();
    plant.place(&start);
    let mut regulator = Regulator::new(model, &settings(model, &reaches), PERIOD);
    if model.robot.coupling.is_none() {
        regulator.feed_damping_forward(model.robot.bodies.iter().map(|body| body.joint.damping).collect());
    }
    for (from, to) in [(&start, &end), (&end, &start)] {
        if let Err(error) = go(&mut plant, &mut regulator, &reaches, from, to) {
            faults.push(error.to_string());
            break;
        }
        faults.extend(missed(model, &plant, &reaches, from, to));
    }
    Ok(Trial { duration: 2.0 * LEG, joints: reaches.len(), faults })
}

/// Moves all joints from one posture to another.
fn go(plant: &mut Plant, regulator: &mut Regulator, reaches: &[Reach], from: &[f64], to: &[f64]) -> Result<()> {
    let mut profile = Profile::at_rest(from);
    for ((track, reach), to) in profile.tracks_mut().iter_mut().zip(reaches).zip(to) {
        track.coast(REST);
        track.move_to(*to, reach.speed, reach.acceleration);
    }
    let timing = Timing { period: PERIOD, duration: LEG - PERIOD };
    closed_loop(plant, regulator, &profile, timing, Keep::Nothing, &mut |_| {}).map(drop)
}

/// [rad or m] A joint that is this close to its reference has reached it, however short its move was.
const fn near(kind: JointKind) -> f64 {
    match kind {
        JointKind::Revolute => 2e-3,
        JointKind::Prismatic => 2e-4,
    }
}

/// [N·m or N] Friction of a joint's gear at a speed, in its worse direction; 0 where it is unknown.
fn gear_friction(joint: &JointModel, speed: f64) -> f64 {
    let of_law =
        |law: &FrictionLaw| law.magnitude(Direction::Positive, speed).max(law.magnitude(Direction::Negative, speed));
    joint.friction.map_or(0.0, |friction| of_law(&friction.law))
}

/// [rad or m] How far from its reference the friction of a joint can hold it against the feedback, whose stiffness is `λ K_S/Φ`.
fn held(model: &Model, reaches: &[Reach], index: usize) -> f64 {
    let SlidingGains { lambda, switching, boundary } = gains(model, reaches, index, PERIOD);
    let friction = gear_friction(&model.joints[index], 0.0) + model.robot.bodies[index].joint.friction;
    friction * boundary / (lambda * switching)
}

/// Joints that have not reached their targets.
fn missed(model: &Model, plant: &Plant, reaches: &[Reach], from: &[f64], to: &[f64]) -> Vec<String> {
    let mut faults = Vec::new();
    for (i, (reach, state)) in reaches.iter().zip(plant.states()).enumerate() {
        let (off, way) = (state.motor_position - to[i], to[i] - from[i]);
        if off.abs() > (0.5 * way.abs()).max(near(model.joints[i].kind)).max(held(model, reaches, i)) {
            let unit = model.joints[i].kind.position_unit();
            faults.push(format!("joint {}: {off:.3e} {unit} off after a move of {way:.3e} {unit}", reach.name));
        }
    }
    faults
}

/// The first posture in which all joints can hold the arm's weight; if there is none, the first of all, with the joints that cannot.
fn begin(model: &Model, reaches: &[Reach]) -> (Vec<f64>, Vec<String>) {
    let mut refused = None;
    for start in starts(reaches) {
        let faults = overloads(model, &start);
        if faults.is_empty() {
            return (start, faults);
        }
        refused.get_or_insert((start, faults));
    }
    refused.unwrap_or_default()
}

/// `w` [rad or m]: the distance of a joint's move towards the farther end of its room, within the time [`WAY`] from rest to rest.
fn way(reach: &Reach, start: f64) -> f64 {
    let (up, down) = (reach.middle + reach.half - start, start - (reach.middle - reach.half));
    let size = up.max(down).min(0.25 * WAY * WAY * reach.acceleration).min(0.5 * WAY * reach.speed);
    if up < down { -size } else { size }
}

/// Joints that cannot hold the arm within their effort limits.
fn overloads(model: &Model, posture: &[f64]) -> Vec<String> {
    let mut weight = vec![0.0; posture.len()];
    Dynamics::new(&model.robot).gravity(posture, &mut weight);
    let overload = |(weight, body): (&f64, &crate::robot::Body)| {
        let (name, effort, unit) = (&body.joint.name, body.joint.limits.effort, body.joint.kind.effort_unit());
        (weight.abs() > effort).then(|| {
            format!(
                "joint {name}: the arm's weight needs {:.3} {unit} at the start, its effort limit is {effort} {unit}",
                weight.abs()
            )
        })
    };
    weight.iter().zip(&model.robot.bodies).filter_map(overload).collect()
}

/// A controller for a machine that has no tuned one.
fn settings(model: &Model, reaches: &[Reach]) -> ControllerSettings {
    ControllerSettings {
        law: Law::Independent((0..reaches.len()).map(|index| gains(model, reaches, index, PERIOD)).collect()),
        feedback: vec![Feedback::Sensor; reaches.len()],
        velocity_error_limit: vec![f64::INFINITY; reaches.len()],
    }
}

/// Gains of a joint that is read every `period` [s]: `K_S` three times the friction at its speed, `K_S/Φ` 20/s times its inertia or more
/// where friction requires it, as far as the rotor allows.
pub(super) fn gains(model: &Model, reaches: &[Reach], index: usize, period: f64) -> SlidingGains {
    let (joint, reach, link) = (&model.joints[index], &reaches[index], &model.robot.bodies[index].joint);
    let own = gear_friction(joint, 0.0).max(gear_friction(joint, reach.speed));
    let friction = own + link.friction + link.damping * reach.speed;
    let rotor = joint.rotor_beside(reach.inertia);
    let gain = (BANDWIDTH * reach.inertia).max(friction / ALLOWED_ERROR).min(OF_ROTOR / period * rotor);
    let switching = MARGIN * friction + ALLOWED_ERROR * gain;
    // A rotor that is light for its link allows a slow loop only.
    let lambda = LAMBDA * BANDWIDTH.min(gain / reach.inertia);
    SlidingGains { lambda, switching, boundary: switching / gain }
}

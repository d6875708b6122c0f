//! The first experiment on an arm whose friction is unknown: a staircase of constant speeds on one joint after the other, while the
//! others rest.
//!
//! ```text
//!   v_k = k v_1, k = 1 … 10       v_10 = 0.175 rad/s (10 deg/s) or 0.05 m/s, at most 0.3 of the joint's limit, less where its room is small
//! ```
//! Each speed is held in both directions for a second or more. The three slowest brake gently: at their reversals the gap is measured
//! ([`Staircase`](crate::control::Staircase)). The plan keeps within the range, speed and effort of every joint, its links keep apart, and it begins
//! and ends at rest. Effort is that of the links and rotors with a margin of 1.3 for the friction that is unknown.
//! It is written as a scenario, which rehearses it in simulation, and as a table of references that a real controller can play.

use std::fmt::Write as _;
use std::path::Path;

use super::reach::{Reach, reaches, starts};
use super::trial::gains;
use super::{Scenario, Session};
use crate::control::Target;
use crate::dynamics::Dynamics;
use crate::error::{Error, Place, Result};
use crate::gearhead::{Exponential, Friction, FrictionLaw};
use crate::robot::{JointModel, Model, two_digits};
use crate::toml_input::{written_key, written_number, written_text};
use crate::units::JointKind;

/// Number of speeds of a joint.
const SPEEDS: f64 = 10.0;

/// [s] Between two readings in the rehearsal.
const CONTROL_PERIOD: f64 = 0.001;

/// [1] Largest part of a joint's speed limit.
const SPEED_SHARE: f64 = 0.3;

/// [rad/s or m/s] Slowest top speed: a joint that has no room for it rests.
const SLOWEST: f64 = 1e-4;

/// [1] Factor from a top speed that needs too much room to the next one that is tried.
const SLOWER: f64 = 0.8;

/// [s] Least time at each speed.
const STEADY: f64 = 1.0;

/// [1/s] Acceleration per top speed: it is reached in a third of a second.
const ACCELERATION: f64 = 3.0;

/// [1/s] Deceleration of the slow steps per top speed: gentler than a link's own friction would brake it.
const GENTLE: f64 = 0.25;

/// [1] Part of the speeds that brake gently.
const GENTLE_UP_TO: f64 = 0.3;

/// [1] Distance at each speed before it counts as steady, per distance travelled in a second at the slowest speed.
const SETTLING: f64 = 1.0;

/// [counts] Distance by which each pair of steps ends beyond its start, so that reversals are at different phases of an encoder count.
const ADVANCE: f64 = 2.6;

/// [1] Effort that is planned for, per effort of links and rotors alone.
const EFFORT_MARGIN: f64 = 1.3;

/// [s] Interval of the table of references, and of the check of efforts.
const INTERVAL: f64 = 0.01;

/// [1] Parts of the joints' rooms that are tried one after the other until links keep apart.
const ROOMS: [f64; 3] = [1.0, 0.4, 0.15];

/// [rad/s² or m/s²] Deceleration by which the rehearsal's friction alone would stop a joint: a placeholder.
const FRICTION: f64 = 1.0;

/// [1] Most of that friction as a part of the joint's effort limit.
const FRICTION_SHARE: f64 = 0.05;

/// A first experiment as files.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstExperiment {
    /// The scenario file.
    pub scenario: String,
    /// The references of all joints, as CSV.
    pub references: String,
    /// [s] Its length.
    pub duration: f64,
}

/// Plans the first experiment of a model. `model_file` is the path of the model file from the scenario's folder.
///
/// # Errors
/// Every plan that was tried leaves the limits of a joint or lets links collide; the error gives the fault of the last one.
pub fn first_experiment(model: &Model, model_file: &str) -> Result<FirstExperiment> {
    let reaches = reaches(model);
    let mut refused = None;
    for start in starts(&reaches) {
        for part in ROOMS {
            let scenario = text(model, &reaches, &start, part, model_file);
            let plan = Scenario::of_model(&scenario, Path::new("first_experiment.toml"), model)?;
            match plan.check_motion().and_then(|()| check_effort(model, &plan.sessions[0])) {
                Ok(()) => {
                    let (references, duration) = (references(model, &plan.sessions[0]), plan.sessions[0].duration);
                    return Ok(FirstExperiment { scenario, references, duration });
                }
                Err(error) => refused = Some(error),
            }
        }
    }
    let none = || Error::input(&model.urdf, Place::File, "", "", "joints that have room to move");
    Err(refused.unwrap_or_else(none))
}

/// [rad/s or m/s] Top speed of a staircase with room and without limits.
fn top_speed(kind: JointKind) -> f64 {
    match kind {
        JointKind::Revolute => 10.0_f64.to_radians(),
        JointKind::Prismatic => 0.05,
    }
}

/// A staircase of one joint, SI.
struct Stairs {
    last: f64,
    settling: f64,
    direction: f64,
}

/// The staircase that fits a joint's room, begun at a position and towards the farther end.
fn stairs(model: &Model, reach: &Reach, index: usize, start: f64, part: f64) -> Stairs {
    let top = top_speed(model.joints[index].kind);
    let limit = model.robot.bodies[index].joint.limits.velocity;
    let (up, down) = (reach.middle + reach.half - start, start - (reach.middle - reach.half));
    let room = part * up.max(down);
    // The longest step: a second and the settling way at the top speed, and both ramps.
    let way = |last: f64| last * (STEADY + SETTLING / SPEEDS + last / (ACCELERATION * last).min(reach.acceleration));
    let mut last = two_digits(top.min(SPEED_SHARE * limit));
    while way(last) > room && last >= SLOWEST {
        last = two_digits(SLOWER * last);
    }
    Stairs { last, settling: SETTLING * last / SPEEDS, direction: if up < down { -1.0 } else { 1.0 } }
}

/// The scenario file.
fn text(model: &Model, reaches: &[Reach], start: &[f64], part: f64, model_file: &str) -> String {
    let mut text = format!(
        "# A first experiment, written by `lostmotion new`: one joint after the other at constant speeds, the others at rest.\n\
         # `lostmotion run` rehearses it; first_experiment.csv has its references for the machine's own controller.\n\
         schema = \"lostmotion/scenario/1\"\nname = \"first_experiment\"\n\
         question = \"Which friction and which backlash have the joints of this machine?\"\nrobot = {}\nsensors = \"model\"\n\
         control_period = {CONTROL_PERIOD}              # [s]\nprocedure = \"identify\"\n",
        written_text(model_file)
    );
    if !model.robot.unread_shapes.is_empty() {
        text += "unread_shapes = \"ignored\"           # collisions of links whose meshes were not read are not checked: see `lostmotion check`\n";
    }
    write_friction(&mut text, model, reaches);
    text += "\n[[session]]\nname = \"staircase\"\nkind = \"staircase\"\nrest = 1.0                          # [s]\n";
    for (joint, position) in model.joints.iter().zip(start) {
        let _ = writeln!(text, "start.{} = {}", written_key(&joint.name), written_number(*position));
    }
    for (index, reach) in reaches.iter().enumerate() {
        write_stairs(&mut text, model, reach, index, &stairs(model, reach, index, start[index], part));
    }
    write_controller(&mut text, model, reaches);
    text
}

/// Friction of the rehearsal, as assignments to the model. Their keys are split at dots: joints with special characters in their names
/// get no friction.
fn write_friction(text: &mut String, model: &Model, reaches: &[Reach]) {
    let plain = |joint: &JointModel| {
        joint.friction.is_none() && joint.name.chars().all(|c| c.is_alphanumeric() || "_-".contains(c))
    };
    *text += "model = [                           # friction for the rehearsal only\n";
    for (index, joint) in model.joints.iter().enumerate().filter(|(_, joint)| plain(joint)) {
        let Exponential { coulomb, breakaway, stribeck_velocity, viscous } = rehearsed(model, &reaches[index], index);
        let values = [
            ("coulomb", coulomb),
            ("breakaway", breakaway),
            ("stribeck_velocity", stribeck_velocity),
            ("viscous", viscous),
        ];
        for (key, value) in values {
            let _ = writeln!(
                text,
                "  \"joints.{}.friction.{key} = {}\",  # placeholder",
                joint.name,
                written_number(value)
            );
        }
    }
    *text += "]\n";
}

/// The staircase of a joint.
fn write_stairs(text: &mut String, model: &Model, reach: &Reach, index: usize, stairs: &Stairs) {
    let joint = &model.joints[index];
    let Stairs { last, settling, direction } = *stairs;
    if last < SLOWEST {
        let _ = writeln!(text, "# {} has no room to move", written_text(&joint.name));
        return;
    }
    let unit = joint.kind.position_unit();
    let acceleration = (ACCELERATION * last).min(reach.acceleration);
    let _ = write!(
        text,
        "[session.joints.{}]\nfirst = {first}  # speeds [{unit}/s]\nlast = {last}\nincrement = {first}\n\
         acceleration = {acceleration}  # [{unit}/s²]\ndeceleration = {acceleration}\n\
         gentle_up_to = {}  # [{unit}/s] these steps brake gently: at their reversals the gap is measured\ngentle_deceleration = {}\n\
         steady_time = {STEADY:?}  # [s] every step\nsettling_way = {settling}  # [{unit}] additional distance\nadvance = {}\ndirection = {}\n",
        written_key(&joint.name),
        GENTLE_UP_TO * last,
        (GENTLE * last).min(acceleration),
        ADVANCE * joint.encoder_step(),
        written_text(if direction < 0.0 { "negative" } else { "positive" }),
        first = last / SPEEDS,
    );
}

/// The controller of the rehearsal.
fn write_controller(text: &mut String, model: &Model, reaches: &[Reach]) {
    *text += "\n[controller]\nlaw = \"independent\"\nvelocity = \"sensor\"\n";
    let rehearsal = with_friction(model, reaches);
    for (index, joint) in model.joints.iter().enumerate() {
        let gains = gains(&rehearsal, reaches, index, CONTROL_PERIOD);
        let _ = writeln!(
            text,
            "[controller.joints.{}]\nlambda = {:?}\nswitching = {:?}\nboundary = {:?}",
            written_key(&joint.name),
            gains.lambda,
            two_digits(gains.switching),
            two_digits(gains.boundary)
        );
    }
}

/// The model with the friction of the rehearsal.
fn with_friction(model: &Model, reaches: &[Reach]) -> Model {
    let mut model = model.clone();
    for (index, reach) in reaches.iter().enumerate() {
        let law = rehearsed(&model, reach, index);
        let own = Friction { law: FrictionLaw::Exponential([law; 2]), link_share: 0.0 };
        model.joints[index].friction.get_or_insert(own);
    }
    model
}

/// Friction of the rehearsal, where the model has none.
fn rehearsed(model: &Model, reach: &Reach, index: usize) -> Exponential {
    let (joint, limits) = (&model.joints[index], model.robot.bodies[index].joint.limits);
    let coulomb = two_digits((FRICTION * reach.inertia).min(FRICTION_SHARE * limits.effort));
    let top = top_speed(joint.kind);
    // A third more at rest, which falls off over a tenth of the top speed; at three times the top speed the viscous part is as large as
    // Coulomb friction.
    Exponential {
        coulomb,
        breakaway: two_digits(1.3 * coulomb),
        stribeck_velocity: two_digits(0.1 * top),
        viscous: two_digits(coulomb / (3.0 * top)),
    }
}

/// Refuses a motion for which a joint needs more than its effort limit.
fn check_effort(model: &Model, session: &Session) -> Result<()> {
    let n = model.joints.len();
    let mut dynamics = Dynamics::new(&model.robot);
    let (mut targets, mut torques) = (vec![Target::default(); n], vec![0.0; n]);
    for tick in 0..=(session.duration / INTERVAL) as usize {
        session.profile.sample(tick as f64 * INTERVAL, &mut targets);
        let each = |of: fn(&Target) -> f64| targets.iter().map(of).collect::<Vec<f64>>();
        let (q, v, a) = (each(|t| t.position), each(|t| t.velocity), each(|t| t.acceleration));
        dynamics.inverse(&q, &v, &a, &mut torques);
        for (i, body) in model.robot.bodies.iter().enumerate() {
            let torque = (torques[i] + model.joints[i].reflected_inertia() * a[i]).abs();
            let (limit, unit) = (body.joint.limits.effort, body.joint.kind.effort_unit());
            if EFFORT_MARGIN * torque > limit {
                let key = format!("joint {}: limit effort", body.joint.name);
                let expected = format!(
                    "at least {:.3} {unit}: links and rotors alone need {torque:.3} {unit} in the first experiment",
                    EFFORT_MARGIN * torque
                );
                return Err(Error::input(&model.urdf, Place::File, key, limit, expected));
            }
        }
    }
    Ok(())
}

/// Positions and velocities of the reference of all joints, every hundredth of a second.
fn references(model: &Model, session: &Session) -> String {
    let mut targets = vec![Target::default(); model.joints.len()];
    let mut text = String::from("time");
    for joint in &model.joints {
        let name = quoted(&joint.name);
        let _ = write!(text, ",{}", name(".reference_position"));
        let _ = write!(text, ",{}", name(".reference_velocity"));
    }
    for tick in 0..=(session.duration / INTERVAL).ceil() as usize {
        let time = tick as f64 * INTERVAL;
        session.profile.sample(time, &mut targets);
        let _ = write!(text, "\n{time:.2}");
        for Target { position, velocity, .. } in &targets {
            let _ = write!(text, ",{position:.9},{velocity:.9}");
        }
    }
    text.push('\n');
    text
}

/// A column's name of a joint, in quotes where CSV needs them.
fn quoted(joint: &str) -> impl Fn(&str) -> String {
    move |column| {
        let name = format!("{joint}{column}");
        if name.contains([',', '"', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name }
    }
}

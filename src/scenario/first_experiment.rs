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

use super::Scenario;
use super::reach::{Reach, reaches, starts};
use super::rehearsal::{
    CONTROL_PERIOD, SPEED_SHARE, check_effort, references, top_speed, write_assumed, write_controller,
};
use crate::error::{Error, Place, Result};
use crate::robot::{First, Model, two_digits};
use crate::toml_input::{written_key, written_number, written_text};

/// Number of speeds of a joint.
const SPEEDS: f64 = 10.0;

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

/// [1] Parts of the joints' rooms that are tried one after the other until links keep apart.
const ROOMS: [f64; 3] = [1.0, 0.4, 0.15];

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

/// Plans the first experiment of a first model. `model_file` is the path of the model file from the scenario's folder.
///
/// # Errors
/// Every plan that was tried leaves the limits of a joint or lets links collide; the error gives the fault of the last one.
pub fn first_experiment(first: &First, model_file: &str) -> Result<FirstExperiment> {
    let model = &first.model;
    let reaches = reaches(model);
    let mut refused = None;
    for start in starts(&reaches) {
        for part in ROOMS {
            let scenario = text(first, &reaches, &start, part, model_file);
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
fn text(
    First { model, placeholders }: &First,
    reaches: &[Reach],
    start: &[f64],
    part: f64,
    model_file: &str,
) -> String {
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
    write_assumed(&mut text, model, reaches, placeholders);
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

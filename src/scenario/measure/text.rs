//! The scenario file of a measurement: one recording of sweeps per joint, and recordings of strokes.

use std::fmt::Write as _;

use super::course::{Course, REST, Setup};
use super::posture::Posture;
use super::regulation;
use super::strokes::recordings;
use crate::control::SpeedStep;
use crate::files::is_fit_name;
use crate::robot::{Model, Placeholders};
use crate::scenario::reach::Reach;
use crate::scenario::rehearsal::{CONTROL_PERIOD, write_assumed, write_controller};
use crate::toml_input::{written_key, written_number, written_text};

/// A joint, what is done with it and where.
type Part = (usize, Course, Posture);

/// The file; its place is beside `model.toml`.
pub fn scenario(model: &Model, reaches: &[Reach], setups: &[Setup], parts: &[Part], about: &str) -> String {
    let mut text = format!(
        "# Written by `lostmotion design`: speeds and dwells that measure {about} best within the budget.\n\
         schema = \"lostmotion/scenario/1\"\nname = \"measurement\"\nquestion = {}\nrobot = \"model.toml\"\nsensors = \"model\"\n\
         control_period = {CONTROL_PERIOD}\nprocedure = \"identify\"\n",
        written_text(&format!("Which {about} have the joints of this machine?"))
    );
    if !model.robot.unread_shapes.is_empty() {
        text += "unread_shapes = \"ignored\"           # collisions of links whose meshes were not read are not checked: see `lostmotion check`\n";
    }
    let known = model.joints.iter().all(|joint| joint.friction.is_some());
    if !known {
        write_assumed(&mut text, model, reaches, &Placeholders::default());
    }
    for (index, course, posture) in parts {
        write_joint(&mut text, model, &setups[*index], *index, course, posture);
    }
    if known {
        regulation::write(&mut text, model, setups.iter().map(|setup| &setup.regulation));
    } else {
        write_controller(&mut text, model, reaches);
    }
    text
}

/// The recordings of a joint.
fn write_joint(text: &mut String, model: &Model, setup: &Setup, index: usize, course: &Course, posture: &Posture) {
    let joint = &model.joints[index].name;
    let named = |what: &str| {
        let own = format!("{joint}_{what}");
        if is_fit_name(&own) { own } else { format!("joint_{}_{what}", index + 1) }
    };
    let (sweep, acceleration) = (&course.sweep, setup.bounds.acceleration);
    let step = |sign: f64| {
        let one = move |(window, duration): (&super::information::SteadyWindow, &f64)| SpeedStep {
            velocity: sign * window.speed,
            duration: *duration,
            deceleration: acceleration,
        };
        sweep.windows.iter().zip(&sweep.durations).map(one)
    };
    let steps: Vec<SpeedStep> = (0..sweep.repeats).flat_map(|_| step(1.0).chain(step(-1.0))).collect();
    write_session(text, model, &named("friction"), index, &posture.positions, acceleration, &steps);
    if course.reversals == 0 {
        return;
    }
    let mut start = posture.positions.clone();
    start[index] = posture.stroke;
    for (k, reversals) in recordings(course.reversals).into_iter().enumerate() {
        let steps = setup.strokes.steps(reversals, 1.0);
        write_session(
            text,
            model,
            &named(&format!("gap_{}", k + 1)),
            index,
            &start,
            setup.strokes.acceleration,
            &steps,
        );
        start[index] += setup.strokes.advance * (reversals / 2 + 1) as f64;
    }
}

/// A recording.
fn write_session(
    text: &mut String,
    model: &Model,
    name: &str,
    index: usize,
    start: &[f64],
    acceleration: f64,
    steps: &[SpeedStep],
) {
    let _ = writeln!(text, "\n[[session]]\nname = {}\nkind = \"speeds\"\nrest = {REST:?}", written_text(name));
    for (joint, position) in model.joints.iter().zip(start) {
        let _ = writeln!(text, "start.{} = {}", written_key(&joint.name), written_number(*position));
    }
    let list = |of: fn(&SpeedStep) -> f64| {
        steps.iter().map(|step| written_number(of(step))).collect::<Vec<String>>().join(", ")
    };
    let _ = writeln!(
        text,
        "[session.joints.{}]\nvelocities = [{}]\ndurations = [{}]  # [s]\ndecelerations = [{}]\nacceleration = {}",
        written_key(&model.joints[index].name),
        list(|step| step.velocity),
        list(|step| step.duration),
        list(|step| step.deceleration),
        written_number(acceleration)
    );
}

//! Whether a judgement by simulation applies to a model and its recordings.

use crate::diagnose::result::{Diagnosis, Verdict};
use crate::drive::Sensing;
use crate::robot::{JointModel, Masses, Model};
use crate::timeseries::{Channel, TimeSeries};

/// More joints were not measured, and the cost of a set grows faster than with their square.
const MOST_JOINTS: usize = 3;

/// Why the stage does not apply, in one sentence; `None` where it does.
pub fn refusal(diagnosis: &Diagnosis, sessions: &[&TimeSeries]) -> Option<String> {
    let model = &diagnosis.baseline_model;
    of_diagnosis(diagnosis).or_else(|| of_model(model)).or_else(|| {
        let joints = || model.joints.iter();
        sessions.iter().find_map(|session| joints().find_map(|joint| of_joint(joint, session)))
    })
}

fn of_diagnosis(diagnosis: &Diagnosis) -> Option<String> {
    let judged = |joint: &JointModel| diagnosis.baseline.contains_key(&joint.name);
    if diagnosis.verdict == Verdict::MistakeSuspected {
        return Some("A mistake in the data or in the model is suspected.".to_owned());
    }
    let left_out = diagnosis.baseline_model.joints.iter().find(|joint| !judged(joint));
    left_out.map(|joint| format!("{} was not judged by its torque, and a simulation needs all joints.", joint.name))
}

fn of_model(model: &Model) -> Option<String> {
    if model.joints.len() > MOST_JOINTS {
        return Some(format!("It is made for up to {MOST_JOINTS} joints, the model has {}.", model.joints.len()));
    }
    if model.masses == Masses::Estimated {
        return Some("The model's masses are unknown, so it cannot be simulated.".to_owned());
    }
    if model.robot.coupling.is_some() {
        return Some("Motors that move several joints are not judged by it.".to_owned());
    }
    let without = model.joints.iter().find(|joint| joint.encoder.is_none())?;
    Some(format!(
        "Neither the model file nor the recordings show encoder counts of {}, by which it scores.",
        without.name
    ))
}

fn of_joint(joint: &JointModel, session: &TimeSeries) -> Option<String> {
    let signed = joint.current_sensor.is_none_or(|sensor| sensor.sensing == Sensing::Signed);
    let has = |channel: Channel| session.joint(&joint.name).is_some_and(|one| one.get(channel).is_some());
    let driven = has(Channel::Torque) || (has(Channel::Current) && signed);
    let missing = !has(Channel::Position) || !driven;
    missing
        .then(|| format!("Recording {} has neither torque nor current with its sign of {}.", session.name, joint.name))
}

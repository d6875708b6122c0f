//! Completes a model with values that the model file omits and the recordings show.

use super::Session;
use super::encoder_step::encoder_step;
use crate::drive::Encoder;
use crate::error::{Error, Place, Result};
use crate::robot::{JointModel, Model};
use crate::timeseries::{Channel, JointSeries};

/// The model as it is used with these recordings: an encoder that the model file does not give has the step that the
/// positions show, or is exact where they show none.
///
/// # Errors
/// A joint without a motor was recorded with a current and no torque. The error gives the line in the model file, if there is one.
pub fn meet(model: &Model, sessions: &[&Session]) -> Result<Model> {
    let mut met = model.clone();
    for joint in &mut met.joints {
        let recorded: Vec<&JointSeries> =
            sessions.iter().filter_map(|session| session.series.joint(&joint.name)).collect();
        if joint.motor.is_none() && recorded.iter().any(|series| has_current_alone(series)) {
            let key = format!("joints.{}.motor.torque_constant", joint.name);
            let expected = "a number > 0 [N·m/A] (missing), since the recording has a current and no torque";
            return Err(model.places.locate(Error::input(&model.source, Place::File, key, "", expected)));
        }
        if joint.encoder.is_none() {
            let positions: Vec<&[f64]> = recorded.iter().filter_map(|series| series.get(Channel::Position)).collect();
            joint.encoder = encoder_step(&positions).and_then(|step| encoder(joint, step));
        }
    }
    Ok(met)
}

fn has_current_alone(series: &JointSeries) -> bool {
    let has = |channel| series.get(channel).is_some();
    (has(Channel::Current) || has(Channel::CommandCurrent)) && !has(Channel::Torque)
}

/// The encoder on the motor shaft with this step at the joint; `None` if a step is more than a turn, which a model file
/// may not state.
fn encoder(joint: &JointModel, step: f64) -> Option<Encoder> {
    let counts_per_turn = std::f64::consts::TAU / (step * joint.gear_ratio);
    (counts_per_turn >= 1.0).then_some(Encoder { counts_per_turn })
}

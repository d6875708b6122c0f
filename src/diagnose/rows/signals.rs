//! What of a session's channels rows are made of: position and torque of each joint.

use crate::drive::Sensing;
use crate::effects::LeftOut;
use crate::error::{Error, Place, Result};
use crate::robot::{Model, TorqueAt};
use crate::timeseries::{Channel, JointSeries, TimeSeries};

/// Torque [N·m or N, joint side] of a joint, and whether it comes from a current. It is the motor's torque, or the link's where the model
/// says so.
pub fn motor_torque(
    model: &Model,
    index: usize,
    series: &JointSeries,
    reference: Option<&[f64]>,
) -> Option<(Vec<f64>, bool)> {
    let joint = &model.joints[index];
    if joint.torque_at == TorqueAt::Link {
        return Some((series.get(Channel::LinkTorque)?.to_vec(), false));
    }
    if let Some(torque) = series.get(Channel::Torque) {
        return Some((torque.to_vec(), false));
    }
    let current = series.get(Channel::Current)?;
    let absolute = joint.current_sensor.is_some_and(|sensor| sensor.sensing == Sensing::Absolute);
    let scale = joint.torque_per_ampere();
    let torque = match (absolute, reference) {
        (true, Some(direction)) => current.iter().zip(direction).map(|(i, v)| scale * i * v.signum()).collect(),
        _ => current.iter().map(|i| scale * i).collect(),
    };
    Some((torque, true))
}

/// A session's signals, one entry per joint of the model.
pub struct Signals<'a> {
    /// [rad or m]
    pub position: Vec<&'a [f64]>,
    /// [N·m or N] Zeros for a joint without current and torque.
    pub torque: Vec<Vec<f64>>,
    /// Whether the torque comes from a current.
    pub has_current: Vec<bool>,
    /// Why a joint counts in no fit.
    pub left_out: Vec<Option<LeftOut>>,
}

impl<'a> Signals<'a> {
    /// # Errors
    /// A joint has no position, or none has a current or a torque.
    pub fn of_session(model: &Model, session: &'a TimeSeries) -> Result<Self> {
        let missing = |joint: &str, what: &str| {
            let expected = format!("{what} of the joints of the model");
            Error::input(session.name.as_ref(), Place::File, joint, "", expected)
        };
        let mut signals =
            Self { position: Vec::new(), torque: Vec::new(), has_current: Vec::new(), left_out: Vec::new() };
        for (index, joint) in model.joints.iter().enumerate() {
            let series = session.joint(&joint.name).ok_or_else(|| missing(&joint.name, "channels"))?;
            let position = series.get(Channel::Position).ok_or_else(|| missing(&joint.name, "position"))?;
            let velocity = series.get(Channel::Velocity).or_else(|| series.get(Channel::ReferenceVelocity));
            let recorded = motor_torque(model, index, series, velocity);
            signals.left_out.push(recorded.is_none().then_some(LeftOut::NotRecorded));
            let (torque, has_current) = recorded.unwrap_or_else(|| (vec![0.0; position.len()], false));
            signals.position.push(position);
            signals.torque.push(torque);
            signals.has_current.push(has_current);
        }
        match model.joints.first().filter(|_| signals.left_out.iter().all(Option::is_some)) {
            Some(joint) => Err(missing(&joint.name, "current or torque")),
            None => Ok(signals),
        }
    }
}

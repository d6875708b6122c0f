//! Where the torque of each joint was measured, and the model as such a measurement sees it.
//!
//! ```text
//!   at the motor       τ = J q̈ + F_r(q̇) + τ_link        J rotor, F_r friction of the rotor side
//!   behind the gear    τ = τ_link = M q̈ + h + F_l(q̇)    F_l friction of the link side
//! ```
//! A joint torque sensor sees neither rotor nor motor nor the friction before it. A joint counts as measured there if no session has its
//! current or its motor torque, because these show the whole joint.

use std::borrow::Cow;

use crate::robot::{Model, TorqueAt};
use crate::timeseries::{Channel, TimeSeries};

/// The model as the torques of these sessions see it.
pub fn as_measured<'m>(model: &'m Model, sessions: &[&TimeSeries]) -> Cow<'m, Model> {
    let has = |name: &str, channel: Channel| {
        sessions.iter().any(|session| session.joint(name).is_some_and(|joint| joint.get(channel).is_some()))
    };
    let behind =
        |name: &str| has(name, Channel::LinkTorque) && !has(name, Channel::Current) && !has(name, Channel::Torque);
    let mut seen = Cow::Borrowed(model);
    for (index, joint) in model.joints.iter().enumerate().filter(|(_, joint)| behind(&joint.name)) {
        seen.to_mut().joints[index] = joint.behind_gear();
    }
    seen
}

/// Adds to the joints of a result what such a measurement does not show, from the model that the diagnosis began with.
pub fn complete(result: &mut Model, nominal: &Model) {
    let joints = result.joints.iter_mut().zip(&nominal.joints);
    for (joint, nominal) in joints.filter(|(joint, _)| joint.torque_at == TorqueAt::Link) {
        joint.rotor_inertia = nominal.rotor_inertia;
        joint.motor = nominal.motor;
        joint.current_sensor = nominal.current_sensor;
        joint.friction = nominal.friction;
        joint.torque_at = nominal.torque_at;
    }
}

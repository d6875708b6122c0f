//! Reduces the true states of a replayed machine for display.

use std::collections::BTreeMap;

use crate::effects::JointState;
use crate::robot::Model;
use crate::timeseries::{Channel, Drawn, DrawnJoint, Envelope, TimeSeries, pose_step};

/// Signals that exist only in the simulation, reduced while it runs.
#[derive(Debug)]
pub(super) struct Drawing {
    joints: Vec<Joint>,
    /// Number of samples from one pose to the next.
    step: usize,
}

#[derive(Debug)]
struct Joint {
    name: String,
    seen: usize,
    gear_torque: Envelope,
    contact: Envelope,
    travel: Envelope,
    pose: Vec<f64>,
}

impl Drawing {
    /// A drawing of a session with this many samples.
    pub(super) fn new(model: &Model, samples: usize) -> Self {
        let joint = |joint: &crate::robot::JointModel| Joint {
            name: joint.name.clone(),
            seen: 0,
            gear_torque: Envelope::new(samples),
            contact: Envelope::new(samples),
            travel: Envelope::new(samples),
            pose: Vec::new(),
        };
        Self { joints: model.joints.iter().map(joint).collect(), step: pose_step(samples) }
    }

    /// Adds the next sample of a joint.
    pub(super) fn sample(&mut self, joint: usize, time: f64, state: &JointState, contact: f64) {
        let joint = &mut self.joints[joint];
        joint.gear_torque.push(time, state.gear_torque);
        joint.contact.push(time, contact);
        joint.travel.push(time, state.motor_position - state.link_position);
        if joint.seen.is_multiple_of(self.step) {
            joint.pose.push(state.link_position);
        }
        joint.seen += 1;
    }

    /// The reduced session, with the name and the times of the recorded one.
    pub(super) fn finish(self, recorded: &TimeSeries) -> Drawn {
        let joint = |mut joint: Joint| {
            for envelope in [&mut joint.gear_torque, &mut joint.contact, &mut joint.travel] {
                envelope.finish();
            }
            let channels =
                BTreeMap::from([(Channel::GearTorque, joint.gear_torque), (Channel::Contact, joint.contact)]);
            DrawnJoint { name: joint.name, channels, travel: Some(joint.travel), pose: joint.pose }
        };
        Drawn {
            name: recorded.name.clone(),
            end: recorded.time.last().copied().unwrap_or(0.0),
            times: recorded.time.iter().step_by(self.step).copied().collect(),
            joints: self.joints.into_iter().map(joint).collect(),
        }
    }
}

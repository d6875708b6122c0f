//! Curves over time: the channels of a session, sorted into panels.

use super::Trace;
use crate::report::plot::Role;
use crate::timeseries::{Channel, Drawn, Envelope};

/// Channels that are drawn directly: panel, label, role.
const DRAWN: [(Channel, &str, &str, Role); 13] = [
    (Channel::ReferencePosition, "position", "reference", Role::Reference),
    (Channel::Position, "position", "motor", Role::Measured),
    (Channel::LinkPosition, "position", "link_encoder", Role::Link),
    (Channel::TrueLinkPosition, "position", "link", Role::Link),
    (Channel::Velocity, "velocity", "measured", Role::Measured),
    (Channel::TrueLinkVelocity, "velocity", "link", Role::Link),
    (Channel::TrueMotorVelocity, "velocity", "motor", Role::Fit),
    (Channel::ReferenceVelocity, "velocity", "reference", Role::Reference),
    (Channel::Current, "current", "measured", Role::Measured),
    (Channel::CommandCurrent, "current", "command", Role::Reference),
    (Channel::Torque, "torque", "motor", Role::Measured),
    (Channel::GearTorque, "torque", "gear", Role::Link),
    (Channel::Contact, "contact", "flank", Role::Fit),
];

/// The traces of a session: every channel that is drawn, and the position in the gap if both sides of it are known.
pub fn of_session(session: &Drawn) -> Vec<Trace> {
    let mut traces = Vec::new();
    for joint in &session.joints {
        let mut add = |panel, label, role, envelope: &Envelope| {
            let Envelope { time, values, .. } = envelope.clone();
            traces.push(Trace { joint: joint.name.clone(), panel, label, role, time, values });
        };
        for (channel, panel, label, role) in DRAWN {
            if let Some(envelope) = joint.channels.get(&channel) {
                add(panel, label, role, envelope);
            }
        }
        if let Some(travel) = &joint.travel {
            add("gap", "motor_minus_link", Role::Link, travel);
        }
    }
    traces
}

//! What is drawn over time: the channels of a session, sorted into panels, and thinned.

use super::Trace;
use crate::report::plot::Role;
use crate::timeseries::{Channel, TimeSeries};

/// Channels that are drawn as they are: panel, label, role.
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

/// Stretches of a trace, of which lowest and highest sample are kept.
const BUCKETS: usize = 2500;

/// The traces of a session: every channel that is drawn, and the travel in the gap where both sides of it are known.
pub fn of_session(session: &TimeSeries) -> Vec<Trace> {
    let mut traces = Vec::new();
    for joint in &session.joints {
        let mut add = |panel, label, role, values: &[f64]| {
            let (time, values) = thinned(&session.time, values);
            traces.push(Trace { joint: joint.name.clone(), panel, label, role, time, values });
        };
        for (channel, panel, label, role) in DRAWN {
            if let Some(values) = joint.get(channel) {
                add(panel, label, role, values);
            }
        }
        if let (Some(motor), Some(link)) = (joint.get(Channel::TrueMotorPosition), joint.get(Channel::TrueLinkPosition))
        {
            let travel: Vec<f64> = motor.iter().zip(link).map(|(motor, link)| motor - link).collect();
            add("gap", "motor_minus_link", Role::Link, &travel);
        }
    }
    traces
}

/// The samples that are kept: lowest and highest of each of [`BUCKETS`] equal stretches. What is thinned already stays as it is.
pub fn thinned(time: &[f64], values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let size = values.len().div_ceil(BUCKETS).max(1);
    if size <= 2 {
        return (time.to_vec(), values.to_vec());
    }
    let mut kept = Vec::with_capacity(2 * BUCKETS);
    for (bucket, chunk) in values.chunks(size).enumerate() {
        let by_value = |a: &(usize, &f64), b: &(usize, &f64)| a.1.total_cmp(b.1);
        let low = chunk.iter().enumerate().min_by(by_value).map_or(0, |(index, _)| index);
        let high = chunk.iter().enumerate().max_by(by_value).map_or(0, |(index, _)| index);
        kept.push(bucket * size + low.min(high));
        if low != high {
            kept.push(bucket * size + low.max(high));
        }
    }
    kept.into_iter().filter_map(|index| Some((*time.get(index)?, values[index]))).unzip()
}

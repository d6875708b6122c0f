//! The recorder: what the sensors say and what is true, a sample a control period.

use super::contact::{Contact, ContactRecorder};
use crate::control::Target;
use crate::effects::Reading;
use crate::plant::{Obstacle, Plant};
use crate::robot::Model;
use crate::timeseries::{Channel, JointSeries, TimeSeries};

/// Channels that a simulation alone can fill.
pub(super) const TRUTH: [Channel; 7] = [
    Channel::TrueMotorPosition,
    Channel::TrueMotorVelocity,
    Channel::TrueLinkPosition,
    Channel::TrueLinkVelocity,
    Channel::TrueCurrent,
    Channel::GearTorque,
    Channel::Contact,
];

/// Channels that the machine's own recording has.
const MEASURED: [Channel; 6] = [
    Channel::Position,
    Channel::Velocity,
    Channel::Current,
    Channel::ReferencePosition,
    Channel::ReferenceVelocity,
    Channel::CommandCurrent,
];

/// Collects the samples of a session.
#[derive(Debug, Clone)]
pub struct Recorder {
    time: Vec<f64>,
    contacts: ContactRecorder,
    /// One a joint, one vector a channel: those of `MEASURED`, then those of `TRUTH`.
    joints: Vec<[Vec<f64>; MEASURED.len() + TRUTH.len()]>,
    /// What the second encoders say, one a joint; empty where there is none.
    links: Vec<Vec<f64>>,
}

impl Recorder {
    /// Room for a number of samples of a machine with so many joints.
    pub fn new(joints: usize, samples: usize) -> Self {
        // Beyond that, room is made as it is needed: a number of samples that is a mistake allocates nothing.
        let samples = samples.min(1 << 24);
        let channels = || std::array::from_fn(|_| Vec::with_capacity(samples));
        let contacts = ContactRecorder::default();
        let links = vec![Vec::new(); joints];
        Self { time: Vec::with_capacity(samples), contacts, joints: (0..joints).map(|_| channels()).collect(), links }
    }

    /// Takes a sample: readings and states at one instant, and the command that is given then.
    pub fn sample(&mut self, plant: &Plant, readings: &[Reading], targets: &[Target], commands: &[f64]) {
        self.time.push(plant.time());
        self.contacts.sample(plant.touches());
        for (i, channels) in self.joints.iter_mut().enumerate() {
            let (reading, target, state) = (&readings[i], &targets[i], &plant.states()[i]);
            let values = [
                reading.position,
                reading.velocity,
                reading.current,
                target.position,
                target.velocity,
                commands[i],
                state.motor_position,
                state.motor_velocity,
                state.link_position,
                state.link_velocity,
                state.current,
                state.gear_torque,
                f64::from(plant.contact(i)),
            ];
            for (channel, value) in channels.iter_mut().zip(values) {
                channel.push(value);
            }
            self.links[i].extend(reading.link_position);
        }
    }

    /// What was touched so far.
    pub fn contacts(&self, model: &Model, obstacles: &[Obstacle]) -> Vec<Contact> {
        self.contacts.clone().finish(model, obstacles)
    }

    /// The session's time series under its name.
    pub fn finish(self, name: &str, model: &Model) -> TimeSeries {
        let series = |(channels, joint): ([Vec<f64>; MEASURED.len() + TRUTH.len()], &crate::robot::JointModel)| {
            let names = MEASURED.into_iter().chain(TRUTH);
            JointSeries { name: joint.name.clone(), channels: names.zip(channels).collect() }
        };
        let mut joints: Vec<JointSeries> = self.joints.into_iter().zip(&model.joints).map(series).collect();
        for (joint, link) in joints.iter_mut().zip(self.links).filter(|(_, link)| !link.is_empty()) {
            joint.channels.insert(Channel::LinkPosition, link);
        }
        TimeSeries { name: name.to_owned(), time: self.time, joints }
    }
}

//! The recorder: sensor readings and true states, one sample per control period.

use std::collections::BTreeMap;

use super::contact::{Contact, ContactRecorder};
use crate::control::Target;
use crate::effects::Reading;
use crate::plant::{Obstacle, Plant};
use crate::robot::Model;
use crate::timeseries::{Channel, Drawn, DrawnJoint, Envelope, JointSeries, Samples, TimeSeries, pose_step};

/// Channels that exist only in a simulation.
pub(super) const TRUTH: [Channel; 7] = [
    Channel::TrueMotorPosition,
    Channel::TrueMotorVelocity,
    Channel::TrueLinkPosition,
    Channel::TrueLinkVelocity,
    Channel::TrueCurrent,
    Channel::GearTorque,
    Channel::Contact,
];

/// Channels of the machine's own recording.
const MEASURED: [Channel; 6] = [
    Channel::Position,
    Channel::Velocity,
    Channel::Current,
    Channel::ReferencePosition,
    Channel::ReferenceVelocity,
    Channel::CommandCurrent,
];

/// Signals of a session that are kept sample by sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    /// Sensor readings and the truth.
    Everything,
    /// Sensor readings.
    Measured,
    /// None: only the reduced copy for display is kept.
    Nothing,
}

impl Keep {
    /// Number of channels that are kept, of those of `MEASURED` followed by those of `TRUTH`.
    const fn channels(self) -> usize {
        match self {
            Self::Everything => MEASURED.len() + TRUTH.len(),
            Self::Measured => MEASURED.len(),
            Self::Nothing => 0,
        }
    }
}

/// Number of channels of `MEASURED` and `TRUTH` together.
const ALL: usize = MEASURED.len() + TRUTH.len();
/// Indices of the true motor position and link position, where `MEASURED` is followed by `TRUTH`.
const TRUE_MOTOR: usize = MEASURED.len();
const TRUE_LINK: usize = MEASURED.len() + 2;

/// Collects the samples of a session.
#[derive(Debug, Clone)]
pub struct Recorder {
    keep: Keep,
    time: Vec<f64>,
    contacts: ContactRecorder,
    /// One entry per joint, one vector per kept channel: those of `MEASURED`, then those of `TRUTH`.
    joints: Vec<Vec<Vec<f64>>>,
    /// Readings of the second encoders, one per joint; empty if there is none.
    links: Vec<Vec<f64>>,
    /// The session, reduced for display.
    drawing: Drawing,
}

/// The signals of a session, reduced for display.
#[derive(Debug, Clone)]
struct Drawing {
    /// Number of samples of the session, and from one pose to the next.
    samples: usize,
    step: usize,
    times: Vec<f64>,
    joints: Vec<DrawnSignals>,
}

#[derive(Debug, Clone)]
struct DrawnSignals {
    channels: [Envelope; ALL],
    travel: Envelope,
    /// The second encoder's signal, if there is one.
    link: Option<Envelope>,
    pose: Vec<f64>,
}

impl Drawing {
    fn new(joints: usize, samples: usize) -> Self {
        let signals = || DrawnSignals {
            channels: std::array::from_fn(|_| Envelope::new(samples)),
            travel: Envelope::new(samples),
            link: None,
            pose: Vec::new(),
        };
        let joints = (0..joints).map(|_| signals()).collect();
        Self { samples, step: pose_step(samples), times: Vec::new(), joints }
    }

    /// Adds the sample with this `number` of a joint; `link` is the reading of a second encoder.
    fn push(&mut self, joint: usize, number: usize, time: f64, values: &[f64; ALL], link: Option<f64>) {
        let (samples, signals) = (self.samples, &mut self.joints[joint]);
        signals.channels.iter_mut().zip(values).for_each(|(envelope, value)| envelope.push(time, *value));
        signals.travel.push(time, values[TRUE_MOTOR] - values[TRUE_LINK]);
        if let Some(link) = link {
            signals.link.get_or_insert_with(|| Envelope::new(samples)).push(time, link);
        }
        if number.is_multiple_of(self.step) {
            signals.pose.push(values[TRUE_LINK]);
        }
    }

    fn finish(self, name: &str, end: f64, model: &Model) -> Drawn {
        let joint = |(signals, joint): (DrawnSignals, &crate::robot::JointModel)| {
            let names = MEASURED.into_iter().chain(TRUTH).zip(signals.channels);
            let link = signals.link.map(|link| (Channel::LinkPosition, link));
            let mut channels: BTreeMap<Channel, Envelope> = names.chain(link).collect();
            channels.values_mut().for_each(Envelope::finish);
            let mut travel = signals.travel;
            travel.finish();
            DrawnJoint { name: joint.name.clone(), channels, travel: Some(travel), pose: signals.pose }
        };
        let joints = self.joints.into_iter().zip(&model.joints).map(joint).collect();
        Drawn { name: name.to_owned(), end, times: self.times, joints }
    }
}

impl Recorder {
    /// Reserves memory for a number of samples of a machine with this many joints.
    pub fn new(keep: Keep, joints: usize, samples: usize) -> Self {
        // Beyond this, memory is reserved as needed: a wrong, huge number of samples allocates nothing.
        let samples = samples.min(1 << 24);
        let channels = || (0..keep.channels()).map(|_| Vec::with_capacity(samples)).collect();
        Self {
            keep,
            time: Vec::with_capacity(samples),
            contacts: ContactRecorder::default(),
            joints: (0..joints).map(|_| channels()).collect(),
            links: vec![Vec::new(); joints],
            drawing: Drawing::new(joints, samples),
        }
    }

    /// Adds a sample: readings and states at one time, and the command that is given then.
    pub fn sample(&mut self, plant: &Plant, readings: &[Reading], targets: &[Target], commands: &[f64]) {
        let (number, time) = (self.time.len(), plant.time());
        self.time.push(time);
        if number.is_multiple_of(self.drawing.step) {
            self.drawing.times.push(time);
        }
        self.contacts.sample(plant.touches());
        for (i, channels) in self.joints.iter_mut().enumerate() {
            let (reading, target, state) = (&readings[i], &targets[i], &plant.states()[i]);
            let values: [f64; ALL] = [
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
            channels.iter_mut().zip(values).for_each(|(channel, value)| channel.push(value));
            if self.keep != Keep::Nothing {
                self.links[i].extend(reading.link_position);
            }
            self.drawing.push(i, number, time, &values, reading.link_position);
        }
    }

    /// The contacts.
    pub fn take_contacts(&mut self, model: &Model, obstacles: &[Obstacle]) -> Vec<Contact> {
        std::mem::take(&mut self.contacts).finish(model, obstacles)
    }

    /// The session's time series under its name, and its reduced copy.
    pub fn finish(self, name: &str, model: &Model) -> (TimeSeries, Drawn) {
        let series = |(channels, joint): (Vec<Vec<f64>>, &crate::robot::JointModel)| {
            let names = MEASURED.into_iter().chain(TRUTH);
            let channels = names.zip(channels.into_iter().map(Samples::from)).collect();
            JointSeries { name: joint.name.clone(), channels }
        };
        let mut joints: Vec<JointSeries> = self.joints.into_iter().zip(&model.joints).map(series).collect();
        for (joint, link) in joints.iter_mut().zip(self.links).filter(|(_, link)| !link.is_empty()) {
            joint.channels.insert(Channel::LinkPosition, link.into());
        }
        let drawn = self.drawing.finish(name, self.time.last().copied().unwrap_or(0.0), model);
        (TimeSeries { name: name.to_owned(), time: self.time, joints }, drawn)
    }
}

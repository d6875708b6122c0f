//! The sensors of a joint, and what effects do to their readings.

use super::joint::Phase;
use crate::drive::{Counter, CurrentSensor, Noise, Stretch, VelocityMeter};
use crate::effects::{EncoderAction, Reading, SensorAction};
use crate::robot::JointModel;

/// What the encoder remembers of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tracker {
    count: f64,
    velocity: Option<VelocityMeter>,
}

/// Encoder, velocity and current sensor of a joint.
pub struct Sensors {
    /// What the encoder remembers. Restoring it undoes a stretch of motion.
    pub tracker: Tracker,
    counter: Option<Counter>,
    link: Option<Counter>,
    current: Option<CurrentSensor>,
    noise: Noise,
    before: Vec<Box<dyn EncoderAction>>,
    actions: Vec<Box<dyn SensorAction>>,
}

impl Sensors {
    /// The sensors of a joint; the encoder's phase and the noise are drawn from the stream of that joint under the seed.
    pub fn new(joint: &JointModel, ideal: bool, seed: u64, stream: u64) -> Self {
        let mut noise = Noise::new(seed, stream);
        let phase = noise.uniform();
        let counter = joint.encoder.filter(|_| !ideal).map(|encoder| Counter::new(&encoder, joint.gear_ratio, phase));
        let link = joint.link_encoder.map(|encoder| match ideal {
            true => Counter { step: 0.0, phase: 0.0 },
            false => Counter { step: encoder.resolution, phase: noise.uniform() },
        });
        let velocity = joint.velocity_sensor.filter(|_| counter.is_some()).map(VelocityMeter::new);
        Self {
            tracker: Tracker { count: 0.0, velocity },
            current: joint.current_sensor.filter(|_| !ideal && joint.motor.is_some()),
            counter,
            link,
            noise,
            before: Vec::new(),
            actions: Vec::new(),
        }
    }

    /// Whether effects alter what they read.
    pub fn is_altered(&self) -> bool {
        !(self.actions.is_empty() && self.before.is_empty())
    }

    /// Adds an effect on the readings.
    pub fn push(&mut self, action: Box<dyn SensorAction>) {
        self.actions.push(action);
    }

    /// Adds an effect between shaft and encoder.
    pub fn push_before(&mut self, action: Box<dyn EncoderAction>) {
        self.before.push(action);
    }

    /// Position and velocity that the encoder sees.
    #[inline]
    fn seen(&self, y: &Phase) -> (f64, f64) {
        self.before.iter().fold((y.theta, y.omega), |(position, velocity), action| action.seen(position, velocity))
    }

    /// Restarts at a state, without memory of the past.
    pub fn restart(&mut self, y: &Phase) {
        if let Some(counter) = &self.counter {
            self.tracker.count = counter.count(self.seen(y).0);
        }
        if let Some(meter) = &mut self.tracker.velocity {
            meter.restart();
        }
    }

    /// Watches the motion between two instants.
    #[inline]
    pub fn watch(&mut self, time: [f64; 2], from: &Phase, to: &Phase) {
        let Some(counter) = &self.counter else { return };
        let (position, velocity) = self.seen(to);
        let count = counter.count(position);
        if count != self.tracker.count {
            let before = self.seen(from);
            if let Some(meter) = &mut self.tracker.velocity {
                let stretch = Stretch { time, position: [before.0, position], velocity: [before.1, velocity] };
                meter.watch(counter, &stretch, self.tracker.count, count);
            }
            self.tracker.count = count;
        }
    }

    /// Readings of the sensors, with the joint at `q`.
    pub fn read(&mut self, time: f64, y: &Phase, q: f64, current: f64) -> Reading {
        let (seen, seen_velocity) = self.seen(y);
        let position = self.counter.as_ref().map_or(seen, |counter| counter.position(self.tracker.count));
        let velocity = match (&self.counter, &mut self.tracker.velocity) {
            (Some(counter), Some(meter)) => meter.read(counter, time, position),
            _ => seen_velocity,
        };
        let current = self.current.map_or(current, |sensor| sensor.read(current, &mut self.noise));
        let link_position = self.link.map(|counter| match counter.step > 0.0 {
            true => counter.position(counter.count(q)),
            false => q,
        });
        let mut reading = Reading { position, velocity, current, link_position };
        for action in &mut self.actions {
            action.alter(time, &mut reading);
        }
        reading
    }
}

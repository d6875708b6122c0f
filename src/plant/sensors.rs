//! The sensors of a joint, and what effects do to their readings.

use super::joint::Phase;
use crate::drive::{Counter, CurrentSensor, Noise, Stretch, VelocityMeter};
use crate::effects::{Reading, SensorAction};
use crate::robot::JointModel;

/// Encoder, velocity and current sensor of a joint.
pub struct Sensors {
    counter: Option<Counter>,
    velocity: Option<VelocityMeter>,
    current: Option<CurrentSensor>,
    noise: Noise,
    count: f64,
    actions: Vec<Box<dyn SensorAction>>,
}

impl Sensors {
    /// The sensors of a joint; the encoder's phase and the noise are drawn from the stream of that joint under the seed.
    pub fn new(joint: &JointModel, ideal: bool, seed: u64, stream: u64) -> Self {
        let mut noise = Noise::new(seed, stream);
        let phase = noise.uniform();
        let counter = joint.encoder.filter(|_| !ideal).map(|encoder| Counter::new(&encoder, joint.gear_ratio, phase));
        Self {
            velocity: joint.velocity_sensor.filter(|_| counter.is_some()).map(VelocityMeter::new),
            current: joint.current_sensor.filter(|_| !ideal),
            counter,
            noise,
            count: 0.0,
            actions: Vec::new(),
        }
    }

    /// Adds what an effect does to the readings.
    pub fn push(&mut self, action: Box<dyn SensorAction>) {
        self.actions.push(action);
    }

    /// Starts anew at a place: what the sensors remember of the past is gone.
    pub fn restart(&mut self, y: &Phase) {
        if let Some(counter) = &self.counter {
            self.count = counter.count(y.theta);
        }
        if let Some(meter) = &mut self.velocity {
            meter.restart();
        }
    }

    /// Watches the motion between two instants.
    #[inline]
    pub fn watch(&mut self, time: [f64; 2], from: &Phase, to: &Phase) {
        let Some(counter) = &self.counter else { return };
        let count = counter.count(to.theta);
        if count != self.count {
            if let Some(meter) = &mut self.velocity {
                let stretch = Stretch { time, position: [from.theta, to.theta], velocity: [from.omega, to.omega] };
                meter.watch(counter, &stretch, self.count, count);
            }
            self.count = count;
        }
    }

    /// What the sensors say.
    pub fn read(&mut self, time: f64, y: &Phase, current: f64) -> Reading {
        let position = self.counter.as_ref().map_or(y.theta, |counter| counter.position(self.count));
        let velocity = match (&self.counter, &mut self.velocity) {
            (Some(counter), Some(meter)) => meter.read(counter, time, position),
            _ => y.omega,
        };
        let current = self.current.map_or(current, |sensor| sensor.read(current, &mut self.noise));
        let mut reading = Reading { position, velocity, current };
        for action in &mut self.actions {
            action.alter(time, &mut reading);
        }
        reading
    }
}

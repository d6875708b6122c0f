//! A run of a machine under its velocity controllers, recorded by its sensors.

use lostmotion::effects::Reading;
use lostmotion::plant::{Options, Plant};
use lostmotion::robot::Model;
use lostmotion::timeseries::{Channel, JointSeries, TimeSeries};

use super::machine::{GEAR_RATIO, TORQUE_CONSTANT};
use super::motion::{INTERVAL, Motion};

/// The velocity controller of a joint, on the measured velocity, and its rough feedforward, as an integrator of such an arm would set it.
#[derive(Debug, Clone, Copy)]
pub struct Gains {
    /// [N·m·s/rad], [N·m/rad]
    pub proportional: f64,
    pub integral: f64,
    /// [N·m] where the integral stops.
    pub integral_limit: f64,
    /// [kg·m²], [N·m], [N·m·s/rad] of the feedforward.
    pub inertia: f64,
    pub coulomb: f64,
    pub viscous: f64,
    /// [N·m] that the integral begins with: what holds the arm at its start.
    pub held: f64,
    /// [N·m/A] at the joint.
    pub torque_per_ampere: f64,
}

/// Of the planar arm.
pub const PLANAR: [Gains; 2] = [
    Gains {
        proportional: 5.0,
        integral: 50.0,
        integral_limit: 2.0,
        inertia: 0.3,
        coulomb: 0.3,
        viscous: 0.2,
        held: 0.0,
        torque_per_ampere: GEAR_RATIO[0] * TORQUE_CONSTANT,
    },
    Gains {
        proportional: 1.5,
        integral: 15.0,
        integral_limit: 2.0,
        inertia: 0.06,
        coulomb: 0.15,
        viscous: 0.1,
        held: 0.0,
        torque_per_ampere: GEAR_RATIO[1] * TORQUE_CONSTANT,
    },
];

/// [s] A sample and an interval of control that begin within this time of each other coincide.
const SAME: f64 = 1e-9;

/// Integrates twice as finely as the program does by default.
fn fine(seed: u64) -> Options {
    Options { step: 5e-4, substeps: 5, seed, ..Options::default() }
}

/// A value with the seven decimals that a logger would write.
fn written(value: f64) -> f64 {
    (value * 1e7).round() / 1e7
}

/// Records one session of the planar arm, a row for each interval of control.
pub fn record(name: &str, model: &Model, motion: &Motion, seed: u64) -> TimeSeries {
    let rows = motion.velocity[0].len();
    record_at(name, model, &PLANAR, motion, (0..rows).map(|k| k as f64 / 1000.0), seed)
}

/// Records one session at these times [s].
pub fn record_at(
    name: &str,
    model: &Model,
    gains: &[Gains],
    motion: &Motion,
    times: impl Iterator<Item = f64>,
    seed: u64,
) -> TimeSeries {
    let mut plant = Plant::new(model, &fine(seed)).expect("a drawn machine can be built");
    plant.place(&motion.start);
    let mut integral: Vec<f64> = gains.iter().map(|gains| gains.held).collect();
    let mut log = Log::new(model);
    let mut times = times.peekable();
    for k in 0..motion.velocity[0].len() {
        let readings = plant.read().to_vec();
        let references: Vec<f64> = motion.velocity.iter().map(|velocity| velocity[k]).collect();
        let commands: Vec<f64> = (0..gains.len())
            .map(|i| command(&gains[i], &motion.velocity[i][k..], readings[i].velocity, &mut integral[i]))
            .collect();
        let (start, end) = (k as f64 * INTERVAL, (k + 1) as f64 * INTERVAL);
        let mut left = INTERVAL;
        while let Some(time) = times.next_if(|time| *time < end - SAME) {
            let since = time - start;
            if since < SAME {
                log.push(time, &readings, &references, &commands);
                continue;
            }
            plant.advance(&commands, since - (INTERVAL - left)).expect("a drawn machine can be simulated");
            left = INTERVAL - since;
            log.push(time, plant.read(), &references, &commands);
        }
        plant.advance(&commands, left).expect("a drawn machine can be simulated");
    }
    TimeSeries { name: name.to_owned(), time: log.time, joints: log.joints }
}

/// The current [A] that the controller of a joint asks for: `reference` begins with the velocity of now.
fn command(gains: &Gains, reference: &[f64], velocity: f64, integral: &mut f64) -> f64 {
    let now = reference[0];
    let next = reference.get(1).copied().unwrap_or(now);
    let acceleration = (next - now) / INTERVAL;
    let error = now - velocity;
    let limit = gains.integral_limit;
    *integral = f64::clamp(*integral + gains.integral * error * INTERVAL, -limit, limit);
    // Rises over 0.01 rad/s so that it does not chatter at rest.
    let dry = gains.coulomb * (now / 0.01).clamp(-1.0, 1.0);
    let torque = gains.inertia * acceleration + dry + gains.viscous * now + gains.proportional * error + *integral;
    torque / gains.torque_per_ampere
}

/// What a logger writes.
struct Log {
    time: Vec<f64>,
    joints: Vec<JointSeries>,
}

impl Log {
    fn new(model: &Model) -> Self {
        let joint = |name: &String| JointSeries { name: name.clone(), ..JointSeries::default() };
        Self { time: Vec::new(), joints: model.joints.iter().map(|one| joint(&one.name)).collect() }
    }

    fn push(&mut self, time: f64, readings: &[Reading], references: &[f64], commands: &[f64]) {
        self.time.push(time);
        for (i, (joint, reading)) in self.joints.iter_mut().zip(readings).enumerate() {
            let samples = [
                (Channel::Position, Some(reading.position)),
                (Channel::Velocity, Some(reading.velocity)),
                (Channel::Current, Some(reading.current)),
                (Channel::ReferenceVelocity, Some(references[i])),
                (Channel::CommandCurrent, Some(commands[i])),
                (Channel::LinkPosition, reading.link_position),
            ];
            for (channel, value) in samples.into_iter().filter_map(|(channel, value)| Some((channel, value?))) {
                joint.channels.entry(channel).or_default().push(written(value));
            }
        }
    }
}

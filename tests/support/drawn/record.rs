//! A run of a machine under its velocity controllers, recorded by its sensors.

use lostmotion::plant::{Options, Plant};
use lostmotion::robot::Model;
use lostmotion::timeseries::{Channel, JointSeries, TimeSeries};

use super::machine::{GEAR_RATIO, JOINTS, TORQUE_CONSTANT};
use super::motion::{INTERVAL, Motion};

/// [N·m·s/rad], [N·m/rad] of the velocity controllers, on the measured velocity.
const PROPORTIONAL: [f64; 2] = [5.0, 1.5];
const INTEGRAL: [f64; 2] = [50.0, 15.0];
/// [kg·m²], [N·m], [N·m·s/rad] rough feedforward, as an integrator of such an arm would set it.
const INERTIA: [f64; 2] = [0.3, 0.06];
const COULOMB: [f64; 2] = [0.3, 0.15];
const VISCOUS: [f64; 2] = [0.2, 0.1];
/// [N·m] where the integral stops.
const INTEGRAL_LIMIT: f64 = 2.0;

/// Integrates twice as finely as the program does by default.
fn fine(seed: u64) -> Options {
    Options { step: 5e-4, substeps: 5, seed, ..Options::default() }
}

/// A value with the seven decimals that a logger would write.
fn written(value: f64) -> f64 {
    (value * 1e7).round() / 1e7
}

/// Records one session.
pub fn record(name: &str, model: &Model, motion: &Motion, seed: u64) -> TimeSeries {
    let mut plant = Plant::new(model, &fine(seed)).expect("a drawn machine can be built");
    plant.place(&motion.start);
    let mut joints = JOINTS.map(|name| JointSeries { name: name.to_owned(), ..JointSeries::default() });
    let mut integral = [0.0; 2];
    let mut time = Vec::new();
    for k in 0..motion.velocity[0].len() {
        time.push((k as f64) / 1000.0);
        let readings = plant.read().to_vec();
        let mut commands = [0.0; 2];
        for i in 0..2 {
            let reference = motion.velocity[i][k];
            let next = motion.velocity[i].get(k + 1).copied().unwrap_or(reference);
            let acceleration = (next - reference) / INTERVAL;
            let error = reference - readings[i].velocity;
            integral[i] = f64::clamp(integral[i] + INTEGRAL[i] * error * INTERVAL, -INTEGRAL_LIMIT, INTEGRAL_LIMIT);
            // Rises over 0.01 rad/s so that it does not chatter at rest.
            let dry = COULOMB[i] * (reference / 0.01).clamp(-1.0, 1.0);
            let torque =
                INERTIA[i] * acceleration + dry + VISCOUS[i] * reference + PROPORTIONAL[i] * error + integral[i];
            commands[i] = torque / (GEAR_RATIO[i] * TORQUE_CONSTANT);
            let samples = [
                (Channel::Position, readings[i].position),
                (Channel::Velocity, readings[i].velocity),
                (Channel::Current, readings[i].current),
                (Channel::ReferenceVelocity, reference),
                (Channel::CommandCurrent, commands[i]),
            ];
            for (channel, value) in samples {
                joints[i].channels.entry(channel).or_default().push(written(value));
            }
            if let Some(link) = readings[i].link_position {
                joints[i].channels.entry(Channel::LinkPosition).or_default().push(written(link));
            }
        }
        plant.advance(&commands, INTERVAL).unwrap();
    }
    TimeSeries { name: name.to_owned(), time, joints: joints.into() }
}

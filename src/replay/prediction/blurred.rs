//! A recording as other sensors of the same kind would have made it: what predictions from it and from the recording itself differ by is
//! what the sensors leave of an exact model.
//!
//! ```text
//!   floor² = ½ mean (q' − q)² + δ²/12          q, q': predictions from the recording and from the blurred one, δ: step of the encoder
//! ```
//! Both predictions have an error of the sensors of their own, of equal variance, hence the half; the last term is the reading that the
//! prediction is compared with. The floor belongs to the recorded motion with all its sensitivity: where friction falls with speed, small errors
//! grow, and the floor is high.
//!
//! The *position* is that of an encoder mounted at another angle. In between, the joint moved linearly from edge to edge, each of which was passed
//! half way between two samples. Errors of two encoders whose counts are shifted by a share `s` of a count have the correlation `1 − 6 s (1 − s)`,
//! which is zero at `s = ½ − 1/√12`. A *torque* gets white noise of `√2` times the standard deviation of its sensor: the noise that it has
//! already is common to both.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use super::encoder_step;
use crate::dataset::Session;
use crate::drive::Counter;
use crate::replay::inputs::Input;
use crate::robot::Model;
use crate::timeseries::{Channel, JointSeries, Samples, white_noise};

/// Seed of the noise: the same data give the same floor.
const SEED: u64 = 0x666c_6f6f_7200;

/// The recording as other sensors would have made it. Noise and steps are those of the model's sensors, otherwise of the recording.
pub(super) fn blurred(model: &Model, session: &Session, inputs: &[Input]) -> Session {
    let mut session = session.clone();
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    for (joint, input) in model.joints.iter().zip(inputs) {
        let Some(recorded) = session.series.joints.iter_mut().find(|one| one.name == joint.name) else { continue };
        let step = encoder_step(joint, input);
        let position = match step > 0.0 {
            true => other_encoder(&session.series.time, &input.position, step),
            false => noisy(&input.position, white_noise(&input.position), &mut random),
        };
        recorded.channels.insert(Channel::Position, position);
        // A command is known exactly.
        let channel = driving(recorded);
        if let Some(torque) = recorded.channels.get(&channel).filter(|_| channel != Channel::CommandCurrent) {
            let noise = match joint.current_sensor.filter(|_| channel == Channel::Current) {
                Some(sensor) => (sensor.noise.powi(2) + sensor.resolution.powi(2) / 12.0).sqrt(),
                None => white_noise(torque),
            };
            let torque = noisy(torque, noise, &mut random);
            recorded.channels.insert(channel, torque);
        }
    }
    session
}

/// The channel whose torque drives a model in a replay.
fn driving(recorded: &JointSeries) -> Channel {
    let channels = [Channel::Torque, Channel::CommandCurrent];
    channels.into_iter().find(|channel| recorded.channels.contains_key(channel)).unwrap_or(Channel::Current)
}

/// A signal with more white noise: `√2` times this standard deviation.
fn noisy(signal: &[f64], noise: f64, random: &mut ChaCha8Rng) -> Samples {
    let Ok(noise) = Normal::new(0.0, std::f64::consts::SQRT_2 * noise) else { return signal.to_vec().into() };
    signal.iter().map(|value| value + noise.sample(random)).collect::<Vec<_>>().into()
}

/// Positions of an encoder with the same step at another angle.
fn other_encoder(time: &[f64], position: &[f64], step: f64) -> Samples {
    let shift = 0.5 - 1.0 / 12.0_f64.sqrt();
    let Some(first) = position.first() else { return Samples::default() };
    let counter = Counter { step, phase: (0.5 - first / step).rem_euclid(1.0) + shift };
    let moved = between_edges(time, position, step);
    moved.into_iter().map(|q| counter.position(counter.count(q))).collect::<Vec<_>>().into()
}

/// The motion between the edges that an encoder passed: linear, and within the count that was read.
fn between_edges(time: &[f64], position: &[f64], step: f64) -> Vec<f64> {
    let edges = (1..position.len()).filter(|k| position[*k] != position[k - 1]);
    let edge = |k: usize| [0.5 * (time[k - 1] + time[k]), 0.5 * (position[k - 1] + position[k])];
    let mut edges = edges.map(edge).peekable();
    let mut last = None;
    let at = |(k, read): (usize, &f64)| {
        while let Some(passed) = edges.next_if(|[when, _]| *when <= time[k]) {
            last = Some(passed);
        }
        let moved = match (last, edges.peek()) {
            (Some([from, start]), Some([to, end])) => start + (end - start) * (time[k] - from) / (to - from),
            _ => *read,
        };
        moved.clamp(read - 0.5 * step, read + 0.5 * step)
    };
    position.iter().enumerate().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_two_encoders_on_one_motion_have_errors_of_their_own() {
        // A ramp of 0.37 counts a sample: both read it within half a count, and their errors are uncorrelated.
        let (step, samples) = (0.01, 20_000);
        let time: Vec<f64> = (0..samples).map(|k| 1e-3 * f64::from(k)).collect();
        let truth: Vec<f64> = (0..samples).map(|k| 0.37 * step * f64::from(k)).collect();
        let counter = Counter { step, phase: 0.3 };
        let read: Vec<f64> = truth.iter().map(|q| counter.position(counter.count(*q))).collect();
        let other = other_encoder(&time, &read, step);
        let errors =
            |values: &[f64]| -> Vec<f64> { values.iter().zip(&truth).map(|(q, truth)| (q - truth) / step).collect() };
        let [one, two] = [errors(&read), errors(&other)];
        let mean = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / f64::from(samples);
        // Uniform within a count; what interpolation between edges adds is below a tenth of it.
        assert!((mean(&one, &one) - 1.0 / 12.0).abs() < 1e-3);
        assert!((mean(&two, &two) - 1.0 / 12.0).abs() < 0.02, "{}", mean(&two, &two));
        assert!(mean(&one, &two).abs() < 0.02, "{}", mean(&one, &two));
    }
}

//! When a logger takes its samples, and what sensors it reads: drawn by seed.
#![allow(dead_code, reason = "every test file is its own crate and uses its own part")]

use lostmotion::drive::Encoder;
use lostmotion::robot::Model;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// [Hz] Slowest and fastest logger.
pub const RATES: [f64; 2] = [100.0, 4000.0];
/// Fewest and most counts a motor turn.
pub const COUNTS: [f64; 2] = [500.0, 1_048_576.0];
/// [A] Least and most noise of a current sensor.
pub const NOISE: [f64; 2] = [0.01, 0.1];
/// [1] A jittered sample is off by up to this share of the interval: two samples never change their order, and no step is twice another's
/// neighbour.
const JITTER: f64 = 0.3;
/// [s] Shortest and longest pause.
const PAUSE: [f64; 2] = [0.1, 1.0];

/// How the sessions of a machine are sampled.
#[derive(Debug, Clone, Copy)]
pub struct Sampling {
    /// [Hz]
    pub rate: f64,
    /// [1] largest deviation of a sample from its place, as a share of the interval; 0: even.
    pub jitter: f64,
    /// Of the encoders, a motor turn.
    pub counts_per_turn: f64,
    /// [A] of the current sensors.
    pub noise: f64,
}

/// A number between two, each factor as likely as any other.
fn between(rng: &mut ChaCha8Rng, [low, high]: [f64; 2]) -> f64 {
    low * (high / low).powf(rng.random_range(0.0..1.0))
}

impl Sampling {
    /// One in two is even.
    pub fn draw(rng: &mut ChaCha8Rng) -> Self {
        let rate = between(rng, RATES);
        let counts_per_turn = between(rng, COUNTS).round();
        let noise = between(rng, NOISE);
        let jitter = if rng.random_bool(0.5) { JITTER } else { 0.0 };
        Self { rate, jitter, counts_per_turn, noise }
    }

    /// The times [s] of the samples of a session that lasts for so long; one session in four has a pause of 0.1 to 1 s.
    pub fn times(&self, rng: &mut ChaCha8Rng, duration: f64) -> Vec<f64> {
        let samples = (duration * self.rate) as usize;
        let pause = rng.random_bool(0.25).then(|| {
            let begin = rng.random_range(0.1..0.9) * duration;
            begin..begin + between(rng, PAUSE)
        });
        let mut time = |k: usize| {
            let off = if self.jitter > 0.0 { self.jitter * rng.random_range(-1.0..1.0) } else { 0.0 };
            ((k as f64 + off) / self.rate).max(0.0)
        };
        let all = (0..samples).map(&mut time);
        all.filter(|time| pause.as_ref().is_none_or(|pause| !pause.contains(time))).collect()
    }

    /// Puts these sensors on a machine.
    pub fn equip(&self, model: &mut Model) {
        for joint in &mut model.joints {
            joint.encoder = Some(Encoder { counts_per_turn: self.counts_per_turn });
            if let Some(sensor) = &mut joint.current_sensor {
                sensor.noise = self.noise;
            }
        }
    }

    /// One line for the log.
    pub fn line(&self) -> String {
        let Self { rate, jitter, counts_per_turn, noise } = self;
        let even = if *jitter > 0.0 { "uneven" } else { "even" };
        format!("{rate:.0} Hz {even}, {counts_per_turn} counts, {:.0} mA", 1e3 * noise)
    }
}

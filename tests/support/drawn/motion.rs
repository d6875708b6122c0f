//! The motions of a set: a staircase of slow speeds with rests of different length, and fast runs.

use std::f64::consts::PI;

use lostmotion::units::DEG;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// [s] Interval of control and of recording.
pub const INTERVAL: f64 = 1e-3;

/// [rad/s²] of the staircase.
const ACCELERATION: f64 = 1.0;

/// [s] Length of a fast run.
const FAST: f64 = 40.0;

/// Where a run starts [rad] and the velocity references of both joints [rad/s], sample by sample.
#[derive(Debug)]
pub struct Motion {
    pub start: [f64; 2],
    pub velocity: [Vec<f64>; 2],
}

/// ±0.5 to ±10 deg/s in steps of 0.5 deg/s, one joint after the other; each speed as long as it takes for 3 degrees, 1 to 6 s.
/// After every other pair of speeds the joint rests for 0.2 to 3 s: what grows at rest can be told by rests of different length only.
pub fn staircase(rng: &mut ChaCha8Rng) -> Motion {
    const STEPS: usize = 20;
    let start = [rng.random_range(-1.2..1.2), rng.random_range(-1.2..1.2)];
    let mut velocity = [Vec::new(), Vec::new()];
    for joint in 0..2 {
        for step in 1..=STEPS {
            let speed = 0.5 * step as f64 * DEG;
            let samples = ((3.0 * DEG / speed).clamp(1.0, 6.0) / INTERVAL) as usize;
            for sign in [1.0, -1.0] {
                for _ in 0..samples {
                    let before = velocity[joint].last().copied().unwrap_or(0.0);
                    let change: f64 = sign * speed - before;
                    let most = ACCELERATION * INTERVAL;
                    velocity[joint].push(before + change.clamp(-most, most));
                    velocity[1 - joint].push(0.0);
                }
            }
            if step % 2 == 0 {
                rest(&mut velocity, joint, 0.2 * 15.0_f64.powf(rng.random_range(0.0..1.0)));
            }
        }
        rest(&mut velocity, joint, 0.5);
    }
    Motion { start, velocity }
}

/// Brings a joint back to rest, and lets it rest for the remainder of `duration` [s].
fn rest(velocity: &mut [Vec<f64>; 2], joint: usize, duration: f64) {
    for _ in 0..(duration / INTERVAL) as usize {
        let before = velocity[joint].last().copied().unwrap_or(0.0);
        velocity[joint].push(before - before.clamp(-ACCELERATION * INTERVAL, ACCELERATION * INTERVAL));
        velocity[1 - joint].push(0.0);
    }
}

/// Half a run of joined sines, half of moves from rest to rest, both joints at once, up to 120 deg/s.
pub fn fast(rng: &mut ChaCha8Rng) -> Motion {
    let plans = [Plan::draw(rng), Plan::draw(rng)];
    let samples = (FAST / INTERVAL) as usize;
    let speed = |plan: &Plan| {
        let at = |k: usize| plan.position(k as f64 * INTERVAL);
        (0..samples).map(|k| (at(k + 1) - at(k)) / INTERVAL).collect()
    };
    Motion { start: [plans[0].position(0.0), plans[1].position(0.0)], velocity: [speed(&plans[0]), speed(&plans[1])] }
}

/// Planned positions of one joint.
struct Plan {
    start: f64,
    /// Amplitude [rad], frequency [Hz], phase.
    sines: Vec<[f64; 3]>,
    /// Start [s], duration [s], from [rad], to [rad].
    moves: Vec<[f64; 4]>,
}

impl Plan {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        let start = rng.random_range(-0.4..0.4);
        let top = rng.random_range(70.0..120.0) * DEG;
        let sines: Vec<[f64; 3]> = (0..4)
            .map(|_| {
                let frequency = rng.random_range(0.06..0.4);
                [rng.random_range(0.3..1.0) / frequency, frequency, rng.random_range(-PI..PI)]
            })
            .collect();
        // Speeds add up to `top` at most; and so that the joint stays within ±1.5 rad of its start.
        let speed: f64 = sines.iter().map(|[amplitude, frequency, _]| 2.0 * PI * frequency * amplitude).sum();
        let reach: f64 = sines.iter().map(|[amplitude, ..]| 2.0 * amplitude).sum();
        let scale = (1.6 * top / speed).min(2.4 / reach);
        let sines = sines.iter().map(|&[amplitude, frequency, phase]| [scale * amplitude, frequency, phase]).collect();

        let mut moves = Vec::new();
        let (mut time, mut at) = (FAST / 2.0, start);
        while time < FAST - 3.5 {
            let to: f64 = rng.random_range(-1.8..1.8);
            // The peak of a minimum-jerk move is 1.875 times its mean speed.
            let duration = (1.875 * (to - at).abs() / (top * rng.random_range(0.5..1.0))).max(0.8);
            moves.push([time, duration, at, to]);
            time += duration + rng.random_range(0.05..0.5);
            at = to;
        }
        Self { start, sines, moves }
    }

    fn position(&self, time: f64) -> f64 {
        if let Some([begin, duration, from, to]) = self.moves.iter().rfind(|one| one[0] <= time) {
            let s = ((time - begin) / duration).min(1.0);
            return from + (to - from) * s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
        }
        // Rises from rest and comes back to it.
        let window = (PI * time / (FAST / 2.0)).sin().powi(2);
        let sum = self
            .sines
            .iter()
            .map(|[amplitude, frequency, phase]| amplitude * (2.0 * PI * frequency * time + phase).sin());
        self.start + window * sum.sum::<f64>()
    }
}

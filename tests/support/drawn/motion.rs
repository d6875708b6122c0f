//! The motions of a set: a staircase of slow speeds with rests of different length, fast runs, and point-to-point motion with dwells.
#![allow(dead_code, reason = "every test file is its own crate and uses its own part")]

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

/// [rad] Half the range of a joint of the planar arm in fast runs.
const HALF: f64 = 1.8;

/// Where a run starts [rad] and the velocity references of the joints [rad/s], sample by sample.
#[derive(Debug)]
pub struct Motion {
    pub start: Vec<f64>,
    pub velocity: Vec<Vec<f64>>,
}

/// Where a joint moves: the middle of its range and half of it [rad].
#[derive(Debug, Clone, Copy)]
pub struct Space {
    pub middle: f64,
    pub half: f64,
}

impl Space {
    /// Of both joints of the planar arm.
    pub const PLANAR: [Self; 2] = [Self { middle: 0.0, half: HALF }; 2];

    /// [rad] a position of the planar arm in this range.
    fn at(&self, position: f64) -> f64 {
        self.middle + self.half / HALF * position
    }
}

/// ±0.5 to ±10 deg/s in steps of 0.5 deg/s, one joint after the other.
pub fn staircase(rng: &mut ChaCha8Rng) -> Motion {
    let start = vec![rng.random_range(-1.2..1.2), rng.random_range(-1.2..1.2)];
    stairs(rng, start, 20)
}

/// So many speeds up to ±10 deg/s, one joint after the other; each speed as long as it takes for 3 degrees, 1 to 6 s.
/// After every other pair of speeds the joint rests for 0.2 to 3 s: what grows at rest can be told by rests of different length only.
pub fn stairs(rng: &mut ChaCha8Rng, start: Vec<f64>, steps: usize) -> Motion {
    let mut velocity = vec![Vec::new(); start.len()];
    for joint in 0..start.len() {
        for step in 1..=steps {
            let speed = 10.0 / steps as f64 * step as f64 * DEG;
            let samples = ((3.0 * DEG / speed).clamp(1.0, 6.0) / INTERVAL) as usize;
            for sign in [1.0, -1.0] {
                for _ in 0..samples {
                    let before = velocity[joint].last().copied().unwrap_or(0.0);
                    let change: f64 = sign * speed - before;
                    let most = ACCELERATION * INTERVAL;
                    push(&mut velocity, joint, before + change.clamp(-most, most));
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

/// One sample more: this velocity of a joint, the others at rest.
fn push(velocity: &mut [Vec<f64>], joint: usize, value: f64) {
    velocity.iter_mut().for_each(|one| one.push(0.0));
    if let Some(last) = velocity[joint].last_mut() {
        *last = value;
    }
}

/// Brings a joint back to rest, and lets it rest for the remainder of `duration` [s].
fn rest(velocity: &mut [Vec<f64>], joint: usize, duration: f64) {
    for _ in 0..(duration / INTERVAL) as usize {
        let before = velocity[joint].last().copied().unwrap_or(0.0);
        push(velocity, joint, before - before.clamp(-ACCELERATION * INTERVAL, ACCELERATION * INTERVAL));
    }
}

/// Half a run of joined sines, half of moves from rest to rest, both joints at once, up to 120 deg/s.
pub fn fast(rng: &mut ChaCha8Rng) -> Motion {
    fast_in(rng, &Space::PLANAR)
}

/// The same in these ranges, faster or slower as they are wider or narrower.
pub fn fast_in(rng: &mut ChaCha8Rng, spaces: &[Space]) -> Motion {
    let plans: Vec<Plan> = spaces.iter().map(|_| Plan::draw(rng)).collect();
    sampled(spaces, |joint, time| plans[joint].position(time))
}

/// The velocities of planned positions of the planar arm [rad] at times [s], in these ranges.
fn sampled(spaces: &[Space], position: impl Fn(usize, f64) -> f64) -> Motion {
    let at = |joint: usize, k: usize| spaces[joint].at(position(joint, k as f64 * INTERVAL));
    let samples = (FAST / INTERVAL) as usize;
    let speed = |joint: usize| (0..samples).map(|k| (at(joint, k + 1) - at(joint, k)) / INTERVAL).collect();
    let joints = 0..spaces.len();
    Motion { start: joints.clone().map(|joint| at(joint, 0)).collect(), velocity: joints.map(speed).collect() }
}

/// Pick and place: all joints go together from one of a few points to another and dwell there for 0.2 to 2 s.
pub fn pick_and_place(rng: &mut ChaCha8Rng, spaces: &[Space]) -> Motion {
    const POINTS: usize = 6;
    let points: Vec<Vec<f64>> =
        (0..POINTS).map(|_| spaces.iter().map(|_| rng.random_range(-HALF..HALF)).collect()).collect();
    let top = rng.random_range(70.0..120.0) * DEG;
    // Start [s], duration [s], from and to by number.
    let mut moves: Vec<(f64, f64, usize, usize)> = Vec::new();
    let (mut time, mut from) = (0.5, 0);
    while time < FAST - 5.0 {
        let to = (from + rng.random_range(1..POINTS)) % POINTS;
        let longest = points[from].iter().zip(&points[to]).map(|(from, to)| (to - from).abs()).fold(0.0, f64::max);
        // The peak of a minimum-jerk move is 1.875 times its mean speed.
        let duration = (1.875 * longest / (top * rng.random_range(0.5..1.0))).max(0.6);
        moves.push((time, duration, from, to));
        time += duration + 0.2 * 10.0_f64.powf(rng.random_range(0.0..1.0));
        from = to;
    }
    sampled(spaces, |joint, time| match moves.iter().rfind(|one| one.0 <= time) {
        None => points[0][joint],
        Some(&(begin, duration, from, to)) => {
            minimum_jerk([points[from][joint], points[to][joint]], (time - begin) / duration)
        }
    })
}

/// A move from rest to rest after a part `s` of its time.
fn minimum_jerk([from, to]: [f64; 2], s: f64) -> f64 {
    let s = s.min(1.0);
    from + (to - from) * s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s)
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
            return minimum_jerk([*from, *to], (time - begin) / duration);
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

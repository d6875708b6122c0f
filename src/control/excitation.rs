//! Fast motions of several joints at once, drawn by a seed: data that a diagnosis can tell effects apart with.
//!
//! Every joint goes from place to place of its range, quickest way within a speed and an acceleration, with rests between;
//! speeds are drawn between a tenth of the joint's speed and all of it, so that slow and fast moves come in random order and
//! what grows with time is not taken for what grows with speed.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Profile, Track};

/// What a joint may do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointRange {
    /// [rad or m] places to go to.
    pub positions: [f64; 2],
    /// [rad/s or m/s] > 0.
    pub speed: f64,
    /// [rad/s² or m/s²] > 0.
    pub acceleration: f64,
}

/// Most moves of a joint: a day of one a second.
const MOST_MOVES: usize = 86_400;

/// A joint would move more often than anything is meant to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooManyMoves {
    /// Index of the joint.
    pub joint: usize,
    /// Most moves that are made.
    pub most: usize,
}

/// A fast motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Excitation {
    /// One a joint; `None` rests at its start.
    pub joints: Vec<Option<JointRange>>,
    /// [s] Moves begin until then.
    pub duration: f64,
    /// [s] Longest rest between moves, ≥ 0.
    pub longest_rest: f64,
    /// Decides places, speeds and rests.
    pub seed: u64,
}

impl Excitation {
    /// The motion from a start [rad or m, one a joint]; it ends at rest.
    ///
    /// # Errors
    /// A joint goes to and fro more often than anything is meant to: its places are too close to each other for the duration.
    pub fn profile(&self, start: &[f64]) -> Result<Profile, TooManyMoves> {
        let track = |(joint, &position): (usize, &f64)| self.track(joint, position);
        Ok(Profile::new(start.iter().enumerate().map(track).collect::<Result<_, _>>()?))
    }

    fn track(&self, joint: usize, start: f64) -> Result<Track, TooManyMoves> {
        let mut track = Track::at(start);
        let Some(range) = self.joints.get(joint).copied().flatten() else { return Ok(track) };
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(joint as u64);
        let [low, high] = range.positions;
        let mut moves = 0;
        while track.duration() < self.duration {
            moves += 1;
            if moves > MOST_MOVES {
                return Err(TooManyMoves { joint, most: MOST_MOVES });
            }
            let place = low + (high - low) * random.random::<f64>();
            let speed = range.speed * (0.1 + 0.9 * random.random::<f64>());
            let rest = self.longest_rest * random.random::<f64>();
            track.move_to(place, speed, range.acceleration);
            track.coast(rest);
        }
        Ok(track)
    }
}

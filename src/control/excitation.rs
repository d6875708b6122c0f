//! Fast random motions of several joints at once: data in which a diagnosis can separate effects.
//!
//! Every joint moves between positions of its range, in the shortest time for a given speed and acceleration, with
//! rests in between. Speeds are drawn between a tenth of the joint's speed and all of it, so that slow and fast moves
//! come in random order and effects that grow with time are not confused with effects that grow with speed.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Profile, Track};

/// Positions and limits of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointRange {
    /// [rad or m] Positions to move to.
    pub positions: [f64; 2],
    /// [rad/s or m/s] > 0.
    pub speed: f64,
    /// [rad/s² or m/s²] > 0.
    pub acceleration: f64,
}

/// Largest number of moves of a joint: one per second for a day.
const MOST_MOVES: usize = 86_400;

/// The joint would make more moves than allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooManyMoves {
    /// Index of the joint.
    pub joint: usize,
    /// Largest allowed number of moves.
    pub most: usize,
}

/// A fast motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Excitation {
    /// One per joint; `None`: the joint rests at its start.
    pub joints: Vec<Option<JointRange>>,
    /// [s] No move begins after this time.
    pub duration: f64,
    /// [s] Longest rest between moves, ≥ 0.
    pub longest_rest: f64,
    /// Seed of positions, speeds and rests.
    pub seed: u64,
}

impl Excitation {
    /// The motion from a start [rad or m, one per joint]; it ends at rest.
    ///
    /// # Errors
    /// A joint makes too many moves: its positions are too close to each other for the duration.
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

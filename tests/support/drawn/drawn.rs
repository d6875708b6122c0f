//! A set as it is drawn, before anything of it is written: what tests plant in memory is what the blind sets hold.

use std::path::Path;

use lostmotion::robot::{EffectEntry, Model};
use lostmotion::timeseries::TimeSeries;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::hidden::{self, Order};
use super::machine::Machine;
use super::motion;
use super::record::record;

/// Names of the sessions; the last one is held out.
pub const SESSIONS: [&str; 4] = ["staircase", "fast_1", "fast_2", "fast_3"];

/// A machine of an order, with what is hidden in it.
#[derive(Debug)]
pub struct Drawn {
    /// The machine.
    pub machine: Machine,
    /// What is hidden in it.
    pub entries: Vec<EffectEntry>,
    seed: u64,
    /// Another day has other motions and other noise.
    later: u64,
}

/// Streams of random numbers of one seed: the machine and its motion are the same whatever it hides.
fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}

impl Drawn {
    pub fn new(order: &Order) -> Self {
        let mut machine = Machine::draw(&mut stream(order.seed, 0));
        let entries = hidden::draw(&mut stream(order.seed, 1), order, &mut machine);
        Self { machine, entries, seed: order.seed, later: u64::from(order.changed().is_some()) }
    }

    /// Records the sessions, one after the other.
    pub fn sessions(&self) -> impl Iterator<Item = TimeSeries> {
        let truth = self.machine.truth(&self.entries);
        let model = Model::from_texts(&truth, &self.machine.urdf(), Path::new("truth.toml")).expect("a good model");
        let mut moves = stream(self.seed, 2 + self.later);
        let (seed, later) = (self.seed, self.later);
        SESSIONS.into_iter().enumerate().map(move |(index, name)| {
            let motion = if index == 0 { motion::staircase(&mut moves) } else { motion::fast(&mut moves) };
            record(name, &model, &motion, 4 * seed + index as u64 + (later << 40))
        })
    }
}

//! By how much the error of one model is smaller than that of another on the same data, and whether this is
//! significant.
//!
//! ```text
//!   g = 1 − √(Σ e_after² / Σ e_before²)          pairs (e_before, e_after) of the same instants
//! ```
//! Errors of neighbouring samples are correlated, so whole blocks of some seconds are drawn with replacement, both
//! errors of a block together: a stretch on which both models are bad favours neither. The ends of the interval are the
//! percentiles of the draws with the tails
//!
//! ```text
//!   Φ(−t_{0.975, m−1} √(m/(m−1)))          2.5 % for many blocks, less for few
//! ```
//! because few or unequal blocks scatter less among themselves than blocks in general do: `m = 1/Σ w²` is the effective
//! number of equal blocks, and `w_i` the share of block `i` in the squared errors. No draw gains more than the best
//! block or less than the worst. So a gain on every block gives an interval above zero, even if one block has most of
//! the error.
//! A gain is significant if its 95 % interval excludes zero. Left out: variation between sessions if only one was
//! evaluated.
//! References: H. R. Künsch (1989), The jackknife and the bootstrap for general stationary observations;
//! T. C. Hesterberg (2015), What teachers should know about the bootstrap, section 3.5; L. Kish (1965), Survey sampling, for `m`.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::distributions::{normal_upper_tail, student_975};

/// [s] Length of a block, unless that leaves fewer than [`WANTED_BLOCKS`].
const BLOCK: f64 = 5.0;
/// [s] Shortest block: after the low-pass of a comparison, errors are correlated over a shorter time.
const SHORTEST_BLOCK: f64 = 0.5;
/// Number of blocks that short data are divided into.
const WANTED_BLOCKS: f64 = 10.0;
/// Fewer blocks give no interval: of four blocks, a draw repeats the same one four times in 1/256 of all cases.
const FEWEST_BLOCKS: usize = 4;
/// Number of draws: the ends of a 95 % interval then scatter by a fiftieth of its width, and two draws lie in the
/// smallest tail, 1.2e-4.
const DRAWS: usize = 16_000;
/// Seed of the draws: the same data give the same interval.
const SEED: u64 = 0x6761_696e;

/// A gain with its interval.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Gain {
    /// [%] by which the RMS error falls; negative if it grows.
    pub gain_percent: f64,
    /// [%] ends of its 95 % interval; zero and the gain if the data are too short for an interval.
    pub interval_percent: [f64; 2],
    /// Whether the interval lies above zero; otherwise no gain is reported.
    pub shown: bool,
}

/// Squared errors of both models in one block.
#[derive(Debug, Clone, Copy, Default)]
struct Power {
    before: f64,
    after: f64,
}

/// Errors of two models at the same instants of one session.
#[derive(Debug, Clone, Copy)]
pub struct Pairs<'a> {
    /// [s] instants, rising.
    pub time: &'a [f64],
    /// Errors of the first model.
    pub before: &'a [f64],
    /// Errors of the second model.
    pub after: &'a [f64],
}

impl Gain {
    /// The gain over sessions.
    pub fn of(sessions: &[Pairs]) -> Self {
        let blocks = blocks(sessions);
        let all = blocks.iter().copied().fold(Power::default(), Power::plus);
        if all.before <= 0.0 {
            return Self::default();
        }
        let gain_percent = percent(all.log_ratio());
        if blocks.len() < FEWEST_BLOCKS {
            return Self {
                gain_percent,
                interval_percent: [gain_percent.min(0.0), gain_percent.max(0.0)],
                shown: false,
            };
        }
        let interval_percent = interval(&blocks, all).map(percent);
        Self { gain_percent, interval_percent, shown: interval_percent[0] > 0.0 }
    }
}

impl Power {
    fn plus(self, other: Self) -> Self {
        Self { before: self.before + other.before, after: self.after + other.after }
    }

    /// `L = ln √(Σ e_after² / Σ e_before²)`, finite even if a model has no error.
    fn log_ratio(self) -> f64 {
        0.5 * (self.after.max(1e-300) / self.before.max(1e-300)).ln()
    }
}

fn percent(log_ratio: f64) -> f64 {
    100.0 * (1.0 - log_ratio.exp())
}

/// The blocks of all sessions, equally long in time within each.
fn blocks(sessions: &[Pairs]) -> Vec<Power> {
    let span = |pairs: &Pairs| match (pairs.time.first(), pairs.time.last()) {
        (Some(first), Some(last)) => last - first,
        _ => 0.0,
    };
    // Only the time with evaluated rows counts: in a recording that is evaluated only in places, many blocks of the
    // whole time would be empty.
    let judged = |pairs: &Pairs| pairs.time.windows(2).map(|pair| (pair[1] - pair[0]).min(SHORTEST_BLOCK)).sum::<f64>();
    let total: f64 = sessions.iter().map(judged).sum();
    let length = BLOCK.min(total / WANTED_BLOCKS).max(SHORTEST_BLOCK);
    let mut blocks = Vec::new();
    for pairs in sessions.iter().filter(|pairs| !pairs.time.is_empty()) {
        let count = (span(pairs) / length).round().max(1.0);
        let width = span(pairs).max(f64::MIN_POSITIVE) / count;
        let mut powers = vec![Power::default(); count as usize];
        for ((time, before), after) in pairs.time.iter().zip(pairs.before).zip(pairs.after) {
            let block = (((time - pairs.time[0]) / width) as usize).min(powers.len() - 1);
            powers[block] = powers[block].plus(Power { before: before * before, after: after * after });
        }
        // Blocks without evaluated rows are left out.
        blocks.extend(powers.into_iter().filter(|power| power.before + power.after > 0.0));
    }
    blocks
}

/// Ends of the interval of `L`; the end with the larger gain is last.
fn interval(blocks: &[Power], all: Power) -> [f64; 2] {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut draw = || {
        let drawn = (0..blocks.len()).map(|_| blocks[rng.random_range(0..blocks.len())]);
        drawn.fold(Power::default(), Power::plus).log_ratio()
    };
    let mut draws: Vec<f64> = (0..DRAWS).map(|_| draw()).collect();
    draws.sort_by(f64::total_cmp);
    let share = |block: &Power| 0.5 * (block.before / all.before + block.after / all.after.max(1e-300));
    let m = 1.0 / blocks.iter().map(|block| share(block).powi(2)).sum::<f64>();
    let freedom = (m - 1.0).max(FEWEST_BLOCKS as f64 - 1.0);
    let tail = normal_upper_tail(student_975(freedom) * ((freedom + 1.0) / freedom).sqrt());
    let end = |share: f64| draws[((DRAWS - 1) as f64 * share).round() as usize];
    [end(1.0 - tail), end(tail)]
}

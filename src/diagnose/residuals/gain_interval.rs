//! By how much a term lowers the error on held-out data, and whether that is significant, on the given motion.
//!
//! ```text
//!   e_before = e_after + d = β d + r          d: what the term predicts;  β = Σ d e_before / Σ d²,  1 where the prediction is right
//!   g(β) = 1 − √((R + (1 − β)² D)/(R + β² D))          R = Σ r²,  D = Σ d²
//! ```
//! The term lowers the error where `β > ½`, whatever else the model lacks. The motion, and with it `d`, are given; the random part is `r`, the
//! part of the error that the term does not change. The variance of `β` comes from the sums `z_k = Σ_k d r` over blocks that are longer than their
//! correlation. The ends of the gain's interval are `g` at the ends of the interval of `β`:
//!
//! ```text
//!   V = Σ z_k²/(1 − h_k) / D²,  h_k = D_k/D          β ± t_{0.975, f} √V,  1/f = Σ h_k² + (Σ q_k)² − Σ q_k²,  q_k = h_k²/(1 − h_k)
//! ```
//! A term with a correct prediction therefore counts as significant even if it acts in few of the blocks, but never if it acts in a single block.
//! Left out: differences between motions.
//! References: H. White (1980), A heteroskedasticity-consistent covariance matrix estimator; R. M. Bell, D. F. McCaffrey (2002), Bias
//! reduction in standard errors for linear regression with multi-stage samples (`V` and `f`, for one column).

use crate::distributions::student_975;
use crate::replay::{Gain, Pairs};

/// [s] Shortest block: longer than a smoothing kernel. Blocks are shorter where the data contain fewer than [`WANTED_BLOCKS`] of this
/// length.
const SHORTEST_BLOCK: f64 = 0.5;
/// Number of blocks in short data: twice the fewest.
const WANTED_BLOCKS: f64 = 8.0;
/// [s] Longest block: half a minute of held-out motion still has six.
const LONGEST_BLOCK: f64 = 5.0;
/// [1] Length of a block in correlation times of `d r`: the adjacent halves of two blocks then have a correlation of `e^−2.5`.
const TIMES: f64 = 5.0;
/// Least number of blocks: fewer do not show how their sums scatter.
const FEWEST_BLOCKS: usize = 4;
/// Value relative to lag zero below which a correlation counts as zero: that of some thousand rows scatters by 2 to 3 %.
const FORGOTTEN: f64 = 0.05;

/// Sums of one block.
#[derive(Debug, Clone, Copy, Default)]
struct Block {
    /// `Σ d²`
    power: f64,
    /// `Σ d r`
    score: f64,
}

/// The gain of a term from the signed errors without it (`before`) and with it (`after`).
pub fn gain(sessions: &[Pairs]) -> Gain {
    let rows = || sessions.iter().flat_map(|pairs| pairs.before.iter().zip(pairs.after));
    let (mut d_d, mut d_e, mut before, mut after) = (0.0, 0.0, 0.0, 0.0);
    for (b, a) in rows() {
        d_d += (b - a) * (b - a);
        d_e += (b - a) * b;
        before += b * b;
        after += a * a;
    }
    if before <= 0.0 || d_d <= 0.0 {
        return Gain::default();
    }
    let beta = d_e / d_d;
    let left = (before - beta * d_e).max(0.0);
    let percent = |beta: f64| {
        100.0 * (1.0 - ((left + (1.0 - beta).powi(2) * d_d) / (left + beta * beta * d_d).max(1e-300)).sqrt())
    };
    let gain_percent = 100.0 * (1.0 - (after / before).sqrt());
    let Some(wide) = half_width(sessions, beta, d_d) else {
        return Gain { gain_percent, interval_percent: [gain_percent.min(0.0), gain_percent.max(0.0)], shown: false };
    };
    let ends = [beta - wide, beta + wide];
    // If the interval contains the coefficient of the largest gain, that gain is the upper end.
    let best = 0.5 + (0.25 + left / d_d).sqrt();
    let top = best.clamp(ends[0], ends[1]);
    let low = percent(ends[0]).min(percent(ends[1]));
    Gain { gain_percent, interval_percent: [low, percent(top)], shown: low > 0.0 }
}

/// `t √V`; `None` with too few blocks.
fn half_width(sessions: &[Pairs], beta: f64, power: f64) -> Option<f64> {
    let blocks = blocks(sessions, beta);
    if blocks.len() < FEWEST_BLOCKS {
        return None;
    }
    let (mut variance, mut squares, mut q_sum, mut q_squares) = (0.0, 0.0, 0.0, 0.0);
    for block in &blocks {
        let h = block.power / power;
        let rest = (1.0 - h).max(1e-12);
        variance += block.score * block.score / rest;
        squares += h * h;
        let q = h * h / rest;
        q_sum += q;
        q_squares += q * q;
    }
    let freedom = 1.0 / (squares + q_sum * q_sum - q_squares);
    Some(student_975(freedom) * variance.sqrt() / power)
}

/// Blocks in which the term acts.
fn blocks(sessions: &[Pairs], beta: f64) -> Vec<Block> {
    let score = |before: f64, after: f64| (before - after) * (before - beta * (before - after));
    let scores: Vec<Vec<f64>> = sessions
        .iter()
        .map(|pairs| pairs.before.iter().zip(pairs.after).map(|(b, a)| score(*b, *a)).collect())
        .collect();
    let spans = sessions.iter().filter_map(|pairs| Some(pairs.time.last()? - pairs.time.first()?));
    let shortest = SHORTEST_BLOCK.min(spans.sum::<f64>() / WANTED_BLOCKS).max(1e-9);
    let length = (TIMES * correlation_time(sessions, &scores)).clamp(shortest, LONGEST_BLOCK);
    let mut blocks = Vec::new();
    for (pairs, scores) in sessions.iter().zip(&scores) {
        let Some(first) = pairs.time.first() else { continue };
        let mut number = 0;
        let mut block = Block::default();
        for (row, time) in pairs.time.iter().enumerate() {
            let own = ((time - first) / length) as usize;
            if own != number {
                blocks.push(std::mem::take(&mut block));
                number = own;
            }
            block.power += (pairs.before[row] - pairs.after[row]).powi(2);
            block.score += scores[row];
        }
        blocks.push(block);
    }
    blocks.retain(|block| block.power > 0.0);
    blocks
}

/// [s] `∫ ρ(τ) dτ` over both sides of the correlation of `d r`, up to the lag at which it counts as zero.
fn correlation_time(sessions: &[Pairs], scores: &[Vec<f64>]) -> f64 {
    let power: f64 = scores.iter().flatten().map(|score| score * score).sum();
    let count: usize = scores.iter().map(Vec::len).sum();
    let steps = sessions.iter().flat_map(|pairs| pairs.time.windows(2).map(|pair| pair[1] - pair[0]));
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    if steps.is_empty() || power <= 0.0 {
        return 0.0;
    }
    let middle = steps.len() / 2;
    // Left-out rows make longer steps; the median is the step between neighbours.
    let step = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let longest = ((LONGEST_BLOCK / TIMES / step) as usize).min(count);
    let mut sum = 1.0;
    for lag in 1..=longest {
        let mut product = 0.0;
        for (pairs, scores) in sessions.iter().zip(scores) {
            let neighbours = |i: &usize| pairs.time[*i] - pairs.time[i - lag] < (lag as f64 + 0.5) * step;
            product += (lag..scores.len()).filter(neighbours).map(|i| scores[i] * scores[i - lag]).sum::<f64>();
        }
        if product < FORGOTTEN * power {
            break;
        }
        sum += 2.0 * product / power;
    }
    sum * step
}

#[cfg(test)]
mod tests;

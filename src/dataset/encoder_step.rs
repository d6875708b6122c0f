//! The step of an encoder, found from the positions that it gave.
//!
//! ```text
//!   R(δ) = mean cos(2π Δq/δ)      over the differences Δq ≠ 0 of neighbouring samples
//! ```
//! `R` is 1 if all differences are whole multiples of `δ`, and near 0 if they are spread over many parts of it. The step is the largest `δ` that
//! makes most of them whole. A difference of one step is found among the smaller differences, wherever the motion is slow.
//! The differences of an exact position at constant speeds are whole multiples of one value as well. But there neighbouring differences
//! are equal, while a quantised position advances by different numbers of steps.
//! Steps that come from the decimals of a file are found as well: they limit a position as an encoder does.
//! Left out: encoders whose recorded positions were filtered or interpolated; no step is found there.

use std::f64::consts::TAU;

/// Fewest differences that are judged.
const FEWEST: usize = 100;
/// Most differences of a session that are judged: enough for any share below, whatever the length of the session.
const MOST: usize = 50_000;
/// Least `R`. Rounding to decimals of a fifth of a step leaves `sinc²(1/5)` = 0.87; a share `s` of spread differences leaves `1 − s`, so that
/// nine tenths have to be whole.
const WHOLE: f64 = 0.8;
/// Ranks, as shares of the ordered differences, at which a difference of one step is looked for; the first differences may come from
/// decimals, the last are of several steps.
const RANKS: [f64; 8] = [0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5];
/// Least share of neighbouring differences of different numbers of steps. At constant speeds they differ only where the speed changes.
const CHANGING: f64 = 0.1;
/// Differences below this part of the position's size come from the digits of a number, not from an encoder. Single precision has 6e-8.
const DIGITS: f64 = 2e-7;

/// Size of a step [unit of the position] in the positions of one joint in some sessions; `None` where they show none: too few
/// differences, or an exact or noisy position.
pub fn encoder_step(sessions: &[&[f64]]) -> Option<f64> {
    let moves: Vec<f64> = sessions.iter().flat_map(|position| differences(position)).collect();
    let mut sizes: Vec<f64> = moves.iter().copied().filter(|size| *size > 0.0).collect();
    if sizes.len() < FEWEST {
        return None;
    }
    sizes.sort_by(f64::total_cmp);
    let at = |rank: f64| sizes[(rank * (sizes.len() - 1) as f64) as usize];
    let steps = RANKS.iter().filter_map(|rank| refined(at(*rank), &sizes));
    let largest = steps.filter(|step| wholeness(*step, &sizes) >= WHOLE).fold(0.0, f64::max);
    (largest > 0.0 && changes(largest, &moves)).then_some(largest)
}

/// Sizes of the differences of neighbouring samples; differences that come only from digits count as zero.
fn differences(position: &[f64]) -> Vec<f64> {
    let size = position.iter().fold(0.0_f64, |most, q| most.max(q.abs()));
    let size_of = |pair: &[f64]| (pair[1] - pair[0]).abs();
    let first = position.len().saturating_sub(MOST) / 2;
    let middle = &position[first..position.len().min(first + MOST)];
    middle.windows(2).map(size_of).map(|move_| if move_ > DIGITS * size { move_ } else { 0.0 }).collect()
}

/// `R(δ)`.
fn wholeness(step: f64, sizes: &[f64]) -> f64 {
    sizes.iter().map(|size| (TAU * size / step).cos()).sum::<f64>() / sizes.len() as f64
}

/// The step near `first` that fits differences of one step, then of up to 4, 16 and 64 steps best; `None` where none fit.
fn refined(first: f64, sizes: &[f64]) -> Option<f64> {
    let mut step = first;
    for most in [1.0, 4.0, 16.0, 64.0] {
        let (mut product, mut squares) = (0.0, 0.0);
        for size in sizes {
            let whole = (size / step).round();
            if (1.0..=most).contains(&whole) && (size / step - whole).abs() < 0.25 {
                product += whole * size;
                squares += whole * whole;
            }
        }
        if squares == 0.0 {
            return None;
        }
        step = product / squares;
    }
    Some(step)
}

/// Whether neighbouring differences are different numbers of steps often enough, wherever anything moves.
fn changes(step: f64, moves: &[f64]) -> bool {
    let whole = |size: f64| (size / step).round();
    let moving = moves.windows(2).filter(|pair| pair[0] > 0.0 || pair[1] > 0.0);
    let (all, different) = moving.fold((0_usize, 0_usize), |(all, different), pair| {
        (all + 1, different + usize::from(whole(pair[0]) != whole(pair[1])))
    });
    different as f64 >= CHANGING * all as f64
}

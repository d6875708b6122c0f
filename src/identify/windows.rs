//! Steady windows: the stretches of a recording in which a joint moves at constant velocity.
//!
//! If a reference was recorded, its constant stretches are taken without the transient at their start. If none was, the position
//! alone decides: the motion is steady where the slopes over the first and the second half of a sliding window agree.
//! Both ends of a window are then moved to encoder edges, so that it holds a whole number of counts.

use super::Options;
use super::signals::Signals;

/// [s] Length of the sliding window over which a slope is taken where no reference was recorded.
const SLOPE_WINDOW: f64 = 0.4;
/// Relative change of slope that still counts as steady.
const STEADY: f64 = 0.12;
/// Part of the remaining distance, and number of counts, by which the motion may be ahead of, or behind, a motion at the final speed.
const UNSETTLED: (f64, f64) = (0.1, 3.0);
/// Fewest counts of a window: fewer do not determine a velocity.
const FEWEST_COUNTS: f64 = 8.0;

/// A steady window: samples `start..=end`, both of them first samples after an encoder edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// First sample.
    pub start: usize,
    /// Last sample.
    pub end: usize,
}

/// The steady windows of a joint in one session.
pub fn find(signals: &Signals, options: &Options) -> Vec<Window> {
    let shortest = (options.shortest_window / signals.interval).round() as usize;
    let found: Vec<Window> = match &signals.reference_velocity {
        Some(reference) => {
            let settling = (options.settling_time / signals.interval).round() as usize;
            let stretches = constant_stretches(reference).into_iter();
            stretches
                .filter_map(|(from, to)| edges(signals, from + settling.min((to - from) / 2), to))
                .map(|window| settled(signals, window))
                .collect()
        }
        // These stretches begin where the motion is already steady.
        None => steady_stretches(signals).into_iter().filter_map(|(from, to)| edges(signals, from, to)).collect(),
    };
    found
        .into_iter()
        .filter(|window| window.end - window.start >= shortest)
        .filter(|window| {
            let travel = (signals.position[window.end] - signals.position[window.start]).abs();
            travel > 0.0 && travel >= FEWEST_COUNTS * signals.count
        })
        .collect()
}

/// The window without the beginning in which the joint has not yet reached the speed of the last third: after a reversal the joint
/// stays behind until the controller pushes hard enough.
fn settled(signals: &Signals, window: Window) -> Window {
    let (x, Window { start, end }) = (signals.position, window);
    let third = signals.edge_after(end - (end - start) / 3);
    let speed = (x[end] - x[third]) / (end - third).max(1) as f64;
    let behind = |k: usize| (x[end] - x[k] - speed * (end - k) as f64).abs();
    let allowed = |k: usize| (UNSETTLED.0 * (x[end] - x[k]).abs()).max(UNSETTLED.1 * signals.count);
    let last_bad = (start..third).rev().find(|&k| behind(k) > allowed(k));
    Window { start: last_bad.map_or(start, |k| signals.edge_after(k + 1)), end }
}

/// Runs of equal, non-zero reference velocity, last sample included.
fn constant_stretches(reference: &[f64]) -> Vec<(usize, usize)> {
    let largest = reference.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let same = |a: f64, b: f64| (a - b).abs() <= 1e-6 * largest;
    let mut found = Vec::new();
    let mut from = 0;
    for k in 1..=reference.len() {
        if k == reference.len() || !same(reference[k], reference[from]) {
            if k - from > 1 && !same(reference[from], 0.0) {
                found.push((from, k - 1));
            }
            from = k;
        }
    }
    found
}

/// Runs in which the slopes of both halves of a sliding window agree.
fn steady_stretches(signals: &Signals) -> Vec<(usize, usize)> {
    let half = (0.5 * SLOPE_WINDOW / signals.interval).round() as usize;
    let n = signals.position.len();
    if half == 0 || n < 2 * half + 1 {
        return Vec::new();
    }
    let x = &signals.position;
    let is_steady = |k: usize| {
        let before = x[k] - x[k - half];
        let after = x[k + half] - x[k];
        let tolerance = 0.5 * STEADY * (before + after).abs() + 2.0 * signals.count;
        (after - before).abs() <= tolerance && (before + after).abs() > 4.0 * signals.count
    };
    let mut found = Vec::new();
    let mut from = None;
    for k in half..=n - half {
        let steady = k < n - half && is_steady(k) && from.is_none_or(|f: usize| agrees(x, f, k, half, signals.count));
        match (steady, from) {
            (true, None) => from = Some(k),
            (false, Some(f)) => {
                found.push((f, k - 1));
                from = None;
            }
            _ => {}
        }
    }
    found
}

/// Whether the slope about sample `k` still agrees with that about sample `from`: a slow drift of the speed ends a stretch.
fn agrees(x: &[f64], from: usize, k: usize, half: usize, count: f64) -> bool {
    let there = x[from + half] - x[from - half];
    let here = x[k + half] - x[k - half];
    (here - there).abs() <= STEADY * there.abs() + 3.0 * count
}

/// Moves both ends inwards to samples at which the position has just changed; not needed for exact positions.
fn edges(signals: &Signals, from: usize, to: usize) -> Option<Window> {
    if signals.count == 0.0 {
        return (to > from).then_some(Window { start: from, end: to });
    }
    let changes = |k: &usize| signals.position[*k] != signals.position[*k - 1];
    let start = (from.max(1)..=to).find(changes)?;
    let end = (start + 1..=to).rev().find(changes)?;
    Some(Window { start, end })
}

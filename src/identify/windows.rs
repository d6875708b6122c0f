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
/// [s] Of the remaining distance counts at most that of the last second, the length of a step of the paper's staircase: a joint that stuck for half a
/// second at the start of a long window is not steady because the window is long.
const REMAINING: f64 = 1.0;
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
    let clock = &signals.clock;
    let found: Vec<Window> = match &signals.reference_velocity {
        Some(reference) => {
            let stretches = constant_stretches(reference).into_iter();
            stretches
                .filter_map(|(from, to)| {
                    let settled = clock.after(from, options.settling_time).min(from + (to - from) / 2);
                    edges(signals, settled, to)
                })
                .map(|window| settled(signals, window))
                .collect()
        }
        // These stretches begin where the motion is already steady.
        None => steady_stretches(signals).into_iter().filter_map(|(from, to)| edges(signals, from, to)).collect(),
    };
    found
        .into_iter()
        .filter(|window| window.end >= clock.after(window.start, options.shortest_window))
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
    let time = |from: usize| signals.clock.elapsed(from, end);
    let speed = if third < end { (x[end] - x[third]) / time(third) } else { 0.0 };
    let behind = |k: usize| (x[end] - x[k] - speed * time(k)).abs();
    let remaining = |k: usize| (x[end] - x[k]).abs().min(speed.abs() * REMAINING);
    let allowed = |k: usize| (UNSETTLED.0 * remaining(k)).max(UNSETTLED.1 * signals.count);
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
    let slopes = Slopes { signals, half: 0.5 * SLOPE_WINDOW };
    let inner = slopes.inner();
    let mut found = Vec::new();
    let mut from = None;
    for k in inner.start..=inner.end {
        let steady = k < inner.end && slopes.steady(k) && from.is_none_or(|f: usize| slopes.agree(f, k));
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

/// Ways of a sliding window [rad or m].
struct Slopes<'a> {
    signals: &'a Signals<'a>,
    /// [s] Half of the window.
    half: f64,
}

impl Slopes<'_> {
    /// The samples with a half window on either side.
    fn inner(&self) -> std::ops::Range<usize> {
        let (clock, n) = (&self.signals.clock, self.signals.position.len());
        if n < 3 || clock.after(0, self.half) == 0 {
            return 0..0;
        }
        let first = clock.after(0, self.half);
        let end = clock.before(n - 1, self.half) + 1;
        first..end.max(first)
    }

    /// Ways of the halves before and after a sample, each as long as the half at its mean speed.
    fn ways(&self, k: usize) -> [f64; 2] {
        let (x, clock) = (self.signals.position, &self.signals.clock);
        let way = |from: usize, to: usize| {
            let way = x[to] - x[from];
            if clock.even { way } else { way * self.half / clock.elapsed(from, to) }
        };
        [way(clock.before(k, self.half), k), way(k, clock.after(k, self.half).min(x.len() - 1))]
    }

    /// Whether the slopes of both halves about a sample agree.
    fn steady(&self, k: usize) -> bool {
        let [before, after] = self.ways(k);
        let tolerance = 0.5 * STEADY * (before + after).abs() + 2.0 * self.signals.count;
        (after - before).abs() <= tolerance && (before + after).abs() > 4.0 * self.signals.count
    }

    /// Whether the slope about sample `k` still agrees with that about sample `from`: a slow drift of the speed ends a stretch.
    fn agree(&self, from: usize, k: usize) -> bool {
        let [there, here] = [from, k].map(|k| self.ways(k).iter().sum::<f64>());
        (here - there).abs() <= STEADY * there.abs() + 3.0 * self.signals.count
    }
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

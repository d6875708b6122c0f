//! A pattern in time: an oscillation at one frequency, whatever the motion, with a phase of its own in every session.
//!
//! `τ = Σ_s (c_s cos ωt + d_s sin ωt)`, one pair for each session `s`, because recordings start at any phase. Tried between [`LOWEST`] and [`HIGHEST`],
//! below the frequencies of lines that are measured on unsmoothed torque. A frequency at which the motion itself has power is not tried: what
//! the model lacks there repeats with the motion, and is not tied to time.
//! Left out: amplitudes that change within a session.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

use rayon::prelude::*;

use crate::diagnose::fit::problem::{Fitted, Part, Problem};
use crate::effects::{About, Action, Diagnosable, Effect, Kind, Motion, Scope, kernel_gain};
use crate::error::Result;
use crate::identify::statistics::median;
use crate::robot::Model;

/// [Hz] Below it drifts and slow motion have their power; above it lines are measured on unsmoothed torque.
const LOWEST: f64 = 0.3;
const HIGHEST: f64 = 10.0;
/// Number of periods that a session has to last.
const PERIODS: f64 = 10.0;
/// Neighbours on either side that give the level of a spectrum, and those next to a line, over which a window spreads it.
const AROUND: usize = 16;
const FOOT: usize = 2;
/// Power over the level, relative to that in any signal of the motion at the same frequency, above which a line is tied to time. Zones in which no
/// row counts give every signal some power at every frequency.
const BEYOND_MOTION: f64 = 2.0;
/// Frequencies per resolution that are tried around the best one; between two of them the phase drifts by π/8 at most.
const FINE: usize = 8;
/// Part of the torque that the kernel of the rows lets pass, at least.
const PASSED: f64 = 0.5;

static ABOUT: About = About {
    name: "oscillation",
    summary: "A residual at one frequency in time.",
    equation: "τ = Σ_s (c_s cos ωt + d_s sin ωt)",
    kind: Kind::Physics,
    scope: Scope::Joint,
    parameters: &[],
    signature: "",
    look_alikes: &[],
    separate_by: "",
    reference: "",
};

/// An oscillation; its frequency [Hz] is the first entry of the shape.
pub struct Oscillation;

impl Effect for Oscillation {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn install(&self, _: &mut Model, _: Option<usize>, _: &BTreeMap<String, f64>) -> Result<Vec<Action>> {
        Ok(Vec::new())
    }
}

impl Diagnosable for Oscillation {
    fn columns(&self, motion: &Motion, _: usize, shape: &[f64]) -> Vec<Vec<f64>> {
        let of_session = |session: usize| {
            let value = |wave: fn(f64) -> f64| -> Vec<f64> {
                let in_row = |row: usize| match motion.session[row] == session {
                    true => wave(TAU * shape[0] * motion.since_start(row)),
                    false => 0.0,
                };
                (0..motion.rows()).map(in_row).collect()
            };
            [value(f64::cos), value(f64::sin)]
        };
        (0..motion.sessions).flat_map(of_session).collect()
    }

    fn parameters(&self, _: &Motion, _: usize, _: &[f64], _: &[f64]) -> Vec<f64> {
        Vec::new()
    }
}

/// The strongest oscillation in the residual of a loose fit: its frequency [Hz], and the number of independent frequencies that were tried.
/// `None` where no session is long enough, or everything belongs to the motion.
pub fn strongest(problem: &Problem, fitted: &Fitted, joint: usize) -> Option<(f64, usize)> {
    let motion = &problem.motion;
    let rows = problem.rows(joint, Part::Train);
    let longest = sessions(motion, &rows).map(|rows| duration(motion, rows)).fold(0.0, f64::max);
    let width = rows.iter().map(|row| motion.half_width[*row]).fold(0.0, f64::max);
    let lowest = LOWEST.max(PERIODS / longest.max(1e-9));
    let step = 1.0 / longest.max(1e-9);
    let count = ((HIGHEST.min(kernel_limit(width)) - lowest) / step).max(0.0) as usize;
    let grid = Grid { lowest, step, count };
    let solution = &fitted.solution;
    let weighted: Vec<f64> = solution.residual[joint]
        .iter()
        .zip(&solution.weights[joint])
        .map(|(residual, weight)| residual * weight)
        .collect();
    let power = grid.power(motion, &rows, &weighted);
    let of_motion = prominence_in_motion(motion, &rows, &grid);
    let tied_to_time = |k: &usize| prominence(&power, *k) > BEYOND_MOTION * of_motion[*k];
    let best = (0..count).filter(tied_to_time).max_by(|a, b| power[*a].total_cmp(&power[*b]))?;
    let fine = Grid { lowest: grid.frequency(best) - step, step: step / FINE as f64, count: 2 * FINE + 1 };
    let power = fine.power(motion, &rows, &weighted);
    let best = (0..fine.count).max_by(|a, b| power[*a].total_cmp(&power[*b]))?;
    Some((fine.frequency(best), count))
}

/// At each frequency the largest [`prominence`] of a signal of the motion there or next to it.
fn prominence_in_motion(motion: &Motion, rows: &[usize], grid: &Grid) -> Vec<f64> {
    let mut largest = vec![0.0_f64; grid.count];
    for signal in motion.joints.iter().flat_map(|m| [&m.v, &m.a, &m.direction, &m.rigid]) {
        let values: Vec<f64> = rows.iter().map(|row| signal[*row]).collect();
        let power = grid.power(motion, rows, &values);
        let found: Vec<f64> = (0..grid.count).map(|k| prominence(&power, k)).collect();
        for (k, largest) in largest.iter_mut().enumerate() {
            let near = k.saturating_sub(1)..(k + 2).min(grid.count);
            *largest = found[near].iter().fold(*largest, |most, found| most.max(*found));
        }
    }
    largest
}

/// Power relative to the median of its neighbours.
fn prominence(power: &[f64], k: usize) -> f64 {
    let around = k.saturating_sub(AROUND)..(k + AROUND + 1).min(power.len());
    let beside: Vec<f64> = around.filter(|other| other.abs_diff(k) > FOOT).map(|other| power[other]).collect();
    if beside.is_empty() { 0.0 } else { power[k] / median(beside).max(1e-300) }
}

/// [Hz] Frequency up to which the kernel passes [`PASSED`].
fn kernel_limit(width: f64) -> f64 {
    let mut x = 0.1;
    while kernel_gain(x) > PASSED {
        x += 0.05;
    }
    x / (TAU * width.max(1e-9))
}

/// Rows of each session; rows are in the order of sessions.
fn sessions<'r>(motion: &'r Motion, rows: &'r [usize]) -> impl Iterator<Item = &'r [usize]> {
    rows.chunk_by(|a, b| motion.session[*a] == motion.session[*b])
}

/// [s] Time between the first and the last row.
fn duration(motion: &Motion, rows: &[usize]) -> f64 {
    rows.first().zip(rows.last()).map_or(0.0, |(first, last)| motion.time[*last] - motion.time[*first])
}

/// Frequencies `lowest + k step` [Hz].
struct Grid {
    lowest: f64,
    step: f64,
    count: usize,
}

impl Grid {
    /// [Hz]
    fn frequency(&self, k: usize) -> f64 {
        self.lowest + self.step * k as f64
    }

    /// `Σ_s |Σ w x e^{−iωt}|²/Σ w²` over the sessions, with a Hann window `w` over each.
    fn power(&self, motion: &Motion, rows: &[usize], values: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.count];
        let mut first = 0;
        for session in sessions(motion, rows) {
            let of_session = &values[first..first + session.len()];
            first += session.len();
            let (windowed, total) = windowed(motion, session, of_session);
            let part = |range: Range<usize>| -> Vec<f64> { self.transform(range, &windowed) };
            let parts: Vec<Range<usize>> =
                (0..self.count).step_by(PART).map(|k| k..(k + PART).min(self.count)).collect();
            let powers: Vec<f64> = parts.into_par_iter().flat_map_iter(part).collect();
            sums.iter_mut().zip(powers).for_each(|(sum, power)| *sum += power / total.max(1e-300));
        }
        sums
    }

    /// `|Σ x e^{−iωt}|²` of some of the frequencies, from times and values.
    fn transform(&self, range: Range<usize>, samples: &[(f64, f64)]) -> Vec<f64> {
        let mut sums = vec![[0.0; 2]; range.len()];
        let lowest = self.frequency(range.start);
        for (t, x) in samples {
            // Rotate from one frequency to the next instead of computing a sine each time.
            let (sin, cos) = (TAU * self.step * t).sin_cos();
            let (s, c) = (TAU * lowest * t).sin_cos();
            let (mut re, mut im) = (x * c, x * s);
            for sum in &mut sums {
                sum[0] += re;
                sum[1] += im;
                (re, im) = (re * cos - im * sin, re * sin + im * cos);
            }
        }
        sums.iter().map(|[re, im]| re * re + im * im).collect()
    }
}

/// Number of frequencies that one thread sums.
const PART: usize = 512;

/// Times since the start of the session and values times a Hann window over the rows, and `Σ w²`.
fn windowed(motion: &Motion, rows: &[usize], values: &[f64]) -> (Vec<(f64, f64)>, f64) {
    let span = duration(motion, rows).max(1e-9);
    let start = rows.first().map_or(0.0, |row| motion.since_start(*row));
    let weight = |row: usize| (PI * (motion.since_start(row) - start) / span).sin().powi(2);
    let samples = rows.iter().zip(values).map(|(row, x)| (motion.since_start(*row), weight(*row) * x)).collect();
    (samples, rows.iter().map(|row| weight(*row).powi(2)).sum())
}

//! A pattern in time: an oscillation at one frequency, whatever the motion, with a phase of its own in every session.
//!
//! `τ = Σ_s (c_s cos ωt + d_s sin ωt)`, one pair for each session `s`, because recordings start at any phase. Tried between [`LOWEST`] and [`HIGHEST`],
//! below the frequencies of lines that are measured on unsmoothed torque. A frequency at which the motion itself has power is not tried: what
//! the model lacks there repeats with the motion, and is not tied to time.
//! Left out: amplitudes that change within a session.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use nalgebra::Complex;
use rayon::prelude::*;

use crate::diagnose::fit::problem::{Fitted, Part, Problem};
use crate::effects::{About, Action, Diagnosable, Effect, Kind, Motion, Scope, kernel_gain};
use crate::error::Result;
use crate::fourier::{Uneven, of_pair};
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
    let step = 1.0 / longest.max(1e-9);
    let first = (LOWEST / step).max(PERIODS).ceil() as usize;
    let last = (HIGHEST.min(kernel_limit(width)) / step) as usize;
    let grid = Grid { first, count: (last + 1).saturating_sub(first), step };
    let solution = &fitted.solution;
    let weighted: Vec<f64> = solution.residual[joint]
        .iter()
        .zip(&solution.weights[joint])
        .map(|(residual, weight)| residual * weight)
        .collect();
    let spectra = grid.spectra(motion, &rows);
    let power = spectra.power(&[&weighted]).swap_remove(0);
    let of_motion = prominence_in_motion(motion, &rows, &spectra);
    let tied_to_time = |k: &usize| prominence(&power, *k) > BEYOND_MOTION * of_motion[*k];
    let best = (0..grid.count).filter(tied_to_time).max_by(|a, b| power[*a].total_cmp(&power[*b]))?;
    let near = (-(FINE as i32)..=FINE as i32).map(|k| grid.frequency(best) + step * f64::from(k) / FINE as f64);
    let (best, _) = near.map(|f| (f, power_at(motion, &rows, &weighted, f))).max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((best, grid.count))
}

/// At each frequency the largest [`prominence`] of a signal of the motion there or next to it.
fn prominence_in_motion(motion: &Motion, rows: &[usize], spectra: &Spectra) -> Vec<f64> {
    let signals: Vec<&Vec<f64>> = motion.joints.iter().flat_map(|m| [&m.v, &m.a, &m.direction, &m.rigid]).collect();
    let found = |pair: &[&Vec<f64>]| -> Vec<Vec<f64>> {
        let values: Vec<Vec<f64>> = pair.iter().map(|signal| rows.iter().map(|row| signal[*row]).collect()).collect();
        let powers = spectra.power(&values.iter().map(|values| &values[..]).collect::<Vec<_>>());
        powers.iter().map(|power| (0..power.len()).map(|k| prominence(power, k)).collect()).collect()
    };
    let found: Vec<Vec<f64>> = signals.par_chunks(2).flat_map_iter(found).collect();
    let most = |k: usize| {
        let near = k.saturating_sub(1)..(k + 2).min(spectra.grid.count);
        found.iter().flat_map(|found| &found[near.clone()]).fold(0.0, |most: f64, found| most.max(*found))
    };
    (0..spectra.grid.count).map(most).collect()
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

/// Frequencies `(first + k) step` [Hz].
#[derive(Clone, Copy)]
struct Grid {
    first: usize,
    count: usize,
    step: f64,
}

impl Grid {
    /// [Hz]
    fn frequency(self, k: usize) -> f64 {
        self.step * (self.first + k) as f64
    }

    /// Prepares the spectra of signals of these rows.
    fn spectra(self, motion: &Motion, rows: &[usize]) -> Spectra {
        let of_session = |session: &[usize]| {
            let (times, weights) = windowed(motion, session);
            (Uneven::new(&times, self.step, 2 * (self.first + self.count)), weights)
        };
        Spectra { grid: self, sessions: sessions(motion, rows).map(of_session).collect() }
    }
}

/// Spectra of signals of the same rows.
struct Spectra {
    grid: Grid,
    /// Of each session its transform and the window's weights.
    sessions: Vec<(Uneven, Vec<f64>)>,
}

impl Spectra {
    /// `Σ_s |Σ w x e^{−iωt}|²/Σ w²` over the sessions, with a Hann window `w` over each, of one signal or of two.
    fn power(&self, signals: &[&[f64]]) -> Vec<Vec<f64>> {
        let Grid { first, count, .. } = self.grid;
        let mut powers = vec![vec![0.0; count]; signals.len()];
        let mut from = 0;
        for (transform, weights) in &self.sessions {
            let value = |signal: usize, row: usize| signals.get(signal).map_or(0.0, |values| values[from + row]);
            let samples = weights.iter().enumerate().map(|(row, w)| Complex::new(value(0, row), value(1, row)) * *w);
            let z = transform.transform(samples);
            let total = weights.iter().map(|w| w * w).sum::<f64>().max(1e-300);
            for k in 0..count {
                let pair = of_pair(&z, first + k);
                powers.iter_mut().zip(pair).for_each(|(power, x)| power[k] += x.norm_sqr() / total);
            }
            from += weights.len();
        }
        powers
    }
}

/// `Σ_s |Σ w x e^{−iωt}|²/Σ w²` at one frequency [Hz].
fn power_at(motion: &Motion, rows: &[usize], values: &[f64], frequency: f64) -> f64 {
    let mut rest = values;
    let of_session = |session: &[usize]| {
        let (times, weights) = windowed(motion, session);
        let values = rest.split_off(..session.len()).unwrap_or_default();
        let turned = |((t, w), x): ((&f64, &f64), &f64)| Complex::from_polar(w * x, -TAU * frequency * t);
        let sum: Complex<f64> = times.iter().zip(&weights).zip(values).map(turned).sum();
        sum.norm_sqr() / weights.iter().map(|w| w * w).sum::<f64>().max(1e-300)
    };
    sessions(motion, rows).map(of_session).sum()
}

/// Times since the start of the session, and a Hann window over the rows.
fn windowed(motion: &Motion, rows: &[usize]) -> (Vec<f64>, Vec<f64>) {
    let span = duration(motion, rows).max(1e-9);
    let times: Vec<f64> = rows.iter().map(|row| motion.since_start(*row)).collect();
    let start = times.first().copied().unwrap_or(0.0);
    let weights = times.iter().map(|t| (PI * (t - start) / span).sin().powi(2)).collect();
    (times, weights)
}

//! The paper's uniform staircase of the same length, for comparison: what it is expected to measure.
//!
//! Speeds are equidistant from a twentieth of the fastest on, twenty of them where each can be steady for 0.8 s, else as many as can, and
//! at least five. Each is passed in both directions, with a reversal after every speed; those up to 0.3 of the fastest brake gently.

use super::information::{Sensing, SteadyWindow};
use super::strokes::{PER_RECORDING, Strokes};
use super::sweep::{Bounds, LAG, SLOWEST};
use crate::identify::Options;

/// Numbers of speeds: the paper's, and fewer down to what an identification needs.
const SPEEDS: [usize; 5] = [20, 15, 10, 7, 5];
/// [s] Least steady time.
const STEADY: f64 = 0.8;
/// Part of the speeds that brake gently.
const GENTLE: f64 = 0.3;

/// A uniform staircase.
#[derive(Debug, Clone, PartialEq)]
pub struct Uniform {
    /// Its windows in one direction.
    pub windows: Vec<SteadyWindow>,
    /// Reversals that show the gap.
    pub reversals: usize,
}

/// The staircase that takes `seconds`; `None` if not even five speeds fit.
pub fn of(bounds: &Bounds, sensing: &Sensing, strokes: &Strokes, seconds: f64) -> Option<Uniform> {
    SPEEDS.into_iter().find_map(|number| with(bounds, sensing, strokes, seconds, number))
}

fn with(bounds: &Bounds, sensing: &Sensing, strokes: &Strokes, seconds: f64, number: usize) -> Option<Uniform> {
    let slowest = SLOWEST * bounds.fastest;
    let speed = |k: usize| slowest + (bounds.fastest - slowest) * k as f64 / (number - 1) as f64;
    let gentle = |speed: f64| speed <= GENTLE * bounds.fastest;
    let braking = |speed: f64| if gentle(speed) { strokes.acceleration } else { bounds.acceleration };
    let lag = |speed: f64| LAG * bounds.lag / speed;
    let fixed: f64 = (0..number).map(speed).map(|v| 2.0 * (lag(v) + v / bounds.acceleration + v / braking(v))).sum();
    let steady = (seconds - fixed) / (2.0 * number as f64);
    let longest = Options::default().settling_time;
    // The lag, or else what the identification leaves out: 0.6 s or half of the step.
    let window = |v: f64| steady + lag(v) - lag(v).max(longest.min(0.5 * (steady + lag(v))));
    let windows: Vec<SteadyWindow> =
        (0..number).map(speed).map(|speed| SteadyWindow { speed, time: window(speed) }).collect();
    let long = steady >= STEADY && windows.iter().all(|one| one.speed * one.time >= 8.0 * sensing.count);
    let reversals = (2 * (0..number).filter(|&k| gentle(speed(k))).count()).min(PER_RECORDING);
    long.then_some(Uniform { windows, reversals })
}

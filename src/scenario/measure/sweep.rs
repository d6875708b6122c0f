//! Speeds and dwells of a sweep: a joint passes them in one direction, slowest first, and comes back in the other.
//!
//! ```text
//!   q̇_d                     ____
//!                     ____/    \                time of a sweep:  Σ (s_i + T_i) + ramps
//!            ______/           \                s_1 = 1.3 l/v_1, at least 0.6 s: the lag l is taken up
//!     _____/                     \              s_i = 0.6 s: what the identification leaves out after a change of speed
//! ```
//! Only the first speed of a sweep follows a reversal. The order is ascending: when a joint slows down, its link runs ahead through the gap,
//! and the next window is lost (in simulated sweeps of scenario 01's arm with falling speeds, a third of the windows was off by more than ten
//! standard errors; with rising speeds, none).
//!
//! The plan starts from equal dwells at speeds that are equidistant on a logarithmic grid. Then it exchanges: a speed moves to a
//! neighbour on the grid, or a piece of time from one dwell to another, whenever this lowers the criterion, until no exchange does; the
//! pieces become smaller twice. The number of speeds and of repeated sweeps is tried out. Everything is deterministic.

use super::information::{Possible, Sensing, SteadyWindow};
use crate::identify::Options;

/// Speeds of the grid.
const GRID: usize = 33;
/// Slowest speed, as a part of the fastest: that of the paper's staircase. Below it, friction that falls with speed makes a joint stick and
/// slip.
pub const SLOWEST: f64 = 0.05;
/// Numbers of speeds that are tried. With fewer windows than eight in each direction the identification's robust weights may settle on a law that
/// passes through most of them exactly and drop the others; six are for short budgets.
const SPEEDS: [usize; 4] = [12, 10, 8, 6];
/// Fewest speeds as soon as the budget allows them.
const ENOUGH: usize = 8;
/// [s] Shortest window.
const SHORTEST: f64 = 0.6;
/// [counts] Least way of a window: an identification needs eight.
const LEAST_WAY: f64 = 10.0;
/// Factor on the time `l/v` that the lag takes at the first speed.
pub const LAG: f64 = 1.3;
/// Most sweeps in each direction.
const MOST_SWEEPS: usize = 24;
/// Part of the room that the shortest sweep may fill.
const FILLED: f64 = 0.7;
/// Pieces of time that are exchanged, as parts of the time that can be exchanged.
const PIECES: [f64; 3] = [0.05, 0.015, 0.005];
/// Least gain in the criterion for which an exchange is made.
const LEAST_GAIN: f64 = 1e-6;

/// What bounds the sweeps of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// [rad/s or m/s] Fastest speed.
    pub fastest: f64,
    /// [rad/s² or m/s²] With which speed grows, and falls at the end of a sweep.
    pub acceleration: f64,
    /// [rad or m] Farthest way of a sweep.
    pub room: f64,
    /// `l` [rad or m] distance by which the joint lags when it reverses.
    pub lag: f64,
}

/// One sweep, slowest speed first.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// The windows that it gives.
    pub windows: Vec<SteadyWindow>,
    /// [s] For which each speed is constant.
    pub durations: Vec<f64>,
    /// Number of sweeps in each direction.
    pub repeats: usize,
    /// The criterion: mean of `ln var` over the coefficients.
    pub criterion: f64,
}

impl Sweep {
    /// [s] Of all sweeps, both directions.
    pub fn time(&self, bounds: &Bounds) -> f64 {
        2.0 * self.repeats as f64
            * (self.durations.iter().sum::<f64>() + ramps(bounds, self.windows[self.windows.len() - 1].speed))
    }

    /// [rad or m] Way of a sweep.
    pub fn way(&self, bounds: &Bounds) -> f64 {
        way(bounds, self.windows.iter().zip(&self.durations).map(|(window, duration)| (window.speed, *duration)))
    }
}

/// [s] In which speed grows to the fastest of a sweep, and falls to rest.
fn ramps(bounds: &Bounds, fastest: f64) -> f64 {
    2.0 * fastest / bounds.acceleration
}

/// [rad or m] Way of a sweep with these speeds and durations.
fn way(bounds: &Bounds, steps: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut way, mut fastest) = (0.0, 0.0);
    for (speed, duration) in steps {
        way += speed * duration;
        fastest = speed;
    }
    way + fastest * fastest / bounds.acceleration
}

/// Plans sweeps that take at most `seconds`; `None` if the shortest ones take longer.
pub fn plan(possible: &Possible, sensing: &Sensing, bounds: &Bounds, seconds: f64) -> Option<Sweep> {
    let best = |few: bool| {
        let numbers = SPEEDS.into_iter().filter(|number| (*number < ENOUGH) == few);
        numbers
            .filter_map(|number| of_number(possible, sensing, bounds, seconds, number))
            .min_by(|a, b| a.criterion.total_cmp(&b.criterion))
    };
    best(false).or_else(|| best(true))
}

/// The best plan with this number of speeds: more sweeps than fill the room do not help.
fn of_number(possible: &Possible, sensing: &Sensing, bounds: &Bounds, seconds: f64, number: usize) -> Option<Sweep> {
    let mut best: Option<Sweep> = None;
    for repeats in 1..=MOST_SWEEPS {
        let search = Search { possible, sensing, bounds, time: seconds / (2.0 * repeats as f64), repeats };
        let Some(found) = search.run(number) else { continue };
        if best.as_ref().is_some_and(|best| best.criterion <= found.criterion) {
            break;
        }
        best = Some(found);
    }
    best
}

/// Speeds and durations of the shortest sweep.
fn least(sensing: &Sensing, bounds: &Bounds) -> impl Iterator<Item = (f64, f64)> {
    let speeds = spread(&grid(bounds.fastest), SPEEDS[SPEEDS.len() - 1]);
    let step = |(k, v): (usize, f64)| (v, settling(bounds, k, v) + least_window(sensing, v));
    speeds.into_iter().enumerate().map(step)
}

/// [s] The shortest sweeps, there and back.
pub fn shortest(sensing: &Sensing, bounds: &Bounds) -> f64 {
    let steady: f64 = least(sensing, bounds).map(|(_, duration)| duration).sum();
    2.0 * (steady + ramps(bounds, bounds.fastest))
}

/// Whether the shortest sweep fits the room with a margin, such that there is a choice of speeds and dwells.
pub fn fits(sensing: &Sensing, bounds: &Bounds) -> bool {
    way(bounds, least(sensing, bounds)) <= FILLED * bounds.room
}

/// [s] After a change of speed before the motion counts as steady.
fn settling(bounds: &Bounds, position: usize, speed: f64) -> f64 {
    let usual = Options::default().settling_time;
    if position == 0 { usual.max(LAG * bounds.lag / speed) } else { usual }
}

/// [s] Shortest window at a speed.
fn least_window(sensing: &Sensing, speed: f64) -> f64 {
    SHORTEST.max(LEAST_WAY * sensing.count / speed)
}

/// Speeds that a plan may use.
fn grid(fastest: f64) -> Vec<f64> {
    (0..GRID).map(|k| fastest * SLOWEST.powf(1.0 - k as f64 / (GRID - 1) as f64)).collect()
}

/// Equidistant elements, the upper part of the grid with the fewest speeds.
fn spread(grid: &[f64], number: usize) -> Vec<f64> {
    (0..number).map(|k| grid[start_of(number) + k * (grid.len() - 1 - start_of(number)) / (number - 1)]).collect()
}

/// Where the first plan begins on the grid: at the slowest speed, or where the budget is short at a third of it.
const fn start_of(number: usize) -> usize {
    if number < ENOUGH { GRID / 3 } else { 0 }
}

/// The exchanges for one number of sweeps.
struct Search<'a> {
    possible: &'a Possible,
    sensing: &'a Sensing,
    bounds: &'a Bounds,
    /// [s] Of one sweep.
    time: f64,
    repeats: usize,
}

/// Indices on the grid, ascending, and the lengths of the windows [s].
type Plan = (Vec<usize>, Vec<f64>);

impl Search<'_> {
    fn run(&self, number: usize) -> Option<Sweep> {
        let grid = grid(self.bounds.fastest);
        let first = start_of(number);
        let places: Vec<usize> = (0..number).map(|k| first + k * (GRID - 1 - first) / (number - 1)).collect();
        let mut plan = self.fitted(&grid, places, &vec![1.0; number])?;
        let mut value = self.value(&grid, &plan);
        for piece in PIECES {
            while let Some((better, found)) = self.exchange(&grid, &plan, value, piece) {
                (plan, value) = (better, found);
            }
        }
        let windows: Vec<SteadyWindow> =
            plan.0.iter().zip(&plan.1).map(|(&place, &time)| SteadyWindow { speed: grid[place], time }).collect();
        let durations = (windows.iter().enumerate())
            .map(|(k, window)| settling(self.bounds, k, window.speed) + window.time)
            .collect();
        Some(Sweep { windows, durations, repeats: self.repeats, criterion: value })
    }

    fn value(&self, grid: &[f64], (places, times): &Plan) -> f64 {
        let windows: Vec<SteadyWindow> =
            places.iter().zip(times).map(|(&place, &time)| SteadyWindow { speed: grid[place], time }).collect();
        self.possible.criterion(self.sensing, &windows, self.repeats as f64)
    }

    /// The first exchange that is found to be better.
    fn exchange(&self, grid: &[f64], (places, times): &Plan, value: f64, piece: f64) -> Option<(Plan, f64)> {
        let better = |plan: Plan| {
            let found = self.value(grid, &plan);
            (found < value - LEAST_GAIN).then_some((plan, found))
        };
        let spare = self.spare(grid, places, times);
        for from in 0..places.len() {
            for step in [-2_isize, -1, 1, 2] {
                let Some(place) = places[from].checked_add_signed(step).filter(|place| *place < grid.len()) else {
                    continue;
                };
                let mut moved = places.clone();
                moved[from] = place;
                if moved.windows(2).all(|two| two[0] < two[1])
                    && let Some(found) = self.fitted(grid, moved, &spare).and_then(better)
                {
                    return Some(found);
                }
            }
            for to in (0..places.len()).filter(|to| *to != from) {
                let mut shifted = spare.clone();
                let moved = (piece * spare.iter().sum::<f64>()).min(spare[from]);
                shifted[from] -= moved;
                shifted[to] += moved;
                if moved > 0.0
                    && let Some(found) = self.fitted(grid, places.clone(), &shifted).and_then(better)
                {
                    return Some(found);
                }
            }
        }
        None
    }

    /// Time of every window beyond the shortest [s].
    fn spare(&self, grid: &[f64], places: &[usize], times: &[f64]) -> Vec<f64> {
        places
            .iter()
            .zip(times)
            .map(|(&place, time)| (time - least_window(self.sensing, grid[place])).max(0.0))
            .collect()
    }

    /// The plan with these speeds whose spare times have the given proportions and fill the time of a sweep; less where the room ends.
    /// `None` if the shortest windows need more time or room.
    fn fitted(&self, grid: &[f64], places: Vec<usize>, spare: &[f64]) -> Option<Plan> {
        let speeds = || places.iter().map(|&place| grid[place]);
        let least: Vec<f64> = speeds().map(|speed| least_window(self.sensing, speed)).collect();
        let settled: Vec<f64> = speeds().enumerate().map(|(k, speed)| settling(self.bounds, k, speed)).collect();
        let fastest = grid[places[places.len() - 1]];
        let used = least.iter().chain(&settled).sum::<f64>() + ramps(self.bounds, fastest);
        let least_way = way(self.bounds, speeds().zip(least.iter().zip(&settled).map(|(a, b)| a + b)));
        if used > self.time || least_way > self.bounds.room {
            return None;
        }
        let total: f64 = spare.iter().sum();
        if total <= 0.0 {
            return Some((places, least));
        }
        let by_time = (self.time - used) / total;
        let by_way =
            (self.bounds.room - least_way) / speeds().zip(spare).map(|(speed, spare)| speed * spare).sum::<f64>();
        let factor = by_time.min(by_way);
        let times = least.iter().zip(spare).map(|(least, spare)| least + factor * spare).collect();
        Some((places, times))
    }
}

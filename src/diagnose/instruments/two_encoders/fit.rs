//! Delay, wind-up and gap of one joint from its two encoders: a robust regression with errors that may be correlated within a second.

use super::difference::{Difference, difference};
use super::flanks::flanks;
use super::solved::{Regression, Solved, solve};
use super::wave::{Wave, wave};
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::regression::{Block, System};
use crate::timeseries::root_mean_square;
use crate::timeseries::{Estimate, TimeSeries};

/// Number of iterations of the lag and of the friction before the gear; each reduces the remaining error to a few per cent.
const STEPS: usize = 6;
/// [1] Share of friction before the gear where it is unknown, and its standard error.
const SHARE_BEFORE: [f64; 2] = [0.75, 0.25];

/// Knowledge of the lag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lag {
    /// Unknown: it is fitted.
    Free,
    /// [s] Known; friction before the gear may still grow with speed where the load contains it.
    Known(f64),
    /// Taken as 0, and no other term grows with speed.
    Ignored,
}

/// Results of the two encoders of a joint.
#[derive(Debug, Clone)]
pub struct AxisFit {
    /// Index of the joint.
    pub joint: usize,
    /// [s] Delay of the link's encoder.
    pub lag: Estimate,
    /// `1/k` [rad/(N·m) or m/N].
    pub wind_up: Estimate,
    /// Total gap [rad or m]; `None` where the load stays on one flank.
    pub gap: Option<Estimate>,
    /// [rad or m] Change of the encoders' difference after a reversal of the motion, beyond the effect of friction before the gear;
    /// only where the load contains that friction.
    pub lost: Option<Estimate>,
    /// [1] Share of the squared difference of the encoders that a lag alone explains.
    pub explained: f64,
    /// Variation of the gap, where an order was given.
    pub wave: Option<Wave>,
    /// Friction before the gear [N·m or N] as found.
    friction: f64,
    /// Coefficients of lag (if fitted), load, side (if present), direction (if used), and the two of the wave.
    coefficients: Vec<f64>,
    layout: Layout,
}

/// Columns that come before those of the mounting.
#[derive(Debug, Clone, Copy)]
struct Layout {
    speed: bool,
    side: bool,
    direction: bool,
    order: Option<f64>,
}

impl Layout {
    /// Position of the coefficient of the load; that of the lag stands before it, where it is free.
    fn load(self) -> usize {
        usize::from(self.speed)
    }

    /// Position of the coefficient of the side, where it has one.
    fn flank(self) -> usize {
        self.load() + 1
    }

    /// Position of the coefficient of the direction, where it has one.
    fn way(self) -> usize {
        self.flank() + usize::from(self.side)
    }

    fn columns(self, rows: &Difference, friction: f64) -> Vec<Vec<f64>> {
        let mut columns = Vec::new();
        if self.speed {
            columns.push(rows.v.clone());
        }
        columns.push(rows.load.clone());
        if self.side {
            columns.push(rows.side(friction).iter().map(|side| 0.5 * side).collect());
        }
        if self.direction {
            columns.push(rows.direction.clone());
        }
        columns.extend(self.order.iter().flat_map(|order| wave(rows, &rows.side(friction), *order)));
        columns
    }
}

/// Fits the training rows of a joint, with a constant gap or one of an `order`; `None` where its link was not recorded or does not move.
pub fn fit(
    problem: &Problem,
    sessions: &[&TimeSeries],
    joint: usize,
    known: Lag,
    order: Option<f64>,
) -> Option<AxisFit> {
    let trained = |lag: f64| trained(problem, sessions, joint, lag);
    let mut lag = if let Lag::Known(lag) = known { lag } else { 0.0 };
    let mut friction = 0.0;
    let mut found = None;
    for _ in 0..STEPS {
        let rows = trained(lag)?;
        let speed = known == Lag::Free || (rows.motor_side && known != Lag::Ignored);
        let (changes, observable) = flanks(&rows.side(friction));
        let layout = Layout { speed, side: observable, direction: rows.motor_side, order };
        let step = Step::new(problem, rows, layout, friction, changes)?;
        if known == Lag::Free {
            lag += step.solved.coefficients[0];
        }
        if layout.direction {
            friction = step.friction();
        }
        found = Some(step);
    }
    let explained = explained_by_lag(&trained(0.0)?, problem)?;
    let step = found?;
    let variance = step.regression().covariance(problem, &[]).diagonal().map(|v| v.max(0.0));
    let estimate = |at: usize| Estimate { value: step.solved.coefficients[at], std_error: variance[at].sqrt() };
    let (layout, rms) = (step.layout, step.solved.rms);
    let wind_up = estimate(layout.load());
    let unknown = SHARE_BEFORE[1] * problem.motion.joints[joint].friction.coulomb * wind_up.value.max(0.0);
    let lag = match known {
        Lag::Free => {
            let [shift, doubt] = by_friction(problem, &step.rows, wind_up);
            Estimate { value: lag + shift, std_error: variance[0].sqrt().hypot(doubt) }
        }
        _ => Estimate { value: lag, std_error: 0.0 },
    };
    Some(AxisFit {
        joint,
        lag,
        wind_up,
        gap: layout.side.then(|| step.gap(estimate(layout.flank()))),
        lost: layout.direction.then(|| lost_motion(problem, &step.rows, estimate(layout.way()), wind_up, rms)),
        explained,
        wave: order.map(|n| Wave::of(problem, &step.regression(), n, step.own - 2, unknown)),
        friction,
        coefficients: step.solved.coefficients.as_slice()[..step.own].to_vec(),
        layout,
    })
}

/// One step of the fit: rows at a lag, and what was fitted to them.
struct Step {
    rows: Difference,
    columns: Vec<Vec<f64>>,
    solved: Solved,
    layout: Layout,
    /// Changes of flank.
    changes: usize,
    /// Number of columns before the mounting.
    own: usize,
}

impl Step {
    fn new(problem: &Problem, rows: Difference, layout: Layout, friction: f64, changes: usize) -> Option<Self> {
        let mut columns = layout.columns(&rows, friction);
        let own = columns.len();
        columns.extend(rows.mounting(problem));
        let solved = solve(&rows.ahead, &columns)?;
        Some(Self { rows, columns, solved, layout, changes, own })
    }

    fn regression(&self) -> Regression<'_> {
        Regression { rows: &self.rows, columns: &self.columns, solved: &self.solved }
    }

    /// Friction before the gear [N·m or N]: the coefficient of the direction, converted to units of the load.
    fn friction(&self) -> f64 {
        let c = &self.solved.coefficients;
        let (load, way) = (c[self.layout.load()], c[self.layout.way()]);
        let largest = self.rows.load.iter().fold(0.0_f64, |most, load| most.max(load.abs()));
        if load > 0.0 { (-way / load).clamp(0.0, largest) } else { 0.0 }
    }

    /// The gap: each change of flank shows it once, as the difference of two values with errors.
    fn gap(&self, side: Estimate) -> Estimate {
        let of_changes = (2.0 / self.changes as f64).sqrt() * self.solved.rms;
        Estimate { std_error: side.std_error.hypot(of_changes), ..side }
    }
}

/// The training rows of a joint.
pub fn trained(problem: &Problem, sessions: &[&TimeSeries], joint: usize, lag: f64) -> Option<Difference> {
    Some(difference(problem, sessions, joint, lag)?.filtered(|row| !problem.held_out[row]))
}

impl AxisFit {
    /// Columns of the fit in some rows, without the mounting.
    pub fn columns(&self, rows: &Difference) -> Vec<Vec<f64>> {
        self.layout.columns(rows, self.friction)
    }

    /// Residual of rows at the fit's lag, with the mounting fitted again.
    pub fn residual(&self, problem: &Problem, rows: &Difference) -> Option<Vec<f64>> {
        let mut left = rows.ahead.clone();
        for (column, c) in self.columns(rows).iter().zip(&self.coefficients) {
            left.iter_mut().zip(column).for_each(|(e, x)| *e -= c * x);
        }
        rest(problem, rows, &left)
    }
}

/// [s] Contribution of viscous friction to the lag, and its error. Before the gear, viscous friction is part of the motor's torque but does
/// not wind up the gear, which looks like a lag of `−F_V/k`. Where the load is that of the links, the part behind the gear has the same
/// uncertainty.
fn by_friction(problem: &Problem, rows: &Difference, wind_up: Estimate) -> [f64; 2] {
    let known = problem.motion.joints[rows.joint].friction.viscous;
    let viscous =
        if rows.motor_side { measured_friction(problem, rows).map_or(0.0, |[viscous, _]| viscous) } else { known }
            .max(0.0);
    let [share, doubt] = SHARE_BEFORE.map(|share| share * viscous);
    let c = wind_up.value.max(0.0);
    if rows.motor_side { [share * c, (doubt * c).hypot(share * wind_up.std_error)] } else { [0.0, doubt * c] }
}

/// [rad or m] `2 (step + share · F_C/k)`: the step with the direction of motion, minus the effect of dry friction before the gear.
fn lost_motion(problem: &Problem, rows: &Difference, step: Estimate, wind_up: Estimate, rms: f64) -> Estimate {
    let coulomb = measured_friction(problem, rows).map_or(0.0, |[_, coulomb]| coulomb.max(0.0));
    let [share, doubt] = SHARE_BEFORE.map(|share| share * coulomb);
    let c = wind_up.value.max(0.0);
    let (reversals, _) = flanks(&rows.direction);
    let of_reversals = (2.0 / reversals.max(1) as f64).sqrt() * rms;
    let std_error = [2.0 * doubt * c, 2.0 * share * wind_up.std_error, of_reversals]
        .into_iter()
        .fold(2.0 * step.std_error, f64::hypot);
    Estimate { value: 2.0 * (step.value + share * c), std_error }
}

/// `F_V` [N·m·s/rad or N·s/m] and `F_C` [N·m or N] from the measured torque alone, beside inertia and position-dependent terms.
fn measured_friction(problem: &Problem, rows: &Difference) -> Option<[f64; 2]> {
    let m = &problem.motion.joints[rows.joint];
    let pick = |values: &[f64]| -> Vec<f64> { rows.rows.iter().map(|row| values[*row]).collect() };
    let mut columns = vec![rows.v.clone(), rows.direction.clone(), pick(&m.a)];
    columns.extend(rows.mounting(problem));
    let c = solve(&pick(&m.torque), &columns)?.coefficients;
    Some([c[0], c[1]])
}

/// Residual of rows when only their mounting is fitted.
pub fn rest(problem: &Problem, rows: &Difference, values: &[f64]) -> Option<Vec<f64>> {
    Some(solve(values, &rows.mounting(problem))?.residual)
}

/// Share of the squared difference of the encoders, without a constant per session, that a lag alone explains.
fn explained_by_lag(rows: &Difference, problem: &Problem) -> Option<f64> {
    let mounting = rows.mounting(problem);
    let constants: Vec<Vec<f64>> =
        mounting.iter().filter(|c| c.iter().all(|x| *x == 0.0 || *x == 1.0)).cloned().collect();
    let plain = |columns: Vec<Vec<f64>>| -> Option<f64> {
        let unknowns = columns.len();
        let block = Block { y: rows.ahead.clone(), columns: columns.into_iter().enumerate().collect() };
        let solution = System { blocks: vec![block], unknowns, ..System::default() }.solve(f64::INFINITY)?;
        Some(root_mean_square(&solution.residual[0]).powi(2))
    };
    let before = plain(constants.clone())?;
    let after = plain(constants.into_iter().chain([rows.v.clone()]).collect())?;
    Some(1.0 - after / before.max(1e-300))
}

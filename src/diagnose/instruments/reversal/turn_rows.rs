//! The reversal zone of one joint as a regression: the residual of the rigid fit against the torque that a simulated gear lacks.

use super::path::{Path, Windows};
use crate::diagnose::fit::problem::{Part, Problem};
use crate::diagnose::fit::regression::{Block, NU, Solution, System};
use crate::diagnose::rows::reversals::{heading, held, rest};
use crate::effects::Motion;
use crate::timeseries::TimeSeries;

/// [s] Least time before and after a reversal that belongs to it.
const AROUND: [f64; 2] = [0.1, 0.4];
/// Travel of the rotor after a reversal that belongs to the reversal, in gaps.
const TRAVEL: f64 = 3.0;
/// Stribeck velocities of the falling parts, relative to that of the law: the rows of the fit may have been too fast to tell it, and then it is too large. A
/// breakaway that depends on the rest before it is none of any law of the speed.
const FALLS: [f64; 3] = [1.0, 0.5, 0.25];

/// The rows of one joint around its reversals.
pub struct TurnRows<'p, 'm> {
    /// The problem with all rows.
    pub problem: &'p Problem<'m>,
    /// Index of the joint.
    pub joint: usize,
    /// Its motion.
    pub path: Path,
    /// Rows around reversals.
    pub rows: Vec<usize>,
    pub(super) windows: Windows,
    /// Residual of the rigid fit in these rows.
    pub residual: Vec<f64>,
    /// Columns that are always fitted: friction, and a part that falls with the speed in any way.
    free: Vec<Vec<f64>>,
}

impl<'p, 'm> TurnRows<'p, 'm> {
    /// The rows of a joint; `residual` for all rows, `gap` the largest gap that is considered.
    pub fn new(problem: &'p Problem<'m>, joint: usize, sessions: &[&TimeSeries], residual: &[f64], gap: f64) -> Self {
        let motion = &problem.motion;
        let path = Path::new(motion, joint, sessions);
        let rows = around_turns(motion, joint, TRAVEL * gap);
        let windows = path.windows(motion, &rows);
        let m = &motion.joints[joint];
        let law = &m.friction;
        // Within a kernel around a reversal the velocity is not linear: average the friction over the grid of times.
        let dry = |v: f64, level: f64| level * v.signum();
        let falling = |v: f64, part: f64| dry(v, (-v.abs() / (part * law.stribeck_velocity)).exp());
        let seen = |value: &dyn Fn(f64) -> f64| -> Vec<f64> {
            windows.averages(&path.v.iter().map(|v| value(*v)).collect::<Vec<f64>>())
        };
        let mut free = vec![seen(&|v| dry(v, 1.0))];
        free.extend(FALLS.map(|part| seen(&|v| falling(v, part))));
        let friction = seen(&|v| dry(v, law.dry(v)));
        let residual = rows
            .iter()
            .zip(friction)
            .map(|(row, friction)| residual[*row] + m.direction[*row] * law.dry(m.v[*row]) - friction)
            .collect();
        Self { problem, joint, path, rows, windows, residual, free }
    }

    /// Rows of a part, as positions in [`rows`](Self::rows).
    pub fn part(&self, part: Part) -> Vec<usize> {
        (0..self.rows.len()).filter(|index| self.problem.is_in(self.rows[*index], part)).collect()
    }

    /// The system of some rows: `lack` subtracted, with the further columns first.
    pub fn system(&self, picked: &[usize], lack: &[f64], further: &[Vec<f64>]) -> System {
        let pick = |values: &[f64]| -> Vec<f64> { picked.iter().map(|index| values[*index]).collect() };
        let y = picked.iter().map(|index| self.residual[*index] - lack[*index]).collect();
        let columns: Vec<_> = further.iter().chain(&self.free).map(|column| pick(column)).enumerate().collect();
        let unknowns = columns.len();
        System { blocks: vec![Block { y, columns }], unknowns, ..System::default() }
    }

    /// Fits the rows of a part.
    pub fn fit(&self, part: Part, lack: &[f64], further: &[Vec<f64>]) -> Option<Solution> {
        self.system(&self.part(part), lack, further).solve(NU)
    }
}

/// Rows of a joint around its reversals: from a short time before until some time and some travel after, without rows in which it rests or sticks.
fn around_turns(motion: &Motion, joint: usize, travel: f64) -> Vec<usize> {
    let m = &motion.joints[joint];
    let (heading, rest) = (heading(motion, joint), rest(motion, joint));
    let mut taken = vec![false; motion.rows()];
    for row in 1..motion.rows() {
        let turns = heading[row] != heading[row - 1] && motion.part[row] == motion.part[row - 1];
        if !turns {
            continue;
        }
        let same = |other: &usize| motion.part[*other] == motion.part[row];
        let w = motion.half_width[row];
        for other in (0..row).rev().take_while(same).take_while(|o| motion.time[*o] > motion.time[row] - AROUND[0] - w)
        {
            taken[other] = true;
        }
        let near = |other: &usize| {
            motion.time[*other] < motion.time[row] + AROUND[1] + w || (m.q[*other] - m.q[row]).abs() < travel
        };
        for other in (row..motion.rows()).take_while(same).take_while(near) {
            taken[other] = true;
        }
    }
    let held = held(motion, joint);
    let slides = |row: &usize| m.v[*row].abs() > 0.5 * rest && !held[*row];
    (0..motion.rows()).filter(|row| taken[*row] && slides(row)).collect()
}

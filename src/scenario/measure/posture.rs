//! Where a joint is measured, and with which posture of the other joints.
//!
//! ```text
//!   disturbance at q = s_m |G(q)|/F_C + 1 − 1/(M_jj (M⁻¹)_jj)
//! ```
//! First term: what the model's gravity is wrong by (`s_m`: accuracy of the masses), in units of the friction. Second term: how much
//! less inertia the joint feels while the other links are loose in their gaps, 0 where links do not couple; the controller is tuned for
//! the whole of it. The other joints may be anywhere in their rooms: a folded arm couples least, and is often near an end of its range.
//! A posture counts by its worst place along the sweep. Among postures with the same value the first one is taken,
//! which is near zero.

use nalgebra::DMatrix;

use crate::dynamics::Dynamics;
use crate::robot::Model;
use crate::scenario::reach::{Reach, starts};

/// Part of a joint's own range that a sweep may use.
const OWN_ROOM: f64 = 0.92;
/// Places along a sweep at which the disturbance is computed, and places of the grid of each joint.
const PLACES: usize = 5;
/// Least relative error of gravity: gears wind up under it, however well masses are known.
const LEAST_ERROR: f64 = 0.02;
/// Least gain for which another posture is preferred.
const LEAST_GAIN: f64 = 1e-3;

/// A posture with the joint at the lower end of its sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture {
    /// [rad or m] One per joint.
    pub positions: Vec<f64>,
    /// Worst disturbance along the sweep.
    pub disturbance: f64,
    /// [rad or m] Where along the sweep a stroke is disturbed least: its lower end.
    pub stroke: f64,
}

/// Lower end and length [rad or m] of the range in which a joint is measured: nearly all of its own, or where motors are coupled or the
/// range has no end, what any planned experiment uses.
pub fn room(model: &Model, reach: &Reach, index: usize) -> [f64; 2] {
    let limits = model.robot.bodies[index].joint.limits;
    let [low, high] = if limits.lower.is_finite() && limits.upper.is_finite() && model.robot.coupling.is_none() {
        let (middle, half) = (0.5 * (limits.lower + limits.upper), 0.5 * OWN_ROOM * (limits.upper - limits.lower));
        // Ranges of several turns are as good as unlimited.
        let half = half.min(2.5 * reach.half.max(1.0));
        [middle - half, middle + half]
    } else {
        [reach.middle - reach.half, reach.middle + reach.half]
    };
    [low, high - low]
}

/// Postures for a sweep of a way and strokes of another [rad or m], the best first. `friction` [N·m or N].
pub fn postures(
    model: &Model,
    reaches: &[Reach],
    index: usize,
    [way, stroke]: [f64; 2],
    friction: f64,
) -> Vec<Posture> {
    let mut judge = Judge { model, dynamics: Dynamics::new(&model.robot), index, friction };
    let [low, length] = room(model, &reaches[index], index);
    let at = |k: usize| low + (length - way).max(0.0) * k as f64 / (PLACES - 1) as f64;
    let mut found: Vec<Posture> = Vec::new();
    for start in starts(reaches) {
        let mut best = (0..PLACES)
            .map(|k| judge.posture(with(&start, index, at(k)), way, stroke))
            .min_by(|a, b| a.disturbance.total_cmp(&b.disturbance));
        // One joint after the other, twice: the other joints matter through their position relative to their neighbours.
        for joint in (0..start.len()).chain(0..start.len()) {
            let Some(present) = best.clone() else { continue };
            for k in 0..PLACES {
                let place = if joint == index {
                    at(k)
                } else {
                    let [low, length] = room(model, &reaches[joint], joint);
                    low + length * k as f64 / (PLACES - 1) as f64
                };
                let tried = judge.posture(with(&present.positions, joint, place), way, stroke);
                if best.as_ref().is_some_and(|best| tried.disturbance < best.disturbance - LEAST_GAIN) {
                    best = Some(tried);
                }
            }
        }
        // The unchanged start as well: the better posture may let links collide.
        found.extend(best);
        let free = 0.5 * (length - way).max(0.0);
        found.push(judge.posture(with(&start, index, low + free), way, stroke));
    }
    found.sort_by(|a, b| a.disturbance.total_cmp(&b.disturbance));
    found
}

fn with(positions: &[f64], joint: usize, place: f64) -> Vec<f64> {
    let mut positions = positions.to_vec();
    positions[joint] = place;
    positions
}

struct Judge<'a> {
    model: &'a Model,
    dynamics: Dynamics,
    index: usize,
    friction: f64,
}

impl Judge<'_> {
    /// The posture with its worst disturbance along the sweep, and the best place for strokes.
    fn posture(&mut self, positions: Vec<f64>, way: f64, stroke: f64) -> Posture {
        let start = positions[self.index];
        let places: Vec<f64> = (0..PLACES).map(|k| start + way * k as f64 / (PLACES - 1) as f64).collect();
        let values: Vec<f64> =
            places.iter().map(|&place| self.disturbance(&with(&positions, self.index, place))).collect();
        let best = (0..PLACES).min_by(|&i, &j| values[i].total_cmp(&values[j])).unwrap_or(0);
        let last = (start + way - stroke).max(start);
        Posture {
            positions,
            disturbance: values.into_iter().fold(0.0, f64::max),
            stroke: (places[best] - 0.5 * stroke).clamp(start, last),
        }
    }

    fn disturbance(&mut self, q: &[f64]) -> f64 {
        let (n, j) = (q.len(), self.index);
        let mut weight = vec![0.0; n];
        self.dynamics.gravity(q, &mut weight);
        let mut mass = DMatrix::zeros(n, n);
        self.dynamics.mass_matrix(q, &mut mass);
        let held = mass[(j, j)];
        let loose = mass.try_inverse().map_or(held, |inverse| 1.0 / inverse[(j, j)]);
        self.model.accuracy.masses.max(LEAST_ERROR) * weight[j].abs() / self.friction.max(f64::MIN_POSITIVE) + 1.0
            - loose / held
    }
}

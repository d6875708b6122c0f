//! Maps of the residual: its mean in bins of quantities that may explain it, with both directions of motion together and separate.
//!
//! With the means `p`, `n` of a bin over motion in the positive and in the negative direction, half the sum `(p + n)/2` is independent of the
//! direction (gravity, cables, offsets, cogging), and half the difference `(p − n)/2` resists or helps motion (friction).

use super::Residual;
use super::axes::{Binned, binned};
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::result::{Axis, ResidualMap};

/// Axes of the maps.
const AXES: [Axis; 8] = [
    Axis::Time,
    Axis::Position,
    Axis::Velocity,
    Axis::Acceleration,
    Axis::Direction,
    Axis::Load,
    Axis::MotorAngle,
    Axis::ReversalPhase,
];
/// Least number of rows per direction in a bin.
const FEWEST: usize = 3;

/// The maps of all joints; `floor[joint][row]` as [`floor`](super::floor::floor) gives it.
pub fn maps(problem: &Problem, residuals: &[Residual], floor: &[Vec<f64>]) -> Vec<ResidualMap> {
    let of_joint = |joint: usize| {
        AXES.map(|axis| map(problem, joint, axis, &residuals[joint], &floor[joint])).into_iter().collect::<Vec<_>>()
    };
    problem.joints().into_iter().flat_map(of_joint).collect()
}

/// Sums of one bin.
#[derive(Clone, Copy, Default)]
struct Bin {
    count: usize,
    before: f64,
    after: f64,
    floor: f64,
    /// Rows and residual of the nominal model by direction, positive first.
    direction: [(usize, f64); 2],
}

fn map(problem: &Problem, joint: usize, axis: Axis, residual: &Residual, floor: &[f64]) -> ResidualMap {
    let Binned { rows, bin, centre } = binned(problem, joint, axis);
    let direction = &problem.motion.joints[joint].direction;
    let mut bins = vec![Bin::default(); centre.len()];
    for (row, bin) in rows.into_iter().zip(bin) {
        let bin = &mut bins[bin];
        bin.count += 1;
        bin.before += residual.before[row];
        bin.after += residual.after[row];
        bin.floor += floor[row] * floor[row];
        let side = &mut bin.direction[usize::from(direction[row] < 0.0)];
        *side = (side.0 + 1, side.1 + residual.before[row]);
    }
    let mut map = ResidualMap {
        joint: problem.motion.model.joints[joint].name.clone(),
        axis,
        centre: Vec::new(),
        count: Vec::new(),
        before: Vec::new(),
        after: Vec::new(),
        alike: Vec::new(),
        opposed: Vec::new(),
        floor: Vec::new(),
    };
    for (centre, bin) in centre.into_iter().zip(bins).filter(|(_, bin)| bin.count > 0) {
        let count = bin.count as f64;
        map.centre.push(centre);
        map.count.push(bin.count);
        map.before.push(bin.before / count);
        map.after.push(bin.after / count);
        map.floor.push((bin.floor / count).sqrt());
        if !matches!(axis, Axis::Velocity | Axis::Direction) {
            let [p, n] = bin.direction.map(|(rows, sum)| if rows < FEWEST { f64::NAN } else { sum / rows as f64 });
            map.alike.push(0.5 * (p + n));
            map.opposed.push(0.5 * (p - n));
        }
    }
    map
}

//! Shares of the squared error of the nominal model: per zone, and the share that each single quantity explains.
//!
//! The share of an axis is the part that its binned mean predicts on other rows than it was computed from, so it excludes chance:
//!
//! ```text
//!   share = 1 − Σ (e − m̂(x))²/Σ e²          m̂: mean of e in the bin of x, over the other half of the data (blocks of 5 s in turn)
//! ```
//! `alike`: one mean for both directions of motion; `opposed`: `m̂ · sgn v`; `share`: both directions separate. Rows are clipped to four standard
//! deviations of their session first. Shares of several axes do not add up: along a given motion, position, load and time may explain the
//! same error. A constant error is explained by every axis, so the simplest axis within a few points of the best is the most plausible.
//! The share of frequency is that of its strongest single line, see [`spectra`](super::spectra).
//! The shares of the zones need a simulation with gaps: they are given once the nominal model has been replayed.

use rayon::prelude::*;

use super::Residual;
use super::axes::{Binned, binned};
use super::spectra;
use crate::diagnose::fit::problem::{Part, Problem};
use crate::diagnose::result::{Axis, AxisShare, JointShares, Zone};
use crate::diagnose::rows::reversals::since_reversal;
use crate::units::JointKind;

/// Axes, simplest first.
const AXES: [Axis; 9] = [
    Axis::Constant,
    Axis::Direction,
    Axis::Velocity,
    Axis::Position,
    Axis::Load,
    Axis::MotorAngle,
    Axis::Acceleration,
    Axis::ReversalPhase,
    Axis::Time,
];
/// [s] Length of a block; shorter where the data hold fewer than [`WANTED_BLOCKS`].
const BLOCK: f64 = 5.0;
/// Number of blocks in short data.
const WANTED_BLOCKS: f64 = 8.0;
/// Robust standard deviations at which errors are clipped; no sine wave reaches that.
const CLIPPED: f64 = 4.0;
/// [s] Time after a reversal that belongs to its zone, in which the link crosses its gap.
const REVERSAL_ZONE: f64 = 0.4;

/// The shares of all joints; `floor[joint][row]` as [`floor`](super::floor::floor) gives it.
pub fn shares(problem: &Problem, residuals: &[Residual], floor: &[Vec<f64>]) -> Vec<JointShares> {
    let of_joint = |joint: usize| of_joint(problem, joint, &residuals[joint], &floor[joint]);
    problem.joints().into_par_iter().map(of_joint).collect()
}

fn of_joint(problem: &Problem, joint: usize, residual: &Residual, floor: &[f64]) -> JointShares {
    let model = &problem.motion.model.joints[joint];
    let rows = problem.judged_rows(joint, Part::HeldOut);
    let rms =
        |values: &[f64]| (rows.iter().map(|row| values[*row].powi(2)).sum::<f64>() / rows.len().max(1) as f64).sqrt();
    let (before, floor) = (rms(&residual.before), rms(floor));
    let fold = folds(problem);
    let error = clipped(problem, joint, &residual.before);
    let mut axes: Vec<AxisShare> = AXES.iter().map(|axis| of_axis(problem, joint, *axis, &error, &fold)).collect();
    let line = spectra::strongest_line(problem, joint, &error);
    axes.push(AxisShare {
        axis: Axis::Frequency,
        share_percent: 100.0 * line.map_or(0.0, |(_, share)| share),
        alike_percent: None,
        opposed_percent: None,
        frequency: line.map(|(frequency, _)| frequency),
    });
    JointShares {
        joint: model.name.clone(),
        quantity: if model.kind == JointKind::Revolute { "torque" } else { "force" },
        unit: model.kind.effort_unit(),
        rms: before,
        torque_percent: 100.0 * before / rms(&problem.motion.joints[joint].torque).max(1e-300),
        floor,
        zones: None,
        axes,
    }
}

/// The zone of each row of a joint.
pub fn zones(problem: &Problem, joint: usize) -> Vec<Zone> {
    let (motion, since) = (&problem.motion, since_reversal(&problem.motion, joint));
    let zone = |row: usize| match problem.judged[joint][row] {
        true => Zone::Rigid,
        false if since[row] <= REVERSAL_ZONE + motion.half_width[row] => Zone::Reversal,
        false => Zone::Rest,
    };
    (0..motion.rows()).map(zone).collect()
}

/// The error, clipped: a change of flank that is not detected has as much weight as a hundred other rows. Each session has its own scale;
/// with a common scale, the whole error of a fast session could be clipped.
fn clipped(problem: &Problem, joint: usize, error: &[f64]) -> Vec<f64> {
    let (motion, zone) = (&problem.motion, &problem.judged[joint]);
    let most = |session: usize| {
        let rows = (0..motion.rows()).filter(|row| motion.session[*row] == session && zone[*row]);
        let mut sizes: Vec<f64> = rows.map(|row| error[row].abs()).collect();
        if sizes.is_empty() {
            return f64::INFINITY;
        }
        let middle = sizes.len() / 2;
        // The median of |x| of a normal variable is 0.6745 standard deviations.
        CLIPPED * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1 / 0.6745
    };
    let most: Vec<f64> = (0..motion.sessions).map(most).collect();
    error.iter().zip(&motion.session).map(|(e, session)| e.clamp(-most[*session], most[*session])).collect()
}

/// The half of the data to which each row belongs.
fn folds(problem: &Problem) -> Vec<bool> {
    let motion = &problem.motion;
    let span = match (motion.time.first(), motion.time.last()) {
        (Some(first), Some(last)) if motion.sessions == 1 => last - first,
        _ => f64::INFINITY,
    };
    let block = BLOCK.min(span / WANTED_BLOCKS).max(1e-9);
    let fold = |(session, time): (&usize, &f64)| ((time / block) as usize + session) % 2 == 1;
    motion.session.iter().zip(&motion.time).map(fold).collect()
}

fn of_axis(problem: &Problem, joint: usize, axis: Axis, before: &[f64], fold: &[bool]) -> AxisShare {
    let Binned { rows, bin, centre } = binned(problem, joint, axis);
    let direction = &problem.motion.joints[joint].direction;
    let sample = |(row, bin): (&usize, &usize)| {
        let direction = direction[*row];
        Sample { bin: *bin, side: if direction < 0.0 { -1.0 } else { 1.0 }, fold: fold[*row], e: before[*row] }
    };
    let samples: Vec<Sample> = rows.iter().zip(&bin).map(sample).collect();
    let explained = |law: Law| 100.0 * explained(&samples, centre.len(), law);
    let apart = !matches!(axis, Axis::Constant | Axis::Direction | Axis::Velocity);
    let alike = explained(Law::Alike);
    let opposed = apart.then(|| explained(Law::Opposed));
    let share_percent = if apart { explained(Law::Apart).max(alike).max(opposed.unwrap_or(0.0)) } else { alike };
    AxisShare { axis, share_percent, alike_percent: apart.then_some(alike), opposed_percent: opposed, frequency: None }
}

/// An error with its bin, direction and half of the data.
#[derive(Debug, Clone, Copy)]
struct Sample {
    bin: usize,
    /// Direction of motion: +1 or −1.
    side: f64,
    fold: bool,
    e: f64,
}

/// What both directions of motion have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Law {
    /// The error.
    Alike,
    /// The error times the direction.
    Opposed,
    /// Nothing: separate values for each direction.
    Apart,
}

/// Share of the squared error that the mean over the other half of the data predicts, 0 to 1.
fn explained(samples: &[Sample], bins: usize, law: Law) -> f64 {
    let place = |one: &Sample| match law {
        Law::Apart => 2 * one.bin + usize::from(one.side < 0.0),
        _ => 2 * one.bin,
    };
    let sign = |one: &Sample| if law == Law::Opposed { one.side } else { 1.0 };
    let mut sums = [vec![(0.0, 0.0); 2 * bins], vec![(0.0, 0.0); 2 * bins]];
    for one in samples {
        let (sum, count) = &mut sums[usize::from(one.fold)][place(one)];
        *sum += sign(one) * one.e;
        *count += 1.0;
    }
    let (mut left, mut all) = (0.0, 0.0);
    for one in samples {
        let (sum, count) = sums[usize::from(!one.fold)][place(one)];
        let predicted = if count > 0.0 { sign(one) * sum / count } else { 0.0 };
        left += (one.e - predicted).powi(2);
        all += one.e * one.e;
    }
    if all > 0.0 { (1.0 - left / all).max(0.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A joint that moves back and forth `strokes` times over 40 bins, one row per bin.
    fn to_and_fro(strokes: usize, e: impl Fn(usize, f64, usize) -> f64) -> Vec<Sample> {
        let sample = |k: usize| {
            let (stroke, step) = (k / 40, k % 40);
            let (bin, side) = if stroke % 2 == 0 { (step, 1.0) } else { (39 - step, -1.0) };
            Sample { bin, side, fold: (k / 100) % 2 == 1, e: e(bin, side, k) }
        };
        (0..40 * strokes).map(sample).collect()
    }

    #[test]
    fn recover_the_whole_share_of_what_depends_on_the_bin_alone() {
        let wave = |bin: usize| (0.3 * bin as f64).sin();
        for (law, other, samples) in [
            (Law::Alike, Law::Opposed, to_and_fro(30, |bin, _, _| wave(bin))),
            (Law::Opposed, Law::Alike, to_and_fro(30, |bin, side, _| side * (1.5 + wave(bin)))),
        ] {
            // The mean of equal values is that value, up to rounding; with the opposite sign on the way back it is zero.
            assert!((explained(&samples, 40, law) - 1.0).abs() < 1e-12);
            assert!((explained(&samples, 40, Law::Apart) - 1.0).abs() < 1e-12);
            assert!(explained(&samples, 40, other) < 1e-12);
        }
    }

    #[test]
    fn property_noise_has_no_share() {
        // Pseudo-random values without relation to the bin: 6000 values, 40 to 80 means of 75 or 37 in each half.
        let noise = |k: usize| ((k * 7919 + k * k * 31) % 10_007) as f64 / 10_007.0 - 0.5;
        for law in [Law::Alike, Law::Opposed, Law::Apart] {
            // Means of 37 values predict worse than zero by 1/37, with a standard deviation of the share of √(2/6000).
            assert!(explained(&to_and_fro(150, |_, _, k| noise(k)), 40, law) < 0.02);
        }
    }
}

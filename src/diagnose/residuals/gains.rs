//! The gains of effects on held-out data.
//!
//! ```text
//!   own gain of effect k:  the fall of the error from all effects but k to all of them
//!   steps:  gain_k = (E_{k−1} − E_k)/E_0      E_k: RMS torque error with effects 1 … k, the strongest first;  E_0: of the nominal model
//! ```
//! An effect is judged by its own gain, that is by the loss of the model without it. The steps of one joint's effects add up to the joint's
//! gain. For several joints together, the error of each is taken relative to its RMS torque.
//!
//! The own gain uses the rows of the fit, each with the weight `√w` of the fit's robust loss:
//!
//! ```text
//!   w = (ν + 1)/(ν + (e/s)²),   e: the smaller of both errors of the row,  s: their robust standard deviation
//! ```
//! so that rows that neither model explains (a floating link, a knock) have little weight. The interval is that of [`gain_interval`].
//! Where held-out motion hardly shows an effect, as a contact that it does not reach, the gain is that of the training rows, each fold predicted by
//! a fit to the others.

use std::collections::BTreeMap;

use super::gain_interval;
use crate::diagnose::fit::problem::{Part, Problem};
use crate::diagnose::fit::regression::NU;
use crate::diagnose::result::EffectGain;
use crate::effects::Motion;
use crate::replay::{Gain, Pairs};

/// The quantity in which the gains of torque are given.
pub const TORQUE: &str = "torque";

/// Residuals of one stage: `residuals[joint][row]`.
pub type Residuals = Vec<Vec<f64>>;

/// Weight of each row, from its number and both errors.
type Weights = fn(&[usize], &[f64], &[f64]) -> Vec<f64>;

/// Compares residuals on held-out rows with those of the nominal model.
pub struct Judge<'p, 'm> {
    problem: &'p Problem<'m>,
    nominal: &'p Residuals,
    /// [N·m or N] RMS torque of each joint.
    torque: Vec<f64>,
}

impl<'p, 'm> Judge<'p, 'm> {
    /// A judge with these residuals of the nominal model.
    pub fn new(problem: &'p Problem<'m>, nominal: &'p Residuals) -> Self {
        let of_joint = |joint: usize| {
            let rows = problem.rows(joint, Part::HeldOut);
            let torque = &problem.motion.joints[joint].torque;
            let power: f64 = rows.iter().map(|row| torque[*row].powi(2)).sum();
            (power / rows.len().max(1) as f64).sqrt().max(1e-300)
        };
        Self { problem, nominal, torque: (0..problem.baseline.len()).map(of_joint).collect() }
    }

    /// The gain of an effect: its own gain, and its step.
    pub fn effect(&self, joints: &[usize], own: [&Residuals; 2], step: [&Residuals; 2]) -> EffectGain {
        EffectGain { gain_by_joint: self.steps(joints, step), ..EffectGain::of(self.compared(joints, own), TORQUE) }
    }

    /// [%] Fall of the error of each of these joints from one set of residuals to the next, relative to the error of the nominal model.
    fn steps(&self, joints: &[usize], [before, after]: [&Residuals; 2]) -> BTreeMap<String, f64> {
        let of_joint = |joint: &usize| {
            let error = |residuals: &Residuals| self.error(*joint, residuals);
            let step = (error(before) - error(after)) / error(self.nominal).max(1e-300);
            (self.problem.motion.model.joints[*joint].name.clone(), 100.0 * step)
        };
        joints.iter().map(of_joint).collect()
    }

    /// The gain of one set of residuals over another on some joints.
    pub fn compared(&self, joints: &[usize], residuals: [&Residuals; 2]) -> Gain {
        self.weighted(joints, residuals, weights, Part::HeldOut)
    }

    /// As [`compared`](Self::compared), on the training rows: for residuals each of which is predicted by a fit to other rows.
    pub fn compared_in_training(&self, joints: &[usize], residuals: [&Residuals; 2]) -> Gain {
        self.weighted(joints, residuals, weights, Part::Train)
    }

    /// As [`compared`](Self::compared), with equal weight for all rows.
    pub fn unweighted(&self, joints: &[usize], residuals: [&Residuals; 2]) -> Gain {
        self.weighted(joints, residuals, |rows, _, _| vec![1.0; rows.len()], Part::HeldOut)
    }

    fn weighted(&self, joints: &[usize], [before, after]: [&Residuals; 2], weights: Weights, part: Part) -> Gain {
        let motion = &self.problem.motion;
        let of_joint = |joint: &usize| {
            let rows = self.problem.rows(*joint, part);
            let weights = weights(&rows, &before[*joint], &after[*joint]);
            let relative = |residuals: &Residuals| -> Vec<f64> {
                let weighted = rows.iter().zip(&weights).map(|(row, weight)| weight * residuals[*joint][*row]);
                weighted.map(|error| error / self.torque[*joint]).collect()
            };
            by_session(motion, &rows, [&relative(before), &relative(after)])
        };
        gain(&joints.iter().flat_map(of_joint).collect::<Vec<_>>())
    }

    /// `√Σ e²` of the held-out errors of a joint.
    fn error(&self, joint: usize, residuals: &Residuals) -> f64 {
        let rows = self.problem.judged_rows(joint, Part::HeldOut).into_iter();
        rows.map(|row| residuals[joint][row].powi(2)).sum::<f64>().sqrt()
    }
}

/// `√w` of each row.
fn weights(rows: &[usize], before: &[f64], after: &[f64]) -> Vec<f64> {
    let smaller: Vec<f64> = rows.iter().map(|row| before[*row].abs().min(after[*row].abs())).collect();
    let mut sorted = smaller.clone();
    let middle = sorted.len() / 2;
    // For a normal variable the median of the magnitude is 0.6745 standard deviations.
    let median = if sorted.is_empty() { 0.0 } else { *sorted.select_nth_unstable_by(middle, f64::total_cmp).1 };
    let s = (median / 0.6745).max(1e-300);
    smaller.iter().map(|e| ((NU + 1.0) / (NU + (e / s).powi(2))).sqrt()).collect()
}

/// The gain over rows of a motion, from the errors without and with an effect, one value per row.
pub fn of_rows(motion: &Motion, rows: &[usize], errors: [&[f64]; 2]) -> Gain {
    gain(&by_session(motion, rows, errors))
}

/// Time, error before and error after of each session.
fn by_session(motion: &Motion, rows: &[usize], [before, after]: [&[f64]; 2]) -> Vec<[Vec<f64>; 3]> {
    let mut sessions = vec![<[Vec<f64>; 3]>::default(); motion.sessions];
    for ((row, before), after) in rows.iter().zip(before).zip(after) {
        let [time, befores, afters] = &mut sessions[motion.session[*row]];
        time.push(motion.time[*row]);
        befores.push(*before);
        afters.push(*after);
    }
    sessions
}

/// The gain over sessions, each with time, error before and error after.
pub fn gain(sessions: &[[Vec<f64>; 3]]) -> Gain {
    let pairs: Vec<Pairs> = sessions.iter().map(|[time, before, after]| Pairs { time, before, after }).collect();
    gain_interval::gain(&pairs)
}

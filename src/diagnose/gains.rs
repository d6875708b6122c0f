//! What effects gain on data held out, step by step from the nominal to the extended model.
//!
//! ```text
//!   E_k: RMS torque error of the joints of effect k with effects 1 … k in the model, the strongest first;  E_0: of the nominal model
//!   gain_k = (E_{k−1} − E_k)/E_0
//! ```
//! The gains of one joint's effects add up to the joint's own gain. Errors of joints are taken relative to the RMS torque of each joint
//! where several are judged together. Rows far out (a link that floats, a knock) are clipped at [`CLIPPED`] robust standard deviations of the
//! nominal error, before and after alike: single rows of most of the squared error would say how they are explained, and nothing of the
//! rest. The interval is that of [`Gain`]. An effect also has to gain beside all others, wherever it stands in
//! the order: with its columns against a fit without them.

use std::collections::BTreeMap;

use super::problem::{Part, Problem, Term};
use super::regression::NU;
use super::result::EffectGain;
use super::selection::Selection;
use super::views;
use crate::effects::Motion;
use crate::replay::{Gain, Pairs};

/// What the gains of torque are of.
pub const TORQUE: &str = "torque";

/// Residuals of one stage: `residuals[joint][row]`.
type Residuals = Vec<Vec<f64>>;

/// What a term gains.
#[derive(Debug, Clone)]
pub struct TermGain {
    /// Its step from the nominal to the extended model.
    pub step: EffectGain,
    /// Its gain beside all other terms.
    pub beside_others: Gain,
}

impl TermGain {
    /// Whether both gains exceed chance.
    pub fn shown(&self) -> bool {
        self.step.shown() && self.beside_others.shown
    }
}

/// Gains of the terms of a selection, in the order of [`Selection::terms`]; `strength` puts them in order, and the first `given` of them
/// belong to the nominal model. `None` where a part of the terms cannot be fitted.
pub fn of_terms(problem: &Problem, selection: &Selection, given: usize, strength: &[f64]) -> Option<Vec<TermGain>> {
    let terms = selection.terms();
    let judge = Judge::new(problem, &selection.as_recorded);
    let mut order: Vec<usize> = (given..terms.len()).collect();
    order.sort_by(|a, b| strength[*b].total_cmp(&strength[*a]));
    let all = residuals_with(problem, &terms, &selection.fitted);
    let mut gains: Vec<TermGain> = terms.iter().map(|_| TermGain::none()).collect();
    let mut before: Residuals = selection.nominal.residuals.clone();
    for (position, index) in order.iter().enumerate() {
        let joints = &terms[*index].joints;
        let so_far = |other: usize| other < given || order[..=position].contains(&other);
        let after = if position + 1 == order.len() { all.clone() } else { fitted_with(problem, &terms, &so_far)? };
        let without = fitted_with(problem, &terms, &|other| other != *index)?;
        gains[*index] = TermGain {
            step: judge.step(joints, [&before, &after]),
            beside_others: judge.compared(joints, [&without, &all]),
        };
        before = after;
    }
    Some(gains)
}

impl TermGain {
    /// Of what belongs to the nominal model.
    fn none() -> Self {
        Self { step: EffectGain::of(Gain::default(), TORQUE), beside_others: Gain::default() }
    }
}

fn residuals_with(problem: &Problem, terms: &[&Term], fitted: &super::problem::Fitted) -> Residuals {
    (0..problem.baseline.len()).map(|joint| views::residual(problem, terms, fitted, joint)).collect()
}

fn fitted_with(problem: &Problem, terms: &[&Term], picked: &dyn Fn(usize) -> bool) -> Option<Residuals> {
    let picked: Vec<&Term> = (0..terms.len()).filter(|index| picked(*index)).map(|index| terms[index]).collect();
    let fitted = problem.fit(&picked, Part::Train, NU)?;
    Some(residuals_with(problem, &picked, &fitted))
}

/// [1] Robust standard deviations at which errors are clipped: no wave reaches that.
const CLIPPED: f64 = 4.0;

/// Judges residuals on held-out rows against those of the nominal model.
pub struct Judge<'p, 'm> {
    problem: &'p Problem<'m>,
    nominal: &'p Residuals,
    /// [N·m or N] RMS torque of each joint.
    torque: Vec<f64>,
    /// [N·m or N] at which errors of each joint are clipped.
    limit: Vec<f64>,
}

impl<'p, 'm> Judge<'p, 'm> {
    /// Against these residuals of the nominal model.
    pub fn new(problem: &'p Problem<'m>, nominal: &'p Residuals) -> Self {
        let of_joint = |joint: usize| {
            let rows = problem.judged_rows(joint, Part::HeldOut);
            let torque = &problem.motion.joints[joint].torque;
            let power: f64 = rows.iter().map(|row| torque[*row].powi(2)).sum();
            let mut errors: Vec<f64> = rows.iter().map(|row| nominal[joint][*row].abs()).collect();
            // Of a normal variable the median of the magnitude is 0.6745 of the standard deviation.
            let middle = errors.len() / 2;
            let median = if errors.is_empty() { 0.0 } else { *errors.select_nth_unstable_by(middle, f64::total_cmp).1 };
            ((power / rows.len().max(1) as f64).sqrt().max(1e-300), CLIPPED * median / 0.6745)
        };
        let (torque, limit) = (0..problem.baseline.len()).map(of_joint).unzip();
        Self { problem, nominal, torque, limit }
    }

    /// The gain of one step on some joints, in parts of the error of the nominal model.
    pub fn step(&self, joints: &[usize], [before, after]: [&Residuals; 2]) -> EffectGain {
        let gain = self.compared(joints, [before, after]);
        let error = |residuals: &Residuals, joints: &[usize]| {
            self.pooled(joints, residuals).iter().map(|e| e * e).sum::<f64>().sqrt()
        };
        let share = |joints: &[usize]| error(before, joints) / error(self.nominal, joints).max(1e-300);
        let of_joint = |joint: &usize| {
            let own = self.compared(&[*joint], [before, after]).gain_percent * share(&[*joint]);
            (self.problem.motion.model.joints[*joint].name.clone(), own)
        };
        let part = share(joints);
        EffectGain {
            gain_percent: part * gain.gain_percent,
            gain_interval_percent: gain.interval_percent.map(|end| part * end),
            gain_of: TORQUE.to_owned(),
            gain_by_joint: joints.iter().map(of_joint).collect::<BTreeMap<_, _>>(),
        }
    }

    /// The gain of one set of residuals over another on some joints.
    pub fn compared(&self, joints: &[usize], [before, after]: [&Residuals; 2]) -> Gain {
        let rows = self.rows(joints);
        of_rows(&self.problem.motion, &rows, [&self.pooled(joints, before), &self.pooled(joints, after)])
    }

    /// Held-out rows in which a joint of these is judged.
    fn rows(&self, joints: &[usize]) -> Vec<usize> {
        let Problem { held_out, judged, .. } = self.problem;
        let picked = |row: &usize| held_out[*row] && joints.iter().any(|joint| judged[*joint][*row]);
        (0..self.problem.motion.rows()).filter(picked).collect()
    }

    /// `√Σ (e/s)²` of each held-out row over the joints that are judged there, `s` the RMS torque of the joint.
    fn pooled(&self, joints: &[usize], residuals: &Residuals) -> Vec<f64> {
        let of_row = |row: &usize| {
            let judged = joints.iter().filter(|joint| self.problem.judged[**joint][*row]);
            let size = |joint: &usize| residuals[*joint][*row].abs().min(self.limit[*joint]) / self.torque[*joint];
            judged.map(|joint| size(joint).powi(2)).sum::<f64>().sqrt()
        };
        self.rows(joints).iter().map(of_row).collect()
    }
}

/// The gain over rows of a motion, from the errors without and with an effect, one each a row.
pub fn of_rows(motion: &Motion, rows: &[usize], [before, after]: [&[f64]; 2]) -> Gain {
    let mut sessions: Vec<[Vec<f64>; 3]> = vec![<[Vec<f64>; 3]>::default(); motion.sessions];
    for ((row, before), after) in rows.iter().zip(before).zip(after) {
        let [time, befores, afters] = &mut sessions[motion.session[*row]];
        time.push(motion.time[*row]);
        befores.push(*before);
        afters.push(*after);
    }
    let pairs: Vec<Pairs> = sessions.iter().map(|[time, before, after]| Pairs { time, before, after }).collect();
    Gain::of(&pairs)
}

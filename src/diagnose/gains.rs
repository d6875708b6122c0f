//! What effects gain on data held out, step by step from the nominal to the extended model.
//!
//! ```text
//!   E_k: RMS torque error of the joints of effect k with effects 1 … k in the model, the strongest first;  E_0: of the nominal model
//!   gain_k = (E_{k−1} − E_k)/E_0
//! ```
//! The gains of one joint's effects add up to the joint's own gain. Errors of joints are taken relative to the RMS torque of each joint
//! where several are judged together. The interval is that of [`Gain`]. An effect also has to gain beside all others, wherever it stands in
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
    let mut order: Vec<usize> = (given..terms.len()).collect();
    order.sort_by(|a, b| strength[*b].total_cmp(&strength[*a]));
    let all = residuals_with(problem, &terms, &selection.fitted);
    let mut gains: Vec<TermGain> = terms.iter().map(|_| TermGain::none()).collect();
    let mut before: Residuals = selection.nominal.residuals.clone();
    let nominal = &selection.as_recorded;
    for (position, index) in order.iter().enumerate() {
        let joints = &terms[*index].joints;
        let so_far = |other: usize| other < given || order[..=position].contains(&other);
        let after = if position + 1 == order.len() { all.clone() } else { fitted_with(problem, &terms, &so_far)? };
        let without = fitted_with(problem, &terms, &|other| other != *index)?;
        gains[*index] = TermGain {
            step: step(problem, joints, nominal, [&before, &after]),
            beside_others: compared(problem, joints, [&without, &all]),
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

/// The gain of one step on some joints, in parts of the error of the nominal model.
pub fn step(problem: &Problem, joints: &[usize], nominal: &Residuals, [before, after]: [&Residuals; 2]) -> EffectGain {
    let gain = compared(problem, joints, [before, after]);
    let error = |residuals: &Residuals, joints: &[usize]| {
        pooled(problem, joints, residuals).iter().map(|e| e * e).sum::<f64>().sqrt()
    };
    let share = |joints: &[usize]| error(before, joints) / error(nominal, joints).max(1e-300);
    let of_joint = |joint: &usize| {
        let own = compared(problem, &[*joint], [before, after]).gain_percent * share(&[*joint]);
        (problem.motion.model.joints[*joint].name.clone(), own)
    };
    let part = share(joints);
    EffectGain {
        gain_percent: part * gain.gain_percent,
        gain_interval_percent: gain.interval_percent.map(|end| part * end),
        gain_of: TORQUE.to_owned(),
        gain_by_joint: joints.iter().map(of_joint).collect::<BTreeMap<_, _>>(),
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

/// Held-out rows in which a joint of these is judged.
fn rows(problem: &Problem, joints: &[usize]) -> Vec<usize> {
    let judged = |row: &usize| problem.held_out[*row] && joints.iter().any(|joint| problem.judged[*joint][*row]);
    (0..problem.motion.rows()).filter(judged).collect()
}

/// `√Σ (e/s)²` of each held-out row over the joints that are judged there, `s` the RMS torque of the joint.
fn pooled(problem: &Problem, joints: &[usize], residuals: &Residuals) -> Vec<f64> {
    let scale = |joint: &usize| {
        let rows = problem.judged_rows(*joint, Part::HeldOut);
        let torque = &problem.motion.joints[*joint].torque;
        let power: f64 = rows.iter().map(|row| torque[*row].powi(2)).sum();
        (power / rows.len().max(1) as f64).sqrt().max(1e-300)
    };
    let scales: Vec<f64> = joints.iter().map(scale).collect();
    let of_row = |row: &usize| {
        let judged = joints.iter().zip(&scales).filter(|(joint, _)| problem.judged[**joint][*row]);
        judged.map(|(joint, scale)| (residuals[*joint][*row] / scale).powi(2)).sum::<f64>().sqrt()
    };
    rows(problem, joints).iter().map(of_row).collect()
}

/// The gain of one set of residuals over another on held-out rows of some joints.
pub fn compared(problem: &Problem, joints: &[usize], [before, after]: [&Residuals; 2]) -> Gain {
    let rows = rows(problem, joints);
    of_rows(&problem.motion, &rows, [&pooled(problem, joints, before), &pooled(problem, joints, after)])
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

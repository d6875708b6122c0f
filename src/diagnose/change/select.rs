//! Selection of the changes that the evidence supports.
//!
//! Both recordings share one baseline and the effects of the reference. Possible changes are tried in the rows of now only,
//! the strongest is taken, and the rest is tried again. A term that explains the data equally well when it acts in both recordings is no
//! change: it is an error of the model that the reference did not show well enough. At the end a change has to exceed the variation of the
//! same quantity between sessions of the healthy machine.

use crate::diagnose::fit::cause::Cause;
use std::ops::Range;

use super::quantity;
use super::quantity::QUANTITIES;
use super::robust::Estimates;
use crate::diagnose::evidence::prediction::{Evidence, predict};
use crate::diagnose::fit::problem::{Fitted, Problem};
use crate::diagnose::fit::term::Term;
use crate::diagnose::options::Rules;
use crate::diagnose::select::candidates::choose;
use crate::diagnose::select::candidates::{Candidate, candidates};
use crate::diagnose::select::selection::Taken;
use crate::effects::Catalogue;
use crate::robot::Masses;

/// [1] Least fall of the error by a change, relative to the usual limit: a change acts in the rows of now only.
const SHARE: f64 = 0.25;
/// [nats] Evidence by which an effect has to be better as a change than as an effect in both recordings.
const MARGIN: f64 = 3.0;
/// Standard errors that a change has to exceed: one in 370 does by chance, and about twenty are tried.
pub const SURE: f64 = 3.0;

/// Shared terms, changes, and their fit.
pub struct Changes {
    /// Terms of both sides.
    pub shared: Vec<Term>,
    /// Changes in the order of selection.
    pub taken: Vec<Taken>,
    /// Candidates of the first round.
    pub first_round: Vec<Candidate>,
    /// Estimates with all terms, `shared` first.
    pub estimates: Estimates,
}

impl Changes {
    /// The same with further changes at the end, and the estimates that include them.
    pub fn with(&self, terms: Vec<Term>, estimates: Estimates) -> Self {
        let mut taken = self.taken.clone();
        let evidence = vec![Evidence::default(); estimates.fitted.baseline_at.len()];
        taken.push(Taken { terms, evidence, rivals: Vec::new() });
        Self { shared: self.shared.clone(), taken, first_round: self.first_round.clone(), estimates }
    }

    /// All terms, shared ones first.
    pub fn terms(&self) -> Vec<&Term> {
        all(&self.shared, &self.taken)
    }
}

fn all<'t>(shared: &'t [Term], taken: &'t [Taken]) -> Vec<&'t Term> {
    shared.iter().chain(taken.iter().flat_map(|taken| &taken.terms)).collect()
}

/// Sessions of both recordings.
pub struct Sides {
    /// Sessions of the healthy machine.
    pub reference: Range<usize>,
    /// Sessions to be compared with it, held-out sessions included.
    pub now: Range<usize>,
}

/// Changes of every effect and every quantity of the baseline between the recordings; without inertias where masses are estimated.
pub fn causes(known: &Catalogue, masses: Masses, sides: &Sides) -> Vec<Cause> {
    let told = QUANTITIES.iter().filter(|quantity| masses == Masses::Known || quantity.is_of_baseline());
    let effects = known.diagnosable().filter(|effect| effect.can_change() && quantity::find(effect.name()).is_none());
    let mut causes: Vec<Cause> = told.map(Cause::from).chain(effects.map(Cause::from)).collect();
    causes.sort_by_key(|cause| cause.name());
    causes.into_iter().map(|cause| Cause::change(cause, sides.now.clone())).collect()
}

/// Selects changes one after the other; `None` where nothing can be fitted.
pub fn select(
    problem: &mut Problem,
    mut shared: Vec<Term>,
    rules: &Rules,
    progress: &mut dyn FnMut(&str, f64),
) -> Option<Changes> {
    let mut taken: Vec<Taken> = Vec::new();
    let mut first_round = Vec::new();
    let mut fitted = resettle(problem, &mut shared, &mut taken)?;
    let rules = Rules { log_scale: SHARE * rules.log_scale, ..*rules };
    for round in 0..=rules.most {
        progress("trying changes", 0.4 + 0.4 * round as f64 / (rules.most + 1) as f64);
        problem.count_independent(&fitted);
        let terms: Vec<Term> = all(&shared, &taken).into_iter().cloned().collect();
        let found = candidates(problem, &terms, &rules);
        if round == 0 {
            first_round = outlines(found.iter());
        }
        let Some(best) = choose(&found, &rules) else { break };
        if round == rules.most {
            break;
        }
        match always_was(problem, &terms, best) {
            Some(before) => shared.extend(before),
            None => {
                let rivals = outlines(found.iter().filter(|other| other.effect() != best.effect()));
                taken.push(Taken { terms: best.terms.clone(), evidence: best.evidence.clone(), rivals });
            }
        }
        fitted = resettle(problem, &mut shared, &mut taken)?;
    }
    problem.count_independent(&fitted);
    prune(problem, &mut shared, &mut taken, &rules)?;
    let estimates = Estimates::new(problem, &all(&shared, &taken))?;
    Some(Changes { shared, taken, first_round, estimates })
}

/// Candidates for the report, without the values of their columns: all columns together would take a hundred megabytes.
fn outlines<'c>(candidates: impl Iterator<Item = &'c Candidate>) -> Vec<Candidate> {
    let outline = |term: &Term| Term {
        effect: term.effect,
        joints: term.joints.clone(),
        shape: term.shape.clone(),
        free_shapes: term.free_shapes,
        columns: term.columns.iter().map(|of_joint| vec![Vec::new(); of_joint.len()]).collect(),
        near: term.near.clone(),
    };
    let of_candidate = |candidate: &Candidate| Candidate {
        terms: candidate.terms.iter().map(outline).collect(),
        evidence: candidate.evidence.clone(),
        choice: candidate.choice.clone(),
        oddity: candidate.oddity,
    };
    candidates.map(of_candidate).collect()
}

/// The same effect in all sessions, if that explains the data equally well: then it is no change.
fn always_was(problem: &Problem, terms: &[Term], best: &Candidate) -> Option<Vec<Term>> {
    // Quantities of the baseline are on both sides already.
    let effect = Some(best.effect().everywhere()).filter(|effect| quantity::find(effect.name()).is_none())?;
    let own: Vec<&Term> = terms.iter().collect();
    let before = predict(problem, &own)?;
    let everywhere: Vec<Term> =
        best.terms.iter().map(|term| Term::new(&problem.motion, effect, &term.joints, term.shape.clone())).collect();
    let with: Vec<&Term> = own.iter().copied().chain(&everywhere).collect();
    let total: f64 = predict(problem, &with)?.against(&before).iter().map(|evidence| evidence.nats).sum();
    (total > best.total() - MARGIN).then_some(everywhere)
}

/// Fits the baseline again with the terms, whose columns may depend on its friction.
pub fn resettle(problem: &mut Problem, shared: &mut [Term], taken: &mut [Taken]) -> Option<Fitted> {
    let mut fitted = None;
    for _ in 0..2 {
        fitted = Some(problem.settle(&all(shared, taken))?);
        for term in shared.iter_mut().chain(taken.iter_mut().flat_map(|taken| &mut taken.terms)) {
            *term = Term::new(&problem.motion, term.effect, &term.joints, term.shape.clone());
        }
    }
    fitted
}

/// Fits the rest again after a term was dropped.
pub fn refresh(problem: &mut Problem, changes: &mut Changes) -> Option<()> {
    resettle(problem, &mut changes.shared, &mut changes.taken)?;
    changes.estimates = Estimates::new(problem, &changes.terms())?;
    Some(())
}

/// Estimates beside the other changes of friction, on joints whose friction has changed. If only one change is named, the others are too
/// small to be seen, but the size of the named one must not include them.
pub fn estimates_beside_companions(problem: &Problem, changes: &Changes, sides: &Sides) -> Option<Estimates> {
    let terms = changes.terms();
    let taken = &terms[changes.shared.len()..];
    let is_friction = |term: &&&Term| quantity::find(term.effect.name()).is_some_and(|q| q.is_of_baseline());
    let mut companions: Vec<Term> = Vec::new();
    for joint in problem.joints() {
        let of_joint: Vec<&str> = taken
            .iter()
            .filter(is_friction)
            .filter(|term| term.joints[0] == joint)
            .map(|term| term.effect.name())
            .collect();
        if of_joint.is_empty() {
            continue;
        }
        let missing = quantity::levels().map(|quantity| Cause::change(quantity, sides.now.clone()));
        let missing = missing.filter(|effect| !of_joint.contains(&effect.name()));
        companions.extend(missing.map(|effect| Term::new(&problem.motion, effect, &[joint], Vec::new())));
    }
    Estimates::new(problem, &terms.into_iter().chain(&companions).collect::<Vec<_>>())
}

/// Drops changes that the others make superfluous, the weakest first.
fn prune(problem: &mut Problem, shared: &mut [Term], taken: &mut Vec<Taken>, rules: &Rules) -> Option<()> {
    while taken.len() > 1 {
        let after = predict(problem, &all(shared, taken))?;
        let beside = |index: usize| {
            let others = taken.iter().enumerate().filter(|(other, _)| *other != index);
            let terms: Vec<&Term> = shared.iter().chain(others.flat_map(|(_, taken)| &taken.terms)).collect();
            let evidence = after.against(&predict(problem, &terms)?);
            Some(evidence.iter().map(|evidence| evidence.nats).sum::<f64>())
        };
        let weakest =
            (0..taken.len()).filter_map(|index| Some((index, beside(index)?))).min_by(|a, b| a.1.total_cmp(&b.1));
        match weakest {
            Some((index, total)) if total < rules.nats => {
                taken.remove(index);
            }
            _ => return Some(()),
        }
        resettle(problem, shared, taken)?;
    }
    Some(())
}

//! Selection of effects by evidence: the strongest candidate is taken, the baseline is fitted again, and the rest is tried again. An effect
//! that later ones make superfluous is dropped, and an effect is exchanged for another that predicts better in its place.
//!
//! An effect has to gain [`Rules::nats`] of likelihood on training rows that were not used for its fit, and lower the error scale by
//! [`Rules::log_scale`]; beside another effect it needs [`Rules::further`], unless the fall is large. Of effects within [`Rules::tie`] the one with
//! fewer parameters is taken. Held-out data are not used.

use super::candidates::{Candidate, candidates, choose};
use super::masked::masked;
use super::residues::{Residue, drop_residues, restore};
use crate::diagnose::evidence::local_level::count_lines;
use crate::diagnose::evidence::prediction::{Evidence, predict, prediction, weighed};
use crate::diagnose::fit::baseline::JointBaseline;
use crate::diagnose::fit::inertial::Treated;
use crate::diagnose::fit::problem::{Fitted, Part, Problem};
use crate::diagnose::fit::regression::NU;
use crate::diagnose::fit::term::Term;
use crate::diagnose::options::{Inaccuracy, Rules};
use crate::diagnose::result::Withdrawn;
use crate::effects::SymmetricFriction;

/// An effect that was taken.
#[derive(Clone)]
pub struct Taken {
    /// Its terms, with their final shapes.
    pub terms: Vec<Term>,
    /// Evidence per joint when it was taken.
    pub evidence: Vec<Evidence>,
    /// Other candidates of that round, by decreasing evidence.
    pub rivals: Vec<Candidate>,
}

impl Taken {
    /// A candidate, with the others of its round as rivals.
    pub fn new(best: &Candidate, found: &[Candidate]) -> Self {
        let rivals = found.iter().filter(|other| other.effect() != best.effect()).cloned().collect();
        Self { terms: best.terms.clone(), evidence: best.evidence.clone(), rivals }
    }
}

impl Taken {
    /// Whether a candidate is the same effect on the same joints.
    fn is(&self, candidate: &Candidate) -> bool {
        let joints = self.terms.iter().flat_map(|term| &term.joints);
        candidate.effect() == self.terms[0].effect && candidate.joints().iter().eq(joints)
    }

    /// What its evidence has to exceed.
    pub fn inaccuracy(&self, rules: &Rules) -> Inaccuracy {
        rules.inaccuracy(self.terms[0].effect.about())
    }
}

/// Largest number of passes of adding and exchanging effects.
const PASSES: usize = 3;

/// Result of a selection.
pub struct Selection {
    /// Effects in the order in which they were taken.
    pub taken: Vec<Taken>,
    /// Candidates of the first round, each alone beside the baseline.
    pub first_round: Vec<Candidate>,
    /// The fit with all of them.
    pub fitted: Fitted,
    /// The nominal model before any effect was tried.
    pub nominal: Nominal,
    /// Residuals of the nominal model on the original recordings: those of [`nominal`](Self::nominal), unless the recordings were corrected
    /// before the selection.
    pub as_recorded: Vec<Vec<f64>>,
    /// Effects in whose place a shape without physics was found, see [`substitutes`](super::substitutes).
    pub replaced: Vec<Withdrawn>,
    /// What was dropped beside others.
    pub residues: Vec<Residue>,
}

/// The nominal model with its free parameters fitted by plain least squares, which gives its smallest RMS error.
#[derive(Debug, Clone)]
pub struct Nominal {
    /// Residual of every row: `residuals[joint][row]` [N·m or N].
    pub residuals: Vec<Vec<f64>>,
    /// Friction of each joint.
    pub friction: Vec<SymmetricFriction>,
    /// [kg·m²] Inertia of each rotor at the motor shaft that the model file does not give, where it is above zero.
    pub rotors: Vec<Option<f64>>,
}

impl Nominal {
    /// For a problem with Stribeck velocities fitted to the baseline alone; `None` where it cannot be fitted.
    pub fn new(problem: &Problem) -> Option<Self> {
        let fitted = problem.fit(&[], Part::Train, f64::INFINITY)?;
        let coefficients = fitted.solution.coefficients.as_slice();
        let friction =
            |(baseline, at): (&JointBaseline, &usize)| baseline.friction(&coefficients[*at..*at + baseline.len()]);
        Some(Self {
            residuals: (0..problem.baseline.len()).map(|joint| problem.residual(&[], &fitted, joint)).collect(),
            friction: problem.baseline.iter().zip(&fitted.baseline_at).map(friction).collect(),
            rotors: problem.rotors(&fitted),
        })
    }
}

impl Selection {
    /// All terms.
    pub fn terms(&self) -> Vec<&Term> {
        terms_of(&self.taken)
    }

    /// Fits what is left after an effect was removed.
    pub fn settle(&mut self, problem: &mut Problem) -> Option<()> {
        let of_nominal = self.as_recorded == self.nominal.residuals;
        self.fitted = settled(problem, &mut self.taken, &mut self.nominal)?;
        if of_nominal {
            self.as_recorded.clone_from(&self.nominal.residuals);
        }
        Some(())
    }
}

/// All terms of some effects.
pub fn terms_of(taken: &[Taken]) -> Vec<&Term> {
    taken.iter().flat_map(|taken| &taken.terms).collect()
}

/// Selects effects; `progress` receives the current step and the finished share.
pub fn select(problem: &mut Problem, rules: &Rules, progress: &mut dyn FnMut(&str, f64)) -> Option<Selection> {
    let mut taken: Vec<Taken> = Vec::new();
    let mut first_round = Vec::new();
    let mut fitted = resettle(problem, &mut taken)?;
    let mut nominal = Nominal::new(problem)?;
    // Add effects, then exchange earlier ones that a later effect made worse than a rival; repeat if that changed anything.
    for pass in 0..PASSES {
        while taken.len() <= rules.most {
            progress("trying effects", (pass + taken.len()).min(rules.most) as f64 / (rules.most + 1) as f64);
            let terms: Vec<Term> = taken.iter().flat_map(|taken| taken.terms.clone()).collect();
            problem.count_independent(&fitted);
            let found = candidates(problem, &terms, rules);
            if first_round.is_empty() {
                first_round.clone_from(&found);
            }
            match choose(&found, rules) {
                Some(best) if taken.len() < rules.most => taken.push(Taken::new(best, &found)),
                None if taken.len() + 2 <= rules.most => match masked(problem, &taken, rules) {
                    Some(pair) => taken.extend(pair),
                    None => break,
                },
                _ => break,
            }
            fitted = resettle(problem, &mut taken)?;
        }
        let before = taken.len();
        let explained = prune(problem, rules, &mut taken);
        join(&mut taken);
        let fewer_joints = prune_joints(problem, rules, &mut taken)?;
        if taken.len() == 1 && (before > 1 || fewer_joints) {
            fitted = resettle(problem, &mut taken)?;
            problem.count_independent(&fitted);
            judge_again(problem, rules, &mut taken, &explained, false);
        }
        if taken.len() < 2 || !judge_again(problem, rules, &mut taken, &explained, true) {
            break;
        }
        fitted = resettle(problem, &mut taken)?;
    }
    // Weak effects beside another are accepted during the passes, because they affect the fit, but are removed at the end.
    prune(problem, &rules.beside_another(), &mut taken);
    let residues = drop_residues(problem, rules, &mut taken)?;
    let fitted = settled(problem, &mut taken, &mut nominal)?;
    problem.count_independent(&fitted);
    let as_recorded = nominal.residuals.clone();
    Some(Selection { taken, first_round, fitted, nominal, as_recorded, replaced: Vec::new(), residues })
}

/// Takes what was dropped beside effects that were withdrawn since, and further effects where room is left; returns whether any was taken.
pub fn select_further(problem: &mut Problem, selection: &mut Selection, rules: &Rules) -> Option<bool> {
    problem.free();
    let mut any = restore(&mut selection.residues, &mut selection.taken);
    while selection.taken.len() < rules.most {
        let terms: Vec<Term> = selection.terms().into_iter().cloned().collect();
        let fitted = resettle(problem, &mut selection.taken)?;
        problem.count_independent(&fitted);
        let found = candidates(problem, &terms, rules);
        let Some(best) = choose(&found, rules) else { break };
        selection.taken.push(Taken::new(best, &found));
        any = true;
    }
    if any {
        resettle(problem, &mut selection.taken)?;
        prune(problem, &rules.beside_another(), &mut selection.taken);
        join(&mut selection.taken);
        let residues = drop_residues(problem, rules, &mut selection.taken)?;
        selection.residues.extend(residues);
    }
    selection.settle(problem)?;
    problem.count_independent(&selection.fitted);
    Some(any)
}

/// The final fit of what was taken. The nominal model deviates as in that fit, within its stated accuracy, in all that follows: also where
/// it is judged without an effect, whose part the deviations could otherwise take over.
fn settled(problem: &mut Problem, taken: &mut [Taken], nominal: &mut Nominal) -> Option<Fitted> {
    problem.free();
    let fitted = resettle(problem, taken)?;
    if fitted.inertial == Treated::Fixed {
        return Some(fitted);
    }
    problem.deviate_beside(&terms_of(taken), &fitted);
    let fitted = resettle(problem, taken)?;
    problem.hold(&fitted);
    problem.settle(&[])?;
    *nominal = Nominal::new(problem)?;
    resettle(problem, taken)
}

/// Joins the terms of an effect that was taken joint by joint: its rivals are effects that explain all of its joints.
fn join(taken: &mut Vec<Taken>) {
    let mut joined: Vec<Taken> = Vec::with_capacity(taken.len());
    for one in taken.drain(..) {
        let effect = one.terms[0].effect;
        let same = |other: &&mut Taken| other.terms[0].effect == effect && !effect.several();
        match joined.iter_mut().find(same) {
            None => joined.push(one),
            Some(first) => {
                for joint in one.terms.iter().flat_map(|term| &term.joints) {
                    first.evidence[*joint] = one.evidence[*joint];
                }
                first.terms.extend(one.terms);
            }
        }
    }
    *taken = joined;
}

/// Judges each taken effect and its rivals again beside the others. With `exchange`, the first one in whose place another effect predicts
/// better is replaced by that effect; returns whether one was. The new search may find less of the effect than was taken, such as a line at
/// another order on fewer joints: what was taken counts. What the others `explained` is no rival.
fn judge_again(problem: &mut Problem, rules: &Rules, taken: &mut [Taken], explained: &[Taken], exchange: bool) -> bool {
    for index in 0..taken.len() {
        let effect = taken[index].terms[0].effect;
        let others: Vec<Term> = taken
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != index)
            .flat_map(|(_, taken)| taken.terms.clone())
            .collect();
        let mut found = candidates(problem, &others, rules);
        let of_others = |candidate: &Candidate| others.iter().any(|term| term.effect == candidate.effect());
        let is_explained = |candidate: &Candidate| explained.iter().any(|one| one.is(candidate));
        found.retain(|candidate| candidate.effect() == effect || !of_others(candidate) && !is_explained(candidate));
        let Some(best) = choose(&found, rules) else { continue };
        let own = found.iter().find(|candidate| candidate.effect() == effect && candidate.is_accepted(rules));
        let of_taken = evidence_beside(problem, taken, index, taken[index].inaccuracy(rules));
        let better = |nats: Option<f64>| nats.is_none_or(|nats| best.total() > nats);
        let is_better = || better(own.map(Candidate::total)) && better(of_taken.as_deref().map(total));
        if exchange && best.effect() != effect && is_better() {
            taken[index] = Taken::new(best, &found);
            return true;
        }
        if let Some(own) = own {
            let mut renewed = Taken { terms: taken[index].terms.clone(), ..Taken::new(own, &found) };
            renewed.evidence = of_taken.filter(|taken| total(taken) > own.total()).unwrap_or(renewed.evidence);
            taken[index] = renewed;
        }
    }
    false
}

/// Fits the baseline again with what was taken, until the fit is near itself.
pub fn resettle(problem: &mut Problem, taken: &mut [Taken]) -> Option<Fitted> {
    let mut terms: Vec<&mut Term> = taken.iter_mut().flat_map(|taken| &mut taken.terms).collect();
    let last = problem.fit_near_itself(&mut terms, |problem, terms, _| problem.settle(terms))?;
    problem.fit(&terms_of(taken), Part::Train, NU).or(Some(last))
}

/// Evidence of one effect beside all others, beyond the inaccuracy of the laws.
pub fn evidence_beside(
    problem: &Problem,
    taken: &[Taken],
    index: usize,
    inaccuracy: Inaccuracy,
) -> Option<Vec<Evidence>> {
    let all = terms_of(taken);
    let others: Vec<&Term> =
        taken.iter().enumerate().filter(|(other, _)| *other != index).flat_map(|(_, taken)| &taken.terms).collect();
    let with = problem.fit_loosely(&all, Part::Train)?;
    let pair = [&predict(problem, &others)?, &prediction(problem, &all, &with)?];
    let mut evidence = weighed(problem, &others, &with, pair, inaccuracy)?;
    let first = taken[..index].iter().map(|taken| taken.terms.len()).sum::<usize>();
    count_lines(problem, &all, &with, first..first + taken[index].terms.len(), &mut evidence);
    Some(evidence)
}

/// [nats] Evidence on all joints.
fn total(evidence: &[Evidence]) -> f64 {
    evidence.iter().map(|evidence| evidence.nats).sum()
}

/// Drops joints of effects that have little evidence beside the other joints of the same effect: each was found alone, and what the nominal
/// model's deviations share may have moved from one joint to another. Returns whether any was dropped.
fn prune_joints(problem: &mut Problem, rules: &Rules, taken: &mut [Taken]) -> Option<bool> {
    let mut any = false;
    while let Some((index, term)) = superfluous_joint(problem, rules, taken) {
        taken[index].terms.remove(term);
        problem.settle(&terms_of(taken))?;
        any = true;
    }
    Some(any)
}

/// Effect and term of the joint with the least evidence of its own, if that is too little.
fn superfluous_joint(problem: &Problem, rules: &Rules, taken: &[Taken]) -> Option<(usize, usize)> {
    let mut weakest: Option<(usize, usize, f64)> = None;
    for (index, several) in taken.iter().enumerate().filter(|(_, taken)| taken.terms.len() > 1) {
        let of_all = evidence_beside(problem, taken, index, several.inaccuracy(rules))?;
        for (place, term) in several.terms.iter().enumerate() {
            if term.joints.iter().map(|joint| of_all[*joint].nats).sum::<f64>() > rules.nats {
                continue;
            }
            let mut parted = taken.to_vec();
            let one = parted[index].terms.remove(place);
            parted.push(Taken { terms: vec![one], ..several.clone() });
            let nats = total(&evidence_beside(problem, &parted, taken.len(), several.inaccuracy(rules))?);
            if nats <= rules.nats && weakest.is_none_or(|(_, _, least)| nats < least) {
                weakest = Some((index, place, nats));
            }
        }
    }
    weakest.map(|(index, place, _)| (index, place))
}

/// Drops effects that the others make superfluous, the weakest first. Returns those that the others explain: each of these has evidence beside the
/// dropped one too, which had none beside them.
fn prune(problem: &mut Problem, rules: &Rules, taken: &mut Vec<Taken>) -> Vec<Taken> {
    let mut explained = Vec::new();
    while taken.len() > 1 {
        let beside = |index| evidence_beside(problem, taken, index, taken[index].inaccuracy(rules));
        let mut judged: Vec<(usize, f64, bool)> = (0..taken.len())
            .filter_map(|index| Some((index, supported(rules, &beside(index)?))))
            .map(|(index, (nats, is_supported))| (index, nats, is_supported))
            .collect();
        judged.sort_by(|a, b| a.1.total_cmp(&b.1));
        let Some((&(weakest, _, false), others)) = judged.split_first() else { break };
        let dropped = taken.remove(weakest);
        if others.iter().all(|(_, _, is_supported)| *is_supported) {
            explained.push(dropped);
        }
        if resettle(problem, taken).is_none() {
            break;
        }
    }
    explained
}

/// Evidence on all joints [nats], and whether it supports an effect.
fn supported(rules: &Rules, evidence: &[Evidence]) -> (f64, bool) {
    let log_scale = evidence.iter().map(|e| e.log_scale).fold(f64::NEG_INFINITY, f64::max);
    (total(evidence), rules.support(total(evidence), log_scale))
}

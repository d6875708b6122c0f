//! Candidates: each effect of the catalogue where it can act, with its best shape and its evidence.

use rayon::prelude::*;

use self::judged::together;
use super::oddity::Oddity;
use crate::diagnose::evidence::prediction::{Evidence, Prediction, prediction};
use crate::diagnose::fit::cause::Cause;
use crate::diagnose::fit::golden::golden_section;
use crate::diagnose::fit::inertial::Treated;
use crate::diagnose::fit::problem::{Fitted, Part, Problem};
use crate::diagnose::fit::scanned::Scanned;
use crate::diagnose::fit::term::Term;
use crate::diagnose::options::{Inaccuracy, MODEL_ERROR, Rules};
use crate::effects::Scope;

/// [1] Share of the evidence below which a rival is rejected even if its error is as small.
pub const FAR: f64 = 0.3;
/// Number of shapes that are fitted in full after a scan.
const SHORTLIST: usize = 3;
/// Above this many shapes, pre-select by the score test.
const MANY_SHAPES: usize = 6;
/// [nats, rows taken as independent] Training gain below which a candidate is not cross-validated.
const LEAST_GAIN: f64 = 10.0;
/// Approximate number of rows for a scan of many shapes.
const SCANNED_ROWS: usize = 2500;
/// Steps in which a shape is adapted to the coefficients: each step squares the relative error.
const IMPROVEMENTS: usize = 3;
/// Steps of the golden section that refines a shape.
const REFINEMENTS: usize = 12;

/// An effect on one or several joints, with its evidence.
#[derive(Clone)]
pub struct Candidate {
    /// One term per joint for an effect of a joint, one term in all for an effect of the machine.
    pub terms: Vec<Term>,
    /// Evidence on each joint of the model.
    pub evidence: Vec<Evidence>,
    /// [nats] What the choice among shapes cost each joint, in its evidence.
    pub choice: Vec<f64>,
    /// What keeps it from being the effect that it is called.
    pub oddity: Option<Oddity>,
}

impl Candidate {
    /// Whether it is the effect that it is called.
    pub const fn is_sensible(&self) -> bool {
        self.oddity.is_none()
    }

    /// The effect.
    pub fn effect(&self) -> Cause {
        self.terms[0].effect
    }

    /// [nats] Evidence on all joints.
    pub fn total(&self) -> f64 {
        self.evidence.iter().map(|evidence| evidence.nats).sum()
    }

    /// Number of coefficients and free numbers of the shapes.
    pub fn complexity(&self) -> usize {
        self.terms.iter().map(Term::complexity).sum()
    }

    /// Joints that it acts on.
    pub fn joints(&self) -> Vec<usize> {
        self.terms.iter().flat_map(|term| term.joints.clone()).collect()
    }

    /// Whether it is one term of a single joint, which is judged with the nominal model's deviations as the other joints show them.
    fn is_of_one_joint(&self) -> bool {
        self.terms.len() == 1 && self.terms[0].joints.len() == 1
    }

    /// Whether the rules accept it.
    pub fn is_accepted(&self, rules: &Rules) -> bool {
        self.is_sensible() && rules.support(self.total(), self.log_scale())
    }

    /// [1] Largest logarithm by which its error exceeds that of another candidate on a joint on which one of them acts.
    fn worse_than(&self, other: &Self) -> f64 {
        let joints = self.joints().into_iter().chain(other.joints());
        joints.map(|joint| self.evidence[joint].worse_than(&other.evidence[joint])).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Largest fall of the error's logarithm on a joint.
    pub fn log_scale(&self) -> f64 {
        self.joints().iter().map(|joint| self.evidence[*joint].log_scale).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// What a term is worth. One that is the effect that it is called comes before any other: a mass on one link is a load, even where a negative one on another link
/// explains more.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Worth {
    /// Whether it is the effect that it is called.
    sensible: bool,
    /// [nats of rows] Training gain.
    gain: f64,
}

/// Search for the best term of one effect on given joints.
struct Search<'p, 'm> {
    problem: &'p Problem<'m>,
    terms: Vec<&'p Term>,
    fitted: &'p Fitted,
    /// Predictions without any candidate, by the joints that are fitted together.
    before: &'p [(Vec<usize>, Prediction)],
    /// What is evidence beside free deviations.
    rules: &'p Rules,
}

impl<'m> Search<'_, 'm> {
    /// The fit with one more term, for the joints where that changes anything.
    fn with(&self, term: &Term) -> Option<Fitted> {
        self.fitted_in(self.problem, term)
    }

    /// Does so with another friction law.
    fn fitted_in(&self, problem: &Problem, term: &Term) -> Option<Fitted> {
        let terms = self.and([term]);
        problem.fit_near(&problem.coupled(&terms, &term.joints), &terms, Part::Train, self.fitted)
    }

    /// The terms of the model and others.
    fn and<'t>(&'t self, others: impl IntoIterator<Item = &'t Term>) -> Vec<&'t Term> {
        self.terms.iter().copied().chain(others).collect()
    }

    /// What evidence for an effect has to exceed.
    fn inaccuracy(&self, effect: Cause) -> Inaccuracy {
        self.rules.inaccuracy(effect.about())
    }

    /// The prediction without a candidate on these joints.
    fn before(&self, joints: &[usize]) -> &Prediction {
        let together = self.problem.coupled(&self.terms, joints);
        let own = self.before.iter().find(|(of, _)| *of == together);
        &own.unwrap_or(&self.before[0]).1
    }

    /// What a term is worth; `None` where it cannot be fitted.
    fn worth(&self, term: &Term) -> Option<Worth> {
        self.worth_of(self.problem, term, &self.with(term)?)
    }

    /// What a term is worth in a fit of this problem that has it as the last one.
    fn worth_of(&self, problem: &Problem, term: &Term, fitted: &Fitted) -> Option<Worth> {
        let before = self.before(&term.joints);
        let after = &fitted.solution.log_likelihood;
        let of_rows: f64 = fitted.joints.iter().map(|joint| after[*joint] - before.training[*joint]).sum();
        let gain = of_rows + (before.prior_loss - fitted.prior_loss()) / problem.independence[term.joints[0]];
        let sensible = Oddity::of(problem, term, fitted.last_of(term)?).is_none();
        gain.is_finite().then_some(Worth { sensible, gain })
    }

    fn shortlist(&self, effect: Cause, joints: &[usize], shapes: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        if shapes.len() <= MANY_SHAPES || effect.about().scope == Scope::Machine {
            return shapes;
        }
        // Of several axes, one is enough to find the peaks.
        let joint = joints[0];
        let joints = &joints[..1];
        let system = self.problem.system_of(joints, &self.terms, Part::Train, true).system;
        let near = self.problem.fit_near(joints, &self.terms, Part::Train, self.fitted);
        let solution = near.as_ref().map_or(&self.fitted.solution, |near| &near.solution);
        let Scanned { motion, score, .. } = Scanned::new(self.problem, &system, solution, joint, SCANNED_ROWS);
        let gains: Vec<f64> =
            shapes.par_iter().map(|shape| score.gain(&effect.columns(&motion, joint, shape))).collect();
        let peak =
            |i: &usize| (*i == 0 || gains[i - 1] <= gains[*i]) && gains.get(i + 1).is_none_or(|next| *next < gains[*i]);
        let mut peaks: Vec<usize> = (0..shapes.len()).filter(peak).collect();
        peaks.sort_by(|a, b| gains[*b].total_cmp(&gains[*a]));
        peaks.truncate(SHORTLIST);
        peaks.into_iter().map(|index| shapes[index].clone()).collect()
    }

    /// The best term of an effect on these joints, its training gain, and the number of shapes.
    fn best(&self, effect: Cause, joints: &[usize]) -> Option<(Term, f64, usize)> {
        let motion = &self.problem.motion;
        let mut shapes = effect.shapes(motion, joints[0]);
        let is_taken = |shape: &Vec<f64>| {
            self.terms.iter().any(|term| term.effect == effect && term.joints == joints && term.shape == *shape)
        };
        shapes.retain(|shape| !self.problem.is_taken_out(&*effect, joints[0], shape) && !is_taken(shape));
        let count = shapes.len();
        let all = shapes.clone();
        let mut best: Option<(Term, Worth)> = None;
        for shape in self.shortlist(effect, joints, shapes) {
            let term = Term::new(motion, effect, joints, shape);
            let Some(worth) = self.worth(&term) else { continue };
            if best.as_ref().is_none_or(|(_, most)| worth > *most) {
                best = Some((term, worth));
            }
        }
        let (term, worth) = best?;
        let (term, worth) = self.improved(term, worth);
        let (term, worth) = match neighbours(&all, &term.shape) {
            Some(ends) if effect.refines() => self.refined(term, worth, ends),
            _ => (term, worth),
        };
        Some((term, worth.gain, count))
    }

    /// The term with the shape that its own coefficients suggest, while that fits better.
    fn improved(&self, mut term: Term, mut worth: Worth) -> (Term, Worth) {
        for _ in 0..IMPROVEMENTS {
            let suggested = self
                .with(&term)
                .and_then(|fitted| term.effect.improved(&self.problem.motion, &term.shape, fitted.last_of(&term)?));
            let Some(shape) = suggested else { break };
            let better = Term::new(&self.problem.motion, term.effect, &term.joints, shape);
            let Some(found) = self.worth(&better).filter(|found| *found >= worth) else { break };
            (term, worth) = (better, found);
        }
        (term, worth)
    }

    /// Golden section of the first shape parameter between two ends.
    fn refined(&self, term: Term, worth: Worth, (low, high): (f64, f64)) -> (Term, Worth) {
        let mut best = (term, worth);
        let mut steps = 0..=REFINEMENTS;
        golden_section(
            [low, high],
            |_, _| steps.next().is_none(),
            |value| {
                let mut shape = best.0.shape.clone();
                shape[0] = value;
                let term = Term::new(&self.problem.motion, best.0.effect, &best.0.joints, shape);
                let worth = self.worth(&term);
                if let Some(worth) = worth.filter(|worth| *worth > best.1) {
                    best = (term, worth);
                }
                worth.map_or(f64::NEG_INFINITY, |worth| worth.gain)
            },
        );
        best
    }
}

/// First parameters of the scanned shapes next to a given one, where nothing else of the shape differs: the best value lies between them.
/// A scan may use constant factors, so that near its upper end the neighbours are many first steps apart.
fn neighbours(shapes: &[Vec<f64>], shape: &[f64]) -> Option<(f64, f64)> {
    let at = shapes.iter().position(|other| other == shape)?;
    let own = *shape.first()?;
    let beside = |index: Option<usize>| {
        let other = index.and_then(|index| shapes.get(index)).filter(|other| other[1..] == shape[1..]);
        other.map_or(own, |other| other[0])
    };
    let (before, after) = (beside(at.checked_sub(1)), beside(Some(at + 1)));
    let (low, high) = (before.min(after).min(own), before.max(after).max(own));
    (low < high).then_some((low, high))
}

/// All candidates beside the terms of the model, each with its best shapes, by decreasing evidence.
/// An effect of a joint is combined over the joints where the rules accept it.
pub fn candidates(problem: &mut Problem, terms: &[Term], rules: &Rules) -> Vec<Candidate> {
    with_each(problem, terms, rules, &|_, _| true, gather).unwrap_or_default()
}

/// The candidates of one joint alone, of effects that act on one, by decreasing evidence.
pub fn on_joint(problem: &mut Problem, terms: &[Term], rules: &Rules, joint: usize) -> Vec<Candidate> {
    let acts = |effect: Cause, joints: &[usize]| effect.about().scope == Scope::Joint && joints[0] == joint;
    let mut found = with_each(problem, terms, rules, &acts, |_, found| found).unwrap_or_default();
    strongest_first(&mut found);
    found
}

fn strongest_first(all: &mut [Candidate]) {
    all.sort_by(|a, b| b.total().total_cmp(&a.total()));
}

/// Assesses the effects where they can act and `is_sought` holds, then passes them on with the search that found them.
fn with_each<R>(
    problem: &mut Problem,
    terms: &[Term],
    rules: &Rules,
    is_sought: &dyn Fn(Cause, &[usize]) -> bool,
    then: impl FnOnce(&Search, Vec<Candidate>) -> R,
) -> Option<R> {
    let own: Vec<&Term> = terms.iter().collect();
    let loose = problem.fit_loosely(&own, Part::Train)?;
    problem.look(&own, &loose);
    let problem = &*problem;
    let mut places = places(problem, terms);
    places.retain(|(effect, joints)| is_sought(*effect, joints));
    let before = without_any(problem, &own, &loose, &places)?;
    let search = Search { problem, terms: own, fitted: &loose, before: &before, rules };
    let (loads, others): (Vec<_>, Vec<_>) = places
        .iter()
        .partition(|(effect, _)| effect.loads_machine() && problem.motion.model.accuracy.guesses_torque_constants());
    let mut found: Vec<Candidate> =
        others.par_iter().filter_map(|(effect, joints)| assess(&search, *effect, joints)).collect();
    if !loads.is_empty() {
        found.extend(loads::near_nominal(&search, &loads).unwrap_or_default());
    }
    Some(then(&search, found))
}

/// One candidate an effect: on all joints where it has enough evidence, or on that with the most.
fn gather(search: &Search, found: Vec<Candidate>) -> Vec<Candidate> {
    let rules = search.rules;
    let enough = |evidence: &Evidence| evidence.is_enough(rules);
    let mut gathered: Vec<Candidate> = Vec::new();
    for candidate in found {
        let effect = candidate.effect();
        let joint = candidate.terms[0].joints[0];
        let partner = gathered.iter_mut().find(|other| other.effect() == effect);
        match partner {
            // Combine the joints of one effect where each has enough evidence of its own.
            Some(other) if candidate.is_sensible() && enough(&candidate.evidence[joint]) => {
                let first = other.terms[0].joints[0];
                if other.is_sensible() && enough(&other.evidence[first]) {
                    other.terms.extend(candidate.terms);
                    other.evidence[joint] = candidate.evidence[joint];
                    other.choice[joint] = candidate.choice[joint];
                } else {
                    *other = candidate;
                }
            }
            Some(other) => {
                let first = other.terms[0].joints[0];
                if !(other.is_sensible() && enough(&other.evidence[first])) && candidate.total() > other.total() {
                    *other = candidate;
                }
            }
            None => gathered.push(candidate),
        }
    }
    if search.fitted.inertial == Treated::Fixed {
        strongest_first(&mut gathered);
        return gathered;
    }
    gathered.par_iter_mut().filter(|candidate| candidate.terms.len() > 1).for_each(|one| together(search, one));
    strongest_first(&mut gathered);
    // The deviations that the other joints show are an estimate, so what could be taken, and what it is compared with, is fitted with all joints.
    let mut fitted: Vec<Cause> = Vec::new();
    loop {
        let accepted = || gathered.iter().filter(|one| one.is_accepted(rules));
        let least = FAR * accepted().map(Candidate::total).fold(0.0, f64::max);
        let compares =
            |one: &&Candidate| one.is_of_one_joint() && one.total() > least && !fitted.contains(&one.effect());
        let next: Vec<Cause> = accepted().filter(compares).map(Candidate::effect).collect();
        if next.is_empty() {
            break;
        }
        gathered.par_iter_mut().filter(|one| next.contains(&one.effect())).for_each(|one| together(search, one));
        strongest_first(&mut gathered);
        fitted.extend(next);
    }
    gathered
}

/// The strongest accepted candidate, or a simpler one that is as good: nearly as much evidence, and an error that is larger by no more than the
/// inaccuracy of the catalogue's laws. With few independent rows, evidence alone cannot separate an effect from one that explains half as much.
/// An effect that is unlikely beforehand yields to a likelier one with no larger an error.
pub fn choose<'c>(found: &'c [Candidate], rules: &Rules) -> Option<&'c Candidate> {
    let strongest = found.iter().find(|candidate| candidate.is_accepted(rules))?;
    let least = strongest.total() - rules.tied(strongest.total());
    let as_good = |other: &&Candidate| other.total() > least && other.worse_than(strongest) < MODEL_ERROR;
    let accepted = || found.iter().filter(|other| other.is_accepted(rules));
    let chosen = accepted().filter(as_good).min_by_key(|other| other.complexity())?;
    let likelier = chosen.effect().yields_to();
    let no_worse =
        |other: &&Candidate| likelier.contains(&other.effect().name()) && other.worse_than(chosen) < MODEL_ERROR;
    Some(accepted().find(no_worse).unwrap_or(chosen))
}

/// Predictions without a candidate: of all joints, and where deviations of the model are fitted, of the joints that each candidate is fitted to.
fn without_any(
    problem: &Problem,
    own: &[&Term],
    loose: &Fitted,
    places: &[(Cause, Vec<usize>)],
) -> Option<Vec<(Vec<usize>, Prediction)>> {
    let mut before = vec![(problem.joints(), prediction(problem, own, loose)?)];
    if loose.inertial == Treated::Fixed {
        return Some(before);
    }
    for (_, joints) in places {
        let together = problem.coupled(own, joints);
        if before.iter().all(|(of, _)| *of != together) {
            let near = problem.fit_near(&together, own, Part::Train, loose)?;
            let prediction = prediction(problem, own, &near)?;
            before.push((together, prediction));
        }
    }
    Some(before)
}

/// Effects with the joints where they can act and are not yet in the model.
fn places(problem: &Problem, terms: &[Term]) -> Vec<(Cause, Vec<usize>)> {
    let (dof, judged) = (problem.baseline.len(), problem.joints());
    let mut places: Vec<(Cause, Vec<usize>)> = Vec::new();
    for effect in problem.causes.iter().copied() {
        let applies = |joint: usize| problem.is_open(effect, joint) && effect.applies(&problem.motion, joint);
        let present =
            |joint: usize| terms.iter().any(|term| term.effect == effect && term.own_joints().contains(&joint));
        match effect.about().scope {
            Scope::Machine if (0..dof).any(applies) && (effect.several() || !present(judged[0])) => {
                places.push((effect, judged.clone()))
            }
            Scope::Machine => {}
            // An effect with another order is a further candidate of the same name.
            Scope::Joint => places.extend(
                (0..dof)
                    .filter(|joint| applies(*joint) && (effect.several() || !present(*joint)))
                    .map(|joint| (effect, effect.axes(&problem.motion, joint))),
            ),
        }
    }
    places
}

/// The best term of an effect on these joints; one that gains nothing on the rows of the fit needs no cross-validation.
fn assess(search: &Search, effect: Cause, joints: &[usize]) -> Option<Candidate> {
    let (term, training_gain, shapes) = search.best(effect, joints)?;
    if training_gain <= LEAST_GAIN {
        return search.without_evidence(term);
    }
    match search.with_friction_of(std::slice::from_ref(&term)) {
        Some((problem, mut terms)) => {
            let term = terms.swap_remove(0);
            search.judged(&problem, &search.terms, &search.fitted_in(&problem, &term)?, term, shapes)
        }
        None => search.judged(search.problem, &search.terms, &search.with(&term)?, term, shapes),
    }
}

mod judged;
mod loads;
mod possible;
#[cfg(test)]
pub mod tests;

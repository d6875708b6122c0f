//! The evidence for a candidate.

use super::possible::hold_to_possible;
use super::{Candidate, Search};
use crate::diagnose::evidence::local_level::count_lines;
use crate::diagnose::evidence::prediction::{Evidence, prediction, weighed};
use crate::diagnose::fit::problem::{Fitted, Part, Problem};
use crate::diagnose::fit::term::Term;
use crate::diagnose::select::oddity::Oddity;

/// Fits from which the friction law is taken that suits a term: the first beside a term that does not fall towards rest, the second beside its own form.
const LAWS: usize = 2;

impl<'m> Search<'_, 'm> {
    /// A candidate on which no evidence is spent.
    pub(super) fn without_evidence(&self, term: Term) -> Option<Candidate> {
        let oddity = Oddity::of(self.problem, &term, self.with(&term)?.last_of(&term)?);
        let evidence = self.none();
        Some(Candidate { terms: vec![term], choice: vec![0.0; evidence.len()], evidence, oddity })
    }

    /// No evidence, and the errors without a candidate.
    fn none(&self) -> Vec<Evidence> {
        let errors = self.fitted.solution.scale.iter();
        errors.map(|error| Evidence { error: *error, ..Evidence::default() }).collect()
    }

    /// A term with the evidence of its loose fit beside the terms `others`, of several `shapes` that were tried.
    pub(super) fn judged(
        &self,
        problem: &Problem,
        others: &[&Term],
        fitted: &Fitted,
        term: Term,
        shapes: usize,
    ) -> Option<Candidate> {
        let estimate = fitted.last_of(&term)?;
        let oddity = Oddity::of(problem, &term, estimate);
        let all: Vec<&Term> = others.iter().copied().chain([&term]).collect();
        let after = prediction(problem, &all, fitted)?;
        let pair = [self.before(&term.joints), &after];
        let own = weighed(problem, others, fitted, pair, self.inaccuracy(term.effect))?;
        let mut evidence = self.none();
        fitted.joints.iter().for_each(|joint| evidence[*joint] = own[*joint]);
        count_lines(problem, &all, fitted, others.len()..all.len(), &mut evidence);
        let (first, mut choice) = (term.joints[0], vec![0.0; evidence.len()]);
        choice[first] = (shapes as f64).ln();
        evidence[first].nats += at_rest(problem, &term, estimate) - choice[first];
        hold_to_possible(problem, &term, estimate, &after.independence, &mut evidence);
        Some(Candidate { terms: vec![term], evidence, choice, oddity })
    }

    /// Terms of a candidate along the friction law of their own fit, and the problem with this law; `None` for an effect of the machine. The law of a fit without
    /// them stands for what it lacks: an asymmetry that followed such a law lost four fifths of its evidence. So the first law is one beside a term that follows
    /// none: a constant torque takes little of a law that changes its sign with the motion.
    pub(super) fn with_friction_of(&self, terms: &[Term]) -> Option<(Problem<'m>, Vec<Term>)> {
        if terms.iter().any(Term::is_machine) {
            return None;
        }
        let follow: Vec<usize> = terms.iter().map(|term| term.joints[0]).collect();
        let mut problem = self.problem.clone();
        for joint in &follow {
            let law = &mut problem.motion.joints[*joint].friction;
            law.breakaway = law.coulomb;
        }
        let along = |problem: &Problem| -> Vec<Term> {
            terms.iter().map(|term| term.along(&problem.motion, term.near.clone())).collect()
        };
        let fit = |problem: &Problem, own: &[Term]| {
            let all = self.and(own);
            problem.fit_near(&problem.coupled(&all, &follow), &all, Part::Train, self.fitted)
        };
        let mut own = along(&problem);
        let mut fitted = fit(&problem, &own)?;
        for _ in 0..LAWS {
            // Errors that the terms explain are those of many neighbouring rows alike: with them, too few seem independent to tell a velocity.
            problem.count_independent(&fitted);
            for joint in &follow {
                problem.baseline[*joint] = problem.suited(&self.and(&own), *joint)?;
            }
            fitted = fit(&problem, &own)?;
            problem.adopt_on(follow.iter().copied(), &fitted);
            own = along(&problem);
        }
        problem.independence.clone_from(&self.problem.independence);
        Some((problem, own))
    }
}

/// The evidence for an effect of joints, fitted with all joints at once. Each joint alone counts the same deviations of the nominal model
/// as explained, and takes those that the other joints show as they were before.
pub(super) fn together(search: &Search, candidate: &mut Candidate) {
    let own = search.with_friction_of(&candidate.terms);
    let (problem, own) = own.as_ref().map_or((search.problem, &candidate.terms), |(problem, own)| (problem, own));
    let terms = search.and(own);
    let Some(fitted) = problem.fit_loosely(&terms, Part::Train) else { return };
    let Some(after) = prediction(problem, &terms, &fitted) else { return };
    let pair = [&search.before[0].1, &after];
    let Some(mut joint) = weighed(problem, &search.terms, &fitted, pair, search.inaccuracy(candidate.effect())) else {
        return;
    };
    count_lines(problem, &terms, &fitted, search.terms.len()..terms.len(), &mut joint);
    for (term, at) in own.iter().zip(&fitted.term_at[search.terms.len()..]) {
        let own = &fitted.solution.coefficients.as_slice()[*at..at + term.coefficients()];
        joint[term.joints[0]].nats += at_rest(problem, term, own);
    }
    joint.iter_mut().zip(&candidate.choice).for_each(|(evidence, cost)| evidence.nats -= cost);
    candidate.evidence = joint;
}

/// [nats] Evidence for an effect on one joint from the current before the first motion.
fn at_rest(problem: &Problem, term: &Term, coefficients: &[f64]) -> f64 {
    let joint = term.joints[0];
    let offset = term.effect.reading_at_rest(coefficients);
    let span = problem.motion.joints[joint].friction.breakaway / problem.motion.model.joints[joint].torque_per_ampere();
    match problem.standstill[joint] {
        Some(standstill) if offset != 0.0 => standstill.evidence(offset, span),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::candidates;
    use super::*;
    use crate::diagnose::options::Rules;
    use crate::effects::drawn::{LENGTH, MODEL, NOISE, ROBOT, drawn};
    use crate::effects::{CATALOGUE, Effect};
    use crate::robot::Model;

    /// Dry friction `(2 + 1.5 e^(−|v|/v_S))(sgn v + a)`. A fit without `a` has another law, along which an asymmetry explains less than a constant torque does.
    #[test]
    fn recover_an_asymmetry_along_its_own_friction_law() {
        let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a model");
        for (seed, stribeck_velocity, asymmetry) in [(1, 0.05, -0.2), (2, 0.1, 0.15), (3, 0.2, -0.15)] {
            let mut motion = drawn(&model, seed, None, LENGTH);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let one = &mut motion.joints[0];
            for row in 0..one.v.len() {
                let v = one.v[row];
                let dry = 2.0 + 1.5 * (-v.abs() / stribeck_velocity).exp();
                let normal: f64 = (0..12).map(|_| rng.random_range(-0.5..0.5)).sum();
                one.torque[row] = one.rigid[row] + dry * (v.signum() + asymmetry) + 1.3 * v + NOISE * normal;
            }
            let held_out = vec![false; motion.rows()];
            let mut problem = Problem::new(motion, held_out);
            let both =
                |effect: &&'static dyn Effect| ["coulomb_asymmetry", "current_offset"].contains(&effect.about().name);
            problem.name_from(CATALOGUE.iter().filter(|effect| both(effect)).copied().collect());
            let fitted = problem.settle(&[]).expect("a baseline");
            problem.count_independent(&fitted);
            let found = candidates(&mut problem, &[], &Rules::default());
            let nats: Vec<_> = found.iter().map(|one| (one.effect().name(), one.total(), one.log_scale())).collect();
            assert_eq!(found[0].effect().name(), "coulomb_asymmetry", "{stribeck_velocity}: {nats:?}");
        }
    }
}

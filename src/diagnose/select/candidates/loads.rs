//! Effects that load the machine, judged where torque constants are guesses.
//!
//! A current shows `(1 − s u)(τ̄ + L z + E)` ([`expansion`](crate::diagnose::fit::expansion)). A fit without the load `E` lays its torque into constants and links,
//! and ends where both are far from their own; from there a fit with the load is not linear, and finds it on a wrong link. So a load is sought near the
//! nominal model, and judged by a fit that is expanded near itself.

use rayon::prelude::*;

use super::{Candidate, IMPROVEMENTS, Search, Worth};
use crate::diagnose::evidence::prediction::{Prediction, prediction};
use crate::diagnose::fit::cause::Cause;
use crate::diagnose::fit::problem::{Fitted, Part, Problem};
use crate::diagnose::fit::term::Term;

/// A fit with one more term, near itself.
struct Settled<'m> {
    problem: Problem<'m>,
    /// The other terms.
    terms: Vec<Term>,
    term: Term,
    fitted: Fitted,
    worth: Worth,
}

/// These loads, sought near the nominal model and judged near their own fit; `None` where nothing can be fitted there.
pub fn near_nominal(search: &Search, loads: &[&(Cause, Vec<usize>)]) -> Option<Vec<Candidate>> {
    let problem = search.problem.near_nominal();
    let terms: Vec<Term> = search.terms.iter().map(|term| term.along(&problem.motion, term.near.clone())).collect();
    let own: Vec<&Term> = terms.iter().collect();
    let fitted = problem.fit_loosely(&own, Part::Train)?;
    let without = search.better_from(&problem);
    let before = without.as_ref().map_or(search.before, std::slice::from_ref);
    let near = Search { problem: &problem, terms: own, fitted: &fitted, before, rules: search.rules };
    let judged = |(effect, joints): &&(Cause, Vec<usize>)| {
        let (term, _, shapes) = near.best(*effect, joints)?;
        let Settled { problem, terms, term, fitted, .. } = near.near_itself(&term)?;
        let mut candidate = near.judged(&problem, &terms.iter().collect::<Vec<_>>(), &fitted, term, shapes)?;
        candidate.terms.iter_mut().for_each(|term| *term = term.along(&search.problem.motion, term.near.clone()));
        Some(candidate)
    };
    Some(loads.par_iter().filter_map(judged).collect())
}

impl<'m> Search<'_, 'm> {
    /// The prediction of all joints without a candidate, by the fit that this problem leads to, if that is better than what is known: a load is no better for a
    /// start of its own.
    fn better_from(&self, problem: &Problem<'m>) -> Option<(Vec<usize>, Prediction)> {
        let mut problem = problem.clone();
        let (terms, fitted) = self.expanded(&mut problem, self.fitted, None)?;
        let own: Vec<&Term> = terms.iter().collect();
        let (joints, known) = self.before.first()?;
        let found = prediction(&problem, &own, &fitted)?;
        let of_rows = |joint: &usize| problem.independence[*joint] * (found.training[*joint] - known.training[*joint]);
        let gain = joints.iter().map(of_rows).sum::<f64>() + known.prior_loss - found.prior_loss;
        (gain > 0.0).then(|| (joints.clone(), found))
    }

    /// A load near its own fit: the products that it expands, and the shape that its coefficients suggest, are what that fit finds.
    fn near_itself(&self, term: &Term) -> Option<Settled<'m>> {
        let mut best = self.settled(self.problem.clone(), self.fitted, term.clone())?;
        for _ in 0..IMPROVEMENTS {
            let own = best.fitted.last_of(&best.term)?;
            let Some(shape) = best.term.effect.improved(&self.problem.motion, &best.term.shape, own) else { break };
            let mut term = Term::new(&best.problem.motion, best.term.effect, &best.term.joints, shape);
            term.near = own.to_vec();
            match self.settled(best.problem.clone(), &best.fitted, term).filter(|better| better.worth >= best.worth) {
                Some(better) => best = better,
                None => break,
            }
        }
        Some(best)
    }

    /// The fit with one more term near itself, from where this problem is expanded, beginning with the weights of a similar fit.
    fn settled(&self, mut problem: Problem<'m>, similar: &Fitted, term: Term) -> Option<Settled<'m>> {
        let (mut terms, fitted) = self.expanded(&mut problem, similar, Some(term))?;
        let term = terms.pop()?;
        let worth = self.worth_of(&problem, &term, &fitted)?;
        Some(Settled { problem, terms, term, fitted, worth })
    }

    /// All terms and their loose fit, which a problem is expanded near.
    fn expanded(
        &self,
        problem: &mut Problem<'m>,
        similar: &Fitted,
        further: Option<Term>,
    ) -> Option<(Vec<Term>, Fitted)> {
        let along = |own: &&Term| own.along(&problem.motion, own.near.clone());
        let mut terms: Vec<Term> = self.terms.iter().map(along).chain(further).collect();
        let joints = problem.joints();
        let near =
            |problem: &Problem, terms: &[&Term], last: &Fitted| problem.fit_near(&joints, terms, Part::Train, last);
        let mut own: Vec<&mut Term> = terms.iter_mut().collect();
        let last =
            problem.fit_near_itself(&mut own, |problem, terms, last| near(problem, terms, last.unwrap_or(similar)))?;
        let fitted = near(problem, &terms.iter().collect::<Vec<_>>(), &last)?;
        Some((terms, fitted))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::path::Path;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::tests::{deviating, recorded};
    use super::super::{candidates, choose};
    use crate::diagnose::options::Rules;
    use crate::diagnose::select::selection::{Taken, resettle};
    use crate::dynamics::Dynamics;
    use crate::effects::find;
    use crate::robot::{Accuracy, Model};
    use crate::timeseries::Channel;

    /// A six-joint arm of which the model guesses the torque constants and has masses with errors of 8 %, with a load of 3 kg beside the axis of its last
    /// joint. Judged from where the fit without it ends, it was a weight on a link further in. The load is taken on its own link, and the fit with it has its
    /// mass and the constants.
    #[test]
    fn recover_a_load_beside_guessed_constants() {
        let mut model = Model::load(Path::new("robots/sixaxis/model.toml")).expect("a model");
        for joint in &mut model.joints {
            (joint.backlash, joint.gear_stiffness, joint.friction) = (Some(0.0), None, None);
        }
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        model.accuracy = Accuracy { masses: 0.08, ..Accuracy::EXACT };
        let u: Vec<f64> = (0..10 * model.robot.bodies.len()).map(|_| rng.random_range(-1.7..1.7)).collect();
        let mut machine = model.deviating(&u);
        model.accuracy = Accuracy { torque_constants: 1.0, ..Accuracy::default() };
        let load = [("mass", 3.0), ("x", 0.04), ("y", 0.10), ("z", 0.02)].map(|(key, value)| (key.to_owned(), value));
        let payload = find("payload").expect("a payload");
        payload.install(&mut machine, None, &BTreeMap::from(load)).expect("a loaded arm");
        let mut dynamics = Dynamics::new(&machine.robot);
        let factors = [0.9, 1.1, 0.8, 1.3, 0.7, 1.2];
        let per_ampere: Vec<f64> =
            model.joints.iter().zip(factors).map(|(joint, f)| f * joint.torque_per_ampere()).collect();
        let waves = |k: usize| [[0.5, 0.7 + 0.23 * k as f64], [0.15, 3.1 - 0.31 * k as f64]];
        let joints: Vec<_> =
            model.joints.iter().enumerate().map(|(k, joint)| (joint.name.as_str(), waves(k))).collect();
        let session = recorded(&joints, Channel::Current, &per_ampere, 0.05, |[q, v, a]| {
            let mut torque = vec![0.0; q.len()];
            dynamics.inverse(q, v, a, &mut torque);
            for (k, joint) in model.joints.iter().enumerate() {
                torque[k] += joint.reflected_inertia() * a[k] + 2.0 * v[k].signum() + v[k];
            }
            torque
        });
        let inertia: Vec<f64> = model.joints.iter().map(|joint| 1.0 + joint.reflected_inertia()).collect();
        let mut problem = deviating(&model, &session, &inertia, &["payload", "link_inertia"]);
        let rules = Rules::default();
        let found = candidates(&mut problem, &[], &rules);
        let first = choose(&found, &rules).expect("a load");
        assert_eq!(first.effect().name(), "payload");
        let mut taken = [Taken::new(first, &found)];
        resettle(&mut problem, &mut taken).expect("a fit");
        let [mass, ..] = taken[0].terms[0].near[..] else { panic!("no coefficients") };
        // Errors of 8 % of six masses have 3 % in common, which nothing tells from an error of all constants. The last link weighs 3.35 kg, of which 8 % are 9 %
        // of the load, too. One and a half of these standard errors.
        assert!((mass / 3.0 - 1.0).abs() < 0.15, "{mass} kg");
        for (m, factor) in problem.motion.joints.iter().zip(factors) {
            assert!(
                (1.0 / (1.0 - m.scale) / factor - 1.0).abs() < 0.05,
                "{} instead of {factor}",
                1.0 / (1.0 - m.scale)
            );
        }
    }
}

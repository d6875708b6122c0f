//! What could be behind an unexplained residual: effects that lower the error, with less evidence than a name needs.
//!
//! Evidence grows with the number of independent rows, the error that an effect removes does not: in a short or slow recording several
//! effects may each remove most of the error, and none has enough evidence. They are reported as undecided, with the experiment that would
//! separate them.

use crate::diagnose::fit::problem::Problem;
use crate::diagnose::options::{MODEL_ERROR, Rules};
use crate::diagnose::result::Unexplained;
use crate::diagnose::select::candidates::Candidate;
use crate::diagnose::select::selection::Selection;

/// Adds to each unexplained residual of a joint without a named effect the effects that could cause it.
pub fn add(problem: &Problem, selection: &Selection, rules: &Rules, unexplained: &mut [Unexplained]) {
    for one in unexplained {
        let joint = problem.motion.model.joints.iter().position(|joint| joint.name == one.joint);
        let taken = |joint: usize| selection.terms().iter().any(|term| term.joints.contains(&joint));
        if let Some(joint) = joint.filter(|joint| !taken(*joint)) {
            one.pattern += &words(&possible(&selection.first_round, joint, rules));
        }
    }
}

/// Candidates that lower the error of a joint by more than the inaccuracy of the catalogue's laws, the largest fall first.
fn possible<'c>(candidates: &'c [Candidate], joint: usize, rules: &Rules) -> Vec<(&'c Candidate, f64)> {
    let fall = |candidate: &Candidate| candidate.evidence[joint].log_scale;
    let could = |candidate: &&Candidate| {
        let acts = candidate.joints().contains(&joint) && fall(candidate) > MODEL_ERROR;
        acts && candidate.is_sensible() && candidate.total() > 0.0 && !candidate.is_accepted(rules)
    };
    let mut possible: Vec<(&Candidate, f64)> =
        candidates.iter().filter(could).map(|candidate| (candidate, 1.0 - (-fall(candidate)).exp())).collect();
    possible.sort_by(|a, b| b.1.total_cmp(&a.1));
    possible
}

fn words(possible: &[(&Candidate, f64)]) -> String {
    let (Some((first, most)), Some((_, least))) = (possible.first(), possible.last()) else { return String::new() };
    let names: Vec<&str> = possible.iter().map(|(candidate, _)| candidate.effect().name()).collect();
    let separate_by = first.effect().about().separate_by;
    match names.as_slice() {
        [name] => format!(
            "; {name} would lower the error by {:.0} %, but has less evidence than a name needs. Experiment: {separate_by}",
            100.0 * most
        ),
        names => format!(
            "; undecided between {}, each of which lowers the error by {:.0} to {:.0} %. Experiment: {separate_by}",
            names.join(", "),
            100.0 * least,
            100.0 * most
        ),
    }
}

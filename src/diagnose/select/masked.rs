//! Two effects of one joint that mask each other.
//!
//! Evidence counts independent rows. What an effect leaves that is not modelled is alike over a whole sweep, so that beside a second strong effect a sweep counts as
//! few rows, and neither has evidence alone. The candidates of a joint that lower its error clearly are therefore tried as if they were known, one at a time:
//! if another one then has enough evidence, and the first has it beside that one, both are taken.

use super::candidates::{choose, on_joint};
use super::oddity::Oddity;
use super::selection::{Taken, evidence_beside, resettle, terms_of};
use crate::diagnose::evidence::prediction::{Evidence, predict};
use crate::diagnose::fit::problem::{Fitted, Problem};
use crate::diagnose::fit::term::Term;
use crate::diagnose::options::{MODEL_ERROR, Rules};

/// Candidates of a joint that are tried as if they were known: those that lower its error most, by more than the inaccuracy of the laws. It limits the computing time
/// and is not calibrated: one that stands in for another is exchanged for it afterwards.
const LEADS: usize = 3;

/// The best two effects that mask each other on a joint, beside those taken; `None` where there are none. The problem is settled for those taken.
pub fn masked(problem: &mut Problem, taken: &[Taken], rules: &Rules) -> Option<[Taken; 2]> {
    let mut own = taken.to_vec();
    let mut best: Option<([Taken; 2], f64)> = None;
    for joint in problem.joints() {
        settle(problem, &mut own)?;
        let mut leads = on_joint(problem, &terms(&own), rules, joint);
        leads.retain(|lead| lead.log_scale() > MODEL_ERROR);
        leads.sort_by(|a, b| b.log_scale().total_cmp(&a.log_scale()));
        for lead in leads.iter().take(LEADS) {
            let Some((pair, nats)) = led_by(problem, &own, Taken::new(lead, &leads), rules, joint) else { continue };
            if best.as_ref().is_none_or(|(_, most)| nats > *most) {
                best = Some((pair, nats));
            }
        }
    }
    settle(problem, &mut own)?;
    best.map(|(pair, _)| pair)
}

/// Fits what was taken, and counts the rows that are independent beside it.
fn settle(problem: &mut Problem, taken: &mut [Taken]) -> Option<Fitted> {
    let fitted = resettle(problem, taken)?;
    problem.count_independent(&fitted);
    Some(fitted)
}

fn terms(taken: &[Taken]) -> Vec<Term> {
    terms_of(taken).into_iter().cloned().collect()
}

/// A lead with the effect of its joint that has the most evidence beside it, and what both gain together [nats]; `None` where one has too little beside the other.
fn led_by(problem: &mut Problem, own: &[Taken], lead: Taken, rules: &Rules, joint: usize) -> Option<([Taken; 2], f64)> {
    let rules = rules.beside_another();
    let mut all = [own, &[lead]].concat();
    settle(problem, &mut all)?;
    let found = on_joint(problem, &terms(&all), &rules, joint);
    let second = choose(&found, &rules)?;
    all.push(Taken::new(second, &found));
    let fitted = settle(problem, &mut all)?;
    let both = own.len()..own.len() + 2;
    let first = terms_of(own).len();
    for (index, term) in both.zip(first..) {
        all[index].evidence = evidence_beside(problem, &all, index, all[index].inaccuracy(&rules))?;
        let Evidence { nats, log_scale, .. } = all[index].evidence[joint];
        let at = fitted.term_at[term];
        let own = all[index].terms[0].coefficients();
        let coefficients = &fitted.solution.coefficients.as_slice()[at..at + own];
        if !rules.support(nats, log_scale) || Oddity::of(problem, &all[index].terms[0], coefficients).is_some() {
            return None;
        }
    }
    let gained = predict(problem, &terms_of(&all))?.against(&predict(problem, &terms_of(own))?);
    let [lead, second] = all.split_off(own.len()).try_into().ok()?;
    Some(([lead, second], gained[joint].nats))
}

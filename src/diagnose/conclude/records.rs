//! The entries of a report for candidates and method.

use crate::diagnose::fit::problem::Problem;
use crate::diagnose::instruments::current_lag::COARSEST;
use crate::diagnose::options::Options;
use crate::diagnose::result::{CandidateRecord, Method, Withdrawn};
use crate::diagnose::rows::division::Division;
use crate::diagnose::rows::sampling::Sampling;
use crate::diagnose::select::candidates::Candidate;
use crate::diagnose::select::selection::Selection;
use crate::effects::{Applied, JointMotion, LeftOut};
use crate::robot::{Accuracy, EffectEntry, JointModel};
use crate::timeseries::TimeSeries;

/// [1] Share of uneven steps up to which a session counts as even: single lost samples cut it into runs that are long enough for every instrument.
const MOSTLY_EVEN: f64 = 0.001;

/// Every candidate of the first round, with its outcome.
pub fn records(
    problem: &Problem,
    selection: &Selection,
    withdrawn: &[Withdrawn],
    options: &Options,
) -> Vec<CandidateRecord> {
    let named = |candidate: &Candidate| selection.taken.iter().any(|taken| taken.terms[0].effect == candidate.effect());
    let record = |candidate: &Candidate| {
        let joints = candidate.joints();
        let rules = &options.rules;
        let (total, log_scale) = (candidate.total(), candidate.log_scale());
        let named = named(candidate);
        let not_confirmed = withdrawn.iter().find(|one| one.effect == candidate.effect().label());
        let reason = if named {
            format!("evidence {total:.0} nats alone")
        } else if let Some(withdrawn) = not_confirmed {
            withdrawn.reason.clone()
        } else if let Some(oddity) = candidate.oddity {
            oddity.words(problem.motion.model.joints[joints[0]].kind)
        } else if !rules.support(total, log_scale) {
            format!("evidence {total:.1} nats, {:.1} % of the error: too little for a name", 100.0 * log_scale)
        } else if selection.taken.is_empty() && withdrawn.is_empty() {
            let least = 100.0 * rules.least_torque;
            format!(
                "evidence {total:.0} nats alone, but less than {least} % of the torque, or superfluous beside such an effect"
            )
        } else {
            format!("evidence {total:.0} nats alone, superfluous beside what was taken before it")
        };
        CandidateRecord {
            effect: candidate.effect().name().to_owned(),
            joints: joints.iter().map(|joint| problem.motion.model.joints[*joint].name.clone()).collect(),
            gain_percent: 100.0 * (1.0 - (-log_scale).exp()),
            threshold_percent: 100.0 * (1.0 - (-rules.log_scale).exp()),
            named,
            reason,
        }
    };
    selection.first_round.iter().map(record).collect()
}

/// The kernel, and what uneven samples and pauses change.
fn filter(sessions: &[&TimeSeries]) -> String {
    let mut text =
        "biweight kernel without phase shift, the same on torque and motion, as narrow as the encoder allows"
            .to_owned();
    let samplings: Vec<Sampling> =
        sessions.iter().map(|session| Sampling::new(&session.time, session.sample_interval())).collect();
    let uneven = samplings.iter().filter(|sampling| sampling.uneven_share() > MOSTLY_EVEN).count();
    if uneven > 0 {
        text += &format!(
            "; samples of {uneven} of {} sessions lie at uneven times: rows, lines, slips and late currents are judged in true time",
            sessions.len()
        );
    }
    let coarse = samplings.iter().filter(|sampling| sampling.median > COARSEST).count();
    if coarse > 0 {
        text += &format!(
            "; no late current is looked for in {coarse} of {} sessions: their samples are more than {:.0} ms apart",
            sessions.len(),
            1e3 * COARSEST
        );
    }
    let pauses: usize = samplings.iter().map(|sampling| sampling.parts.len().saturating_sub(1)).sum();
    if pauses > 0 {
        text += &format!("; no kernel reaches across a pause, of which there are {pauses}");
    }
    text
}

/// What is fitted beside every effect.
fn baseline(problem: &Problem) -> String {
    let accuracy = &problem.motion.model.accuracy;
    let exact = Accuracy { stiffness: accuracy.stiffness, ..Accuracy::EXACT };
    let nominal = match problem.inertial.is_some() && *accuracy != exact {
        true => {
            "masses, centres, inertias, rotors and torque constants deviate from the model file within its accuracy"
        }
        false => "masses and inertias stay as the model file gives them",
    };
    let posture = match problem.inertial.is_some() {
        true => "; the weight of the links acts where gaps and wind-ups put them",
        false => "",
    };
    format!(
        "Coulomb, Stribeck and viscous friction, both directions alike; the gap; a rotor inertia that the model file does not give; the zero of a recorded torque, one per session; {nominal}{posture}"
    )
}

/// How the data were processed.
pub fn method(problem: &Problem, sessions: &[&TimeSeries], division: Division) -> Method {
    let widths = &problem.motion.half_width;
    let half_width = [widths.iter().copied().fold(f64::INFINITY, f64::min), widths.iter().copied().fold(0.0, f64::max)];
    let rigid: Vec<String> = problem
        .zones
        .iter()
        .zip(&problem.motion.model.joints)
        .zip(&problem.motion.joints)
        .filter(|(_, m)| m.left_out.is_none())
        .map(|((zone, joint), _)| {
            let share = zone.iter().filter(|rigid| **rigid).count() as f64 / zone.len().max(1) as f64;
            format!("{}: {:.0} % of the rows", joint.name, 100.0 * share)
        })
        .collect();
    let held_out = if division.by_session() {
        sessions[division.trained()..].iter().map(|session| session.name.as_str()).collect::<Vec<_>>().join(", ")
    } else {
        division.in_words()
    };
    Method {
        filter: filter(sessions),
        half_width,
        zones: format!(
            "left out: from 0.1 s before to 0.2 s after reversals and from 0.1 s before to 0.15 s after changes of flank (for error figures to 0.4 s and 0.3 s after them), only for joints with a gap, and no longer than the link takes to cross it{}; a joint at rest; fitted: {}",
            problem.widest_gap.words(),
            rigid.join(", ")
        ),
        baseline: baseline(problem),
        held_out,
        left_out: left_out(problem),
        listed_effects: Vec::new(),
    }
}

/// What becomes of the effects that the model file lists, one sentence each.
pub fn listed_effects(given: &Applied) -> Vec<String> {
    let name = |entry: &EffectEntry| match &entry.joint {
        Some(joint) => format!("{} on {joint}", entry.effect),
        None => entry.effect.clone(),
    };
    let known = given
        .in_numbers
        .iter()
        .map(|entry| format!("{} of the model file is known: the corrected model has it in its numbers.", name(entry)));
    let sought = given.others.iter().map(|entry| {
        format!("{} of the model file was sought anew: the corrected model has what was found.", name(entry))
    });
    known.chain(sought).collect()
}

/// The joints that are not judged, each with the reason.
fn left_out(problem: &Problem) -> Vec<String> {
    let of_joint = |(m, joint): (&JointMotion, &JointModel)| {
        let why = match m.left_out? {
            LeftOut::NotRecorded => "a session has neither its current nor its torque",
            LeftOut::HardlyMoves => "it moves too little to show its friction",
        };
        Some(format!("{} is not judged: {why}.", joint.name))
    };
    problem.motion.joints.iter().zip(&problem.motion.model.joints).filter_map(of_joint).collect()
}

//! What shows only where joints turn around: the reversal zone, which the rigid fit leaves out, against a simulation of the gear.
//!
//! ```text
//!  residual of the rigid fit ─▶ rows around turns ─ less what a simulated gear lacks ─▶ regression ─▶ gap, link share
//!                                                       ▲                                                │
//!                           gear along the measured motion ◀─ effect.install ◀─ trials of each effect ◀──┘
//! ```
//! A hard gear with a gap is simulated along the measured motion of the rotor, once as fitted and once with an effect in it.
//! The effect is chosen where the difference explains training rows that nothing was fitted on, and named where it gains on what is held out.

mod attempt;
mod channel;
mod gear;
mod judge;
mod path;
mod search;

#[cfg(test)]
mod tests;

use super::observe::rest_speed;
use super::probability::calibrated;
use super::problem::Problem;
use super::result::{EffectGain, FoundEffect, Measured};
use crate::effects::Motion;
use crate::timeseries::TimeSeries;
use search::Candidate;

/// When an effect is named by the turns of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// [nats] evidence that it needs.
    pub nats: f64,
    /// [1] logarithm by which the error scale around turns has to fall.
    pub log_scale: f64,
}

impl Default for Rules {
    /// Clean machines by seed reach 25 nats and 3 %, not at the same time; an effect that reaches more there has a
    /// [reserve](crate::effects::AtTurns::reserve) of its own.
    fn default() -> Self {
        Self { nats: 30.0, log_scale: 0.06 }
    }
}

impl Rules {
    /// Fewest rows around turns that are judged.
    const FEWEST: usize = 200;
    /// Part of a parameter's scale that a simulation with hard flanks along a smooth motion may be wrong by, seen on machines by seed.
    const SYSTEMATIC: f64 = 0.2;
    /// Part of its evidence by which a rival's may differ from it by chance.
    const VAGUE: f64 = 0.1;
}

/// The effects that turns tell of, by falling evidence.
pub fn found(problem: &Problem, sessions: &[&TimeSeries], residuals: &[Vec<f64>]) -> Vec<FoundEffect> {
    let rules = Rules::default();
    let candidates = search::candidates(problem, sessions, residuals);
    search::named(&candidates, &rules).iter().map(|one| entry(problem, one, &candidates, &rules)).collect()
}

fn entry(problem: &Problem, one: &Candidate, all: &[Candidate], rules: &Rules) -> FoundEffect {
    let about = one.effect.about();
    let joint = &problem.motion.model.joints[one.joint];
    let specs = about.parameters.iter().zip(&one.values);
    let rivals = || all.iter().filter(|other| other.joint == one.joint && other.effect.name() != about.name);
    let unit = Rules::VAGUE * one.total() + 3.0;
    let odds = |difference: f64| (difference / unit).exp();
    let of_rivals: f64 = rivals().map(|rival| odds(rival.total() - one.total())).sum();
    FoundEffect {
        effect: about.name.to_owned(),
        joints: vec![joint.name.clone()],
        kind: about.kind,
        parameters: specs
            .map(|(spec, [value, std_error])| {
                let unit = spec.unit_for(joint.kind);
                (spec.name.to_owned(), Measured { value: *value, std_error: *std_error, unit })
            })
            .collect(),
        probability: calibrated(of_rivals + odds(rules.nats - 2.0 * unit - one.total())),
        evidence_nats: one.total(),
        gain: EffectGain::of(one.gain, "torque around reversals"),
        confusable_with: rivals()
            .filter(|rival| rival.total() > 0.85 * one.total())
            .map(|rival| rival.effect.name().to_owned())
            .collect(),
        separate_by: about.separate_by.to_owned(),
    }
}

/// [s] How long the rotor of a joint rested before each of its starts.
fn rests(motion: &Motion, joint: usize) -> Vec<f64> {
    let m = &motion.joints[joint];
    let fastest = m.v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let rest = rest_speed(motion.model, joint, fastest);
    let mut rests = Vec::new();
    let mut since: Option<usize> = None;
    for row in 0..motion.rows() {
        if since.is_some_and(|since| motion.session[since] != motion.session[row]) {
            since = None;
        }
        match (m.v[row].abs() < rest, since) {
            (true, None) => since = Some(row),
            (false, Some(begin)) => {
                rests.push(motion.time[row] - motion.time[begin]);
                since = None;
            }
            _ => {}
        }
    }
    rests
}

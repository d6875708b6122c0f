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

use crate::diagnose::evidence::probability::calibrated;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::instruments::{FittedRows, Instrument, Measurement};
use crate::diagnose::result::{EffectGain, FoundEffect, Measured, Standing};
use crate::diagnose::select::confirm::part;
use crate::error::Result;
use crate::timeseries::Estimate;
use search::TurnCandidate;

/// When an effect is named by the turns of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnRules {
    /// [nats] evidence that it needs.
    pub nats: f64,
    /// [1] logarithm by which the error scale around turns has to fall.
    pub log_scale: f64,
}

impl Default for TurnRules {
    /// Clean machines by seed reach 25 nats and 3 %, not at the same time; an effect that reaches more there has a
    /// [reserve](crate::effects::AtTurns::reserve) of its own.
    fn default() -> Self {
        Self { nats: 30.0, log_scale: 0.06 }
    }
}

impl TurnRules {
    /// Fewest rows around turns that are judged.
    const FEWEST: usize = 200;
    /// Part of a parameter's scale that a simulation with hard flanks along a smooth motion may be wrong by, seen on machines by seed.
    const SYSTEMATIC: f64 = 0.2;
    /// Part of its evidence by which a rival's may differ from it by chance.
    const VAGUE: f64 = 0.1;
}

/// What friction and gear do at the turns of a joint.
pub struct Reversal;

impl Instrument<FittedRows<'_>> for Reversal {
    fn measure(&self, scene: &FittedRows) -> Result<Measurement> {
        if scene.shaken {
            return Ok(Measurement::default());
        }
        let (rules, problem) = (TurnRules::default(), scene.problem);
        let candidates = search::candidates(problem, scene.sessions, scene.left);
        let found = search::named(&candidates, &rules);
        let entries = found.iter().map(|one| entry(problem, one, &candidates, &rules)).collect();
        Ok(Measurement { findings: part(entries, &problem.catalogue), ..Measurement::default() })
    }
}

fn entry(problem: &Problem, one: &TurnCandidate, all: &[TurnCandidate], rules: &TurnRules) -> FoundEffect {
    let about = one.effect.about();
    let joint = &problem.motion.model.joints[one.joint];
    let rivals = || all.iter().filter(|other| other.joint == one.joint && other.effect.name() != about.name);
    let unit = TurnRules::VAGUE * one.total() + 3.0;
    let odds = |difference: f64| (difference / unit).exp();
    let of_rivals: f64 = rivals().map(|rival| odds(rival.total() - one.total())).sum();
    let measured = about.parameters.iter().zip(&one.values).map(|(spec, [value, std_error])| {
        let estimate = Estimate { value: *value, std_error: *std_error };
        (spec.name.to_owned(), Measured::of(estimate, spec.unit_for(joint.kind)))
    });
    let standing = Standing {
        probability: calibrated(of_rivals + odds(rules.nats - 2.0 * unit - one.total())),
        evidence_nats: one.total(),
        gain: EffectGain::of(one.gain, "torque around reversals"),
    };
    let close = rivals().filter(|rival| rival.total() > 0.85 * one.total());
    let close = close.map(|rival| rival.effect.name().to_owned()).collect();
    FoundEffect::new(about, vec![joint.name.clone()], measured.collect(), standing).beside(close)
}

//! Effects that show only at reversals: the reversal zone, which the rigid fit leaves out, against a simulation of the gear.
//!
//! ```text
//!  residual of the rigid fit ─▶ rows around turns ─ less what a simulated gear lacks ─▶ regression ─▶ gap, link share
//!                                                       ▲                                                │
//!                           gear along the measured motion ◀─ effect.install ◀─ trials of each effect ◀──┘
//! ```
//! A hard gear with a gap is simulated along the measured motion of the rotor, once as fitted and once with an effect installed. Where the name of
//! an effect claims a dependence, the gear as fitted also has the effect without it, if that explains more.
//! An effect is chosen if the difference explains training rows that were not used for the fit and the interval of its size excludes zero, and named
//! if it gains on held-out data.
//!
//! `turn_rows` selects the rows, `path` gives the motion on a fine grid of times, `gear` simulates, `attempt` fits gap, share and effects,
//! `judge` compares fits, and `search` finds the effects.

mod attempt;
mod gear;
mod judge;
mod path;
mod search;
mod turn_rows;

#[cfg(test)]
mod tests;

use crate::diagnose::evidence::probability::beside_rivals;
use crate::diagnose::instruments::{FittedRows, Instrument, Measurement};
use crate::diagnose::result::{EffectGain, FoundEffect, Measured, Standing};
use crate::diagnose::select::confirm::part;
use crate::error::Result;
use crate::timeseries::{Channel, Estimate, TimeSeries};
use search::TurnCandidate;

/// Conditions under which an effect is named at the reversals of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnRules {
    /// [nats] Evidence that it needs.
    pub nats: f64,
    /// [1] Logarithm by which the error scale around reversals has to fall.
    pub log_scale: f64,
}

impl Default for TurnRules {
    /// Simulated machines without effects reach 25 nats and 3 %, not at the same time. An effect that reaches more on such machines has its
    /// own [reserve](crate::effects::AtTurns::reserve).
    fn default() -> Self {
        Self { nats: 30.0, log_scale: 0.06 }
    }
}

impl TurnRules {
    /// Least number of rows around reversals.
    const FEWEST: usize = 200;
    /// Error of a parameter by the simulation with hard flanks along a smooth motion, relative to its scale, observed on simulated machines.
    const SYSTEMATIC: f64 = 0.2;
    /// Relative difference of two rivals' evidence that occurs by chance.
    const VAGUE: f64 = 0.1;
}

/// The instrument for friction and gear at the reversals of a joint.
pub struct Reversal;

impl Instrument<FittedRows<'_>> for Reversal {
    fn measure(&self, scene: &FittedRows) -> Result<Measurement> {
        if scene.shaken {
            return Ok(Measurement::default());
        }
        let (rules, problem) = (TurnRules::default(), scene.problem);
        let candidates = search::candidates(problem, scene.sessions, scene.left);
        let found = search::named(&candidates, &rules);
        let entries = found.iter().map(|one| entry(scene, one, &candidates, &rules)).collect();
        Ok(Measurement { findings: part(entries, &problem.catalogue), ..Measurement::default() })
    }
}

fn entry(scene: &FittedRows, one: &TurnCandidate, all: &[TurnCandidate], rules: &TurnRules) -> FoundEffect {
    let about = one.effect.about();
    let joint = &scene.problem.motion.model.joints[one.joint];
    let rivals = || all.iter().filter(|other| other.joint == one.joint && other.effect.name() != about.name);
    let unit = TurnRules::VAGUE * one.total() + 3.0;
    let odds = |difference: f64| (difference / unit).exp();
    let of_rivals: f64 = rivals().map(|rival| odds(rival.total() - one.total())).sum();
    let measured = about.parameters.iter().zip(&one.values).map(|(spec, [value, std_error])| {
        let estimate = Estimate { value: *value, std_error: *std_error };
        (spec.name.to_owned(), Measured::of(estimate, spec.unit_for(joint.kind)))
    });
    let standing = Standing {
        probability: beside_rivals(of_rivals, odds(rules.nats - 2.0 * unit - one.total())),
        evidence_nats: one.total(),
        gain: EffectGain::of(one.gain, "torque around reversals"),
    };
    let close = rivals().filter(|rival| rival.total() > 0.85 * one.total());
    let close = close.map(|rival| rival.effect.name().to_owned()).chain(unseen(scene, one)).collect();
    FoundEffect::new(about, vec![joint.name.clone()], measured.collect(), standing).beside(close)
}

/// Look-alikes that show neither at reversals nor in a torque along the motion: without a second encoder nothing rules them out. A gear ten times as
/// soft as stated bends at a reversal as bristles do.
fn unseen(scene: &FittedRows, one: &TurnCandidate) -> Vec<String> {
    let joint = &scene.problem.motion.model.joints[one.joint].name;
    let link =
        |session: &&TimeSeries| session.joint(joint).and_then(|series| series.get(Channel::LinkPosition)).is_some();
    if scene.sessions.iter().any(link) {
        return Vec::new();
    }
    let hidden = |name: &&&str| {
        let effect = scene.options.catalogue.find(name);
        effect.is_some_and(|effect| effect.at_turns().is_none() && effect.diagnosable().is_none())
    };
    one.effect.about().look_alikes.iter().filter(hidden).map(|name| (*name).to_owned()).collect()
}

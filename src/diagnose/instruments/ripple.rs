//! Ripple of many periods per turn, which shows in the acceleration: rows with narrow kernels, and recordings without the ripple.
//!
//! A wide row averages over 20 to 80 ms until the encoder's noise is small ([`observe`](crate::diagnose::rows::observe)), and its gain
//! `K̂(n θ̇ w)` for a fast ripple is then almost zero. A ripple of known order does not need such rows: half the width has `2^2.5` times the noise,
//! and thousands of rows average it. This instrument uses a second set of rows, a few encoder counts wide, where the joint moves and is away
//! from its reversals. Effects that need narrow rows are judged there, together with other effects that repeat with an angle and look alike.
//! Their torque is then subtracted from the recorded one, sample by sample, so that the wide rows do not contain it.
//! Left out: in the corrected recordings, phases of held-out sessions that differ from those of the training sessions.

use crate::diagnose::fit::pose::needs_narrow_rows;
use crate::diagnose::options::Rules;
use crate::diagnose::select::findings::found;
use std::collections::BTreeMap;

use super::order_lines;
use super::removal;
use super::{Instrument, Measurement, Recordings};
use crate::diagnose::evidence::patterns::curves;
use crate::diagnose::fit::problem::{Part, Problem};
use crate::diagnose::fit::term::Term;
use crate::diagnose::fit::uncertainty::Uncertainty;
use crate::diagnose::result::{EffectGain, Findings};
use crate::diagnose::rows::division::held_out_rows;
use crate::diagnose::rows::inertia::typical_inertia;
use crate::diagnose::rows::observe;
use crate::diagnose::rows::reversals::near_reversal;
use crate::diagnose::rows::widths::Noise;
use crate::diagnose::select::confirm;
use crate::diagnose::select::selection::{Selection, select};
use crate::diagnose::select::substitutes;
use crate::effects::{Catalogue, Effect, Harmonic, Motion, Phenomenon, Scope};
use crate::error::Result;
use crate::timeseries::Estimate;

/// Noise of the acceleration: thirteen times the share of wide rows in the RMS torque gives kernels of a third of the width.
const NOISE: Noise = Noise { of_torque: 0.2, of_acceleration: f64::INFINITY };
/// Least number of encoder counts in a row, so that its velocity and phase are known.
const COUNTS: f64 = 4.0;
/// Share of a joint's fastest motion below which its rows are not used.
const LEAST_SPEED: f64 = 0.1;
/// [s] Time around a reversal, in which the link crosses its gap.
const REVERSAL: f64 = 0.1;
/// Least number of rows of a joint.
const FEWEST: usize = 200;
/// The quantity in which the gains are given here.
const NARROW: &str = "torque along the measured motion, narrow kernels";

/// The instrument for ripple of many periods per turn.
pub struct Ripple;

impl Instrument<Recordings<'_>> for Ripple {
    fn measure(&self, scene: &Recordings) -> Result<Measurement> {
        Ok(find(scene).unwrap_or_default())
    }
}

/// Whether a term needs narrow rows.
fn is_narrow(term: &Term) -> bool {
    needs_narrow_rows(&*term.effect)
}

/// The effects that need narrow rows, other effects that repeat with an angle, and a lag between torque and motion, which shows in fast changes.
fn of_narrow_rows(catalogue: &Catalogue) -> Catalogue {
    let one = Estimate { value: 1.0, std_error: 1.0 };
    let lag = Phenomenon::CurrentLag { lag: one };
    let takes_part = |effect: &&'static dyn Effect| {
        let repeats = |harmonic: Harmonic| harmonic.several || harmonic.in_narrow_rows.is_some();
        effect.diagnosable().and_then(|effect| effect.harmonic()).is_some_and(repeats) || effect.claims(&lag).is_some()
    };
    catalogue.iter().filter(takes_part).collect()
}

/// The same with all effects of a joint, such as a spring or a balancer.
fn of_joints(catalogue: &Catalogue) -> Catalogue {
    let of_joint =
        |effect: &&'static dyn Effect| effect.diagnosable().is_some() && effect.about().scope == Scope::Joint;
    catalogue.iter().filter(of_joint).collect()
}

/// Whether a line shows once slow curves over the stroke of each joint are fitted: what a spring leaves there raises all orders together.
fn shows_beside_curves(problem: &mut Problem) -> bool {
    let of_joint = |joint: usize| curves(&problem.motion, joint);
    let terms: Vec<Term> = problem.joints().into_iter().flat_map(of_joint).collect();
    let terms: Vec<&Term> = terms.iter().collect();
    let Some(fitted) = problem.fit_loosely(&terms, Part::Train) else { return false };
    problem.count_independent(&fitted);
    order_lines::any(problem, &terms, &fitted)
}

/// Looks for ripple in the training data.
fn find(scene: &Recordings) -> Option<Measurement> {
    let Recordings { model, sessions, division, options } = *scene;
    let motion = observe::observe(model, sessions, &typical_inertia(model), NOISE).ok()?;
    let held_out = held_out_rows(&motion, sessions, division);
    let mut problem = Problem::new(motion, held_out);
    problem.deviate();
    problem.name_from(of_narrow_rows(&options.catalogue));
    problem.zones = (0..model.joints.len()).map(|joint| moving(&problem.motion, joint)).collect();
    problem.judged.clone_from(&problem.zones);
    if problem.zones.iter().any(|zone| zone.iter().filter(|takes_part| **takes_part).count() < FEWEST) {
        return None;
    }
    let fitted = problem.settle(&[])?;
    problem.count_independent(&fitted);
    if !order_lines::any(&problem, &[], &fitted) {
        if !shows_beside_curves(&mut problem) {
            return None;
        }
        problem.name_from(of_joints(&options.catalogue));
    }
    let mut selection = select(&mut problem, &Rules { most: 4, ..options.rules }, &mut |_, _| {})?;
    substitutes::withdraw(&mut problem, &mut selection)?;
    keep_lines(&mut problem, &mut selection)?;
    let confirmed = confirm::confirm(&mut problem, &mut selection, 0, &is_narrow, Some(&options.rules))?;
    let names: Vec<&str> = selection.terms().iter().filter(|term| is_narrow(term)).map(|t| t.effect.name()).collect();
    let withdrawn = confirmed.withdrawn.clone();
    if names.is_empty() {
        let findings = Findings { withdrawn, ..Findings::default() };
        return (!findings.withdrawn.is_empty()).then_some(Measurement { findings, ..Measurement::default() });
    }
    let uncertainty = Uncertainty::new(&problem, &selection.terms(), &selection.fitted)?;
    let mut effects = found(&problem, &selection, &confirmed, &uncertainty, &options.rules);
    effects.retain(|found| names.contains(&found.effect.as_str()));
    for found in &mut effects {
        found.gain = EffectGain { gain_of: NARROW.to_owned(), gain_by_joint: BTreeMap::new(), ..found.gain.clone() };
    }
    let corrected = removal::without(&problem, &selection, sessions, &is_narrow);
    let lines = selection.terms().into_iter().filter(|term| is_narrow(term)).filter_map(|term| {
        let joint = term.joints[0];
        Some((joint, (term.effect.harmonic()?.order)(&problem.motion, joint, &term.shape)))
    });
    let findings = Findings { effects, withdrawn, ..Findings::default() };
    Some(Measurement { findings, lines: lines.collect(), corrected, ..Measurement::default() })
}

/// Drops ripple terms that are not lines, until only lines remain.
fn keep_lines(problem: &mut Problem, selection: &mut Selection) -> Option<()> {
    loop {
        let terms = selection.terms();
        let broad = (0..terms.len()).find(|i| is_narrow(terms[*i]) && !order_lines::is_line(problem, &terms, *i));
        let Some(broad) =
            broad.map(|index| (terms[index].effect.name(), terms[index].joints[0], terms[index].shape.clone()))
        else {
            return Some(());
        };
        for taken in &mut selection.taken {
            taken.terms.retain(|t| (t.effect.name(), t.joints[0], &t.shape) != (broad.0, broad.1, &broad.2));
        }
        selection.taken.retain(|taken| !taken.terms.is_empty());
        selection.settle(problem)?;
    }
}

/// Rows in which a joint moves, away from its reversals.
fn moving(motion: &Motion, joint: usize) -> Vec<bool> {
    let v = &motion.joints[joint].v;
    let fastest = v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let count = motion.model.joints[joint].encoder_step();
    let slow = |row: usize| v[row].abs() < (LEAST_SPEED * fastest).max(COUNTS * count / (2.0 * motion.half_width[row]));
    let reverses = near_reversal(motion, joint, REVERSAL);
    (0..motion.rows()).map(|row| !slow(row) && !reverses[row]).collect()
}

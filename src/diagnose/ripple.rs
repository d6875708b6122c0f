//! Ripple that shows in the acceleration at many periods a turn: rows of narrow kernels, and recordings without it.
//!
//! A row that has to speak for itself averages until the encoder's noise is small ([`observe`](super::observe)), over 20 to 80 ms, and
//! `K̂(n θ̇ w)` of a fast ripple is nothing by then. A ripple of known order needs no such row: half the width has `2^2.5` times the noise,
//! and thousands of rows average it. So there is a second set of rows, a few encoder counts wide, while the joint moves on and away from
//! its reversals; effects that need it are judged there, beside those that repeat with an angle as well and could be taken for them.
//! What they added to the torque is then taken off the recorded one, sample by sample, and the wide rows do not see it any more.
//! Left out: phases of held-out sessions that differ from the trained ones, in the recordings without it.

use std::collections::BTreeMap;

use super::conclude;
use super::confirm;
use super::division::Division;
use super::observe;
use super::order_lines;
use super::problem::{Problem, Term};
use super::result::{EffectGain, FoundEffect, Withdrawn};
use super::selection::{Rules, Selection, select};
use super::stand_ins;
use super::uncertainty::Uncertainty;
use super::{Options, held_out_rows, mended, typical_inertia};
use crate::effects::{Catalogue, Diagnosable, Motion};
use crate::robot::Model;
use crate::timeseries::TimeSeries;

/// Share of the RMS torque that noise of the acceleration may make: thirteen times that of wide rows make kernels of a third.
const NOISE_SHARE: f64 = 0.2;
/// Counts of the encoder that a row has to pass, so that its velocity and phase are known.
const COUNTS: f64 = 4.0;
/// Share of a joint's fastest motion below which its acceleration says too little.
const LEAST_SPEED: f64 = 0.1;
/// [s] Around a reversal, where the link crosses its gap.
const REVERSAL: f64 = 0.1;
/// Fewest rows of a joint.
const FEWEST: usize = 200;
/// What the gains here are of.
const NARROW: &str = "torque along the measured motion, narrow kernels";

/// Ripple that was found, and what is left without it.
pub struct Ripple {
    /// The effects.
    pub effects: Vec<FoundEffect>,
    /// Those without a gain on what is held out; they were not taken off.
    pub withdrawn: Vec<Withdrawn>,
    /// Joint and order of each line that was taken out.
    pub lines: Vec<(usize, f64)>,
    /// The sessions without what it added to the torque.
    pub mended: Vec<TimeSeries>,
}

/// The effects of a catalogue that wide rows show.
pub fn of_wide_rows(catalogue: &Catalogue) -> Catalogue {
    catalogue.iter().filter(|effect| effect.diagnosable().is_none_or(|effect| !effect.needs_narrow_rows())).collect()
}

/// Those that need narrow ones, those that repeat with an angle, and a lag between torque and motion, which shows where both change fast.
fn of_narrow_rows(catalogue: &Catalogue) -> Catalogue {
    let takes_part =
        |effect: &dyn Diagnosable| effect.needs_narrow_rows() || effect.repeats() || effect.of_lag(0.0).is_some();
    catalogue.iter().filter(|effect| effect.diagnosable().is_some_and(takes_part)).collect()
}

/// Looks for ripple in what is trained on.
pub fn find(model: &Model, sessions: &[&TimeSeries], division: Division, options: &Options) -> Option<Ripple> {
    let motion = observe::observe(model, sessions, &typical_inertia(model), NOISE_SHARE).ok()?;
    let held_out = held_out_rows(&motion, sessions, division);
    let mut problem = Problem::new(motion, held_out);
    problem.catalogue = of_narrow_rows(&options.catalogue);
    problem.zones = (0..model.joints.len()).map(|joint| moving(&problem.motion, joint)).collect();
    problem.judged.clone_from(&problem.zones);
    if problem.zones.iter().any(|zone| zone.iter().filter(|takes_part| **takes_part).count() < FEWEST) {
        return None;
    }
    let fitted = problem.settle(&[])?;
    problem.count_independent(&fitted);
    if !order_lines::any(&problem, &fitted) {
        return None;
    }
    let mut selection = select(&mut problem, &Rules { most: 4, ..options.rules }, &mut |_, _| {})?;
    stand_ins::withdraw(&mut problem, &mut selection)?;
    keep_lines(&mut problem, &mut selection)?;
    let is_ripple = |term: &Term| term.effect.needs_narrow_rows();
    let confirmed = confirm::confirm(&mut problem, &mut selection, 0, &is_ripple)?;
    let names: Vec<&str> =
        selection.terms().iter().filter(|t| t.effect.needs_narrow_rows()).map(|t| t.effect.name()).collect();
    let withdrawn = confirmed.withdrawn.clone();
    if names.is_empty() {
        let (effects, lines, mended) = (Vec::new(), Vec::new(), Vec::new());
        return (!withdrawn.is_empty()).then_some(Ripple { effects, withdrawn, lines, mended });
    }
    let uncertainty = Uncertainty::new(&problem, &selection.terms(), &selection.fitted)?;
    let mut effects = conclude::found(&problem, &selection, &confirmed, &uncertainty, options);
    effects.retain(|found| names.contains(&found.effect.as_str()));
    for found in &mut effects {
        found.gain = EffectGain { gain_of: NARROW.to_owned(), gain_by_joint: BTreeMap::new(), ..found.gain.clone() };
    }
    let mended = mended::without(&problem, &selection, sessions, &is_ripple);
    let lines = selection.terms().into_iter().filter(|term| term.effect.needs_narrow_rows()).filter_map(|term| {
        let joint = term.joints[0];
        Some((joint, term.effect.order(&problem.motion, joint, &term.shape)?))
    });
    Some(Ripple { effects, withdrawn, lines: lines.collect(), mended })
}

/// Drops what would be ripple and is no line, until all that is left is one.
fn keep_lines(problem: &mut Problem, selection: &mut Selection) -> Option<()> {
    loop {
        let terms = selection.terms();
        let broad = (0..terms.len())
            .find(|i| terms[*i].effect.needs_narrow_rows() && !order_lines::is_line(problem, &terms, *i));
        let Some(broad) =
            broad.map(|index| (terms[index].effect.name(), terms[index].joints[0], terms[index].shape.clone()))
        else {
            return Some(());
        };
        for taken in &mut selection.taken {
            taken.terms.retain(|t| (t.effect.name(), t.joints[0], &t.shape) != (broad.0, broad.1, &broad.2));
        }
        selection.taken.retain(|taken| !taken.terms.is_empty());
        selection.fitted = problem.settle(&selection.terms())?;
    }
}

/// Rows in which a joint moves on, away from its reversals.
fn moving(motion: &Motion, joint: usize) -> Vec<bool> {
    let v = &motion.joints[joint].v;
    let fastest = v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let count = motion.model.joints[joint].encoder_step();
    let slow = |row: usize| v[row].abs() < (LEAST_SPEED * fastest).max(COUNTS * count / (2.0 * motion.half_width[row]));
    let mut moving: Vec<bool> = (0..motion.rows()).map(|row| !slow(row)).collect();
    for row in 1..motion.rows() {
        let same = motion.session[row] == motion.session[row - 1];
        if same && v[row].signum() != v[row - 1].signum() {
            let near = |other: &usize| {
                motion.session[*other] == motion.session[row]
                    && (motion.time[*other] - motion.time[row]).abs() < REVERSAL
            };
            (0..row).rev().take_while(near).for_each(|other| moving[other] = false);
            (row..motion.rows()).take_while(near).for_each(|other| moving[other] = false);
        }
    }
    moving
}

//! Diagnosis: finds what the nominal model gets wrong on a recording, and which effects explain it.
//!
//! A diagnosis runs in stages, listed here from left to right of the import rule. A stage imports only stages above it.
//!
//! | stage | takes → gives |
//! |---|---|
//! | `result` | what a diagnosis returns, and the one place that assembles it |
//! | `options` | the options of a diagnosis, and the thresholds at which an effect is named |
//! | `rows` | recordings → rows of smooth motion and torque: kernel, reversals, rigid zones, held-out part |
//! | `mistakes` | recordings, rows → errors of data or model file that are likelier than physics, which end the diagnosis; a model whose guessed torque constants agree with the recordings |
//! | `fit` | rows + terms → robust fit, uncertainty |
//! | `residuals` | rows + fit → errors, gains, maps, shares, spectra, floor of the sensors |
//! | `evidence` | fit → evidence, probability, separability; patterns without physics |
//! | `select` | candidates → the effects that evidence and held-out gain support |
//! | `instruments` | recordings → phenomena that the torque of smooth rows does not show, and recordings without them |
//! | `conclude` | selection + instruments → diagnosis |
//! | `judge` | diagnosis + recordings → probabilities of sets of effects, by the score of every sample; optional |
//! | `change` | two recordings → what differs between them |
//!
//! `select` stands above `instruments` because the instrument `ripple` selects effects on rows of its own.

/// Which quantities differ between two recordings of one machine.
mod change;
mod conclude;
mod evidence;
mod fit;
mod instruments;
/// Probabilities of sets of effects, by the score of every sample.
pub mod judge;
/// Mistakes in data or model file that are likelier than physics.
pub mod mistakes;
mod options;
mod residuals;
/// What a diagnosis returns.
pub mod result;
mod rows;
mod select;

pub use change::compare;
pub use evidence::separability;
pub use fit::typical::typical;
pub use options::{Options, Rules};
pub use result::{
    Axis, AxisShare, BaselineEstimate, CandidateRecord, Change, Diagnosis, Distance, EffectGain, FitError, FoundEffect,
    FrequencySpectrum, JointShares, JudgedEffect, JudgedMachine, JudgedName, JudgedSet, JudgedWindow, Judgement,
    Measured, Method, OrderSpectrum, PredictionSeries, ReplayError, ResidualMap, ResidualSeries, Split, TwoEncoders,
    Unexplained, Verdict, Withdrawn, Zone, ZoneShares,
};

use crate::effects::applied;
use crate::error::Result;
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};
use conclude::delay;
use fit::pose::{nothing_moves, pose};
use instruments::preparation::{self, Prepared};
use instruments::{Instrument, ON_RECORDINGS, ON_ROWS, Recordings, WITHOUT_DELAY};
use mistakes::guessed;
pub use rows::division::Division;
use rows::measured::{as_measured, complete};
use select::{naming, selection, substitutes};

/// Channels that a diagnosis reads; all others may be dropped.
pub fn channels() -> Vec<Channel> {
    vec![
        Channel::Position,
        Channel::Velocity,
        Channel::Current,
        Channel::Torque,
        Channel::LinkTorque,
        Channel::CommandCurrent,
        Channel::ReferenceVelocity,
        Channel::LinkPosition,
    ]
}

/// Channels that a comparison of two recordings reads: commands show no change.
pub fn compared_channels() -> Vec<Channel> {
    channels().into_iter().filter(|channel| *channel != Channel::CommandCurrent).collect()
}

/// Names the effects that the nominal model lacks; `progress` receives the current step and the finished share (0 to 1).
///
/// The sessions `hold_out` are used for judging only. Without any, the ends of the training sessions are held out instead ([`Division`]).
///
/// # Errors
/// A session lacks the position, or the current or torque, of a joint; or there is too little motion.
pub fn diagnose(
    model: &Model,
    train: &[TimeSeries],
    hold_out: &[TimeSeries],
    options: &Options,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Diagnosis> {
    let given = applied(model, &options.catalogue)?;
    let model = &given.model;
    let recorded: Vec<&TimeSeries> = train.iter().chain(hold_out).collect();
    let (usable, dead) = mistakes::without_dead_channels(model, &recorded);
    let usable: Vec<&TimeSeries> = usable.iter().map(AsRef::as_ref).collect();
    let seen = as_measured(model, &usable);
    let division = Division::of(&recorded, train.len(), options.held_out_share);
    let mut diagnosis = diagnose_as_measured(&seen, &usable, division, options, progress)?;
    diagnosis.dead_channels = dead;
    diagnosis.method.listed_effects = conclude::listed_effects(&given);
    complete(&mut diagnosis.baseline_model, model);
    complete(&mut diagnosis.extended_model, model);
    Ok(diagnosis)
}

/// The diagnosis with a model as the recordings see it.
fn diagnose_as_measured(
    model: &Model,
    recorded: &[&TimeSeries],
    division: Division,
    options: &Options,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Diagnosis> {
    progress("looking for mistakes", 0.0);
    let given = model;
    let model = &*guessed::with_constants(given, recorded, division);
    let suspected = mistakes::suspected_by_part(model, recorded, division);
    if !suspected.is_empty() {
        return Ok(mistakes::diagnosis(given, suspected, false, options));
    }
    let judged = |instruments: &[_], progress: &mut dyn FnMut(&str, f64)| {
        diagnose_prepared(model, recorded, division, options, instruments, progress)
    };
    let mut diagnosis = match judged(ON_RECORDINGS, progress)? {
        Some(diagnosis) => diagnosis,
        None => judged(WITHOUT_DELAY, progress)?.ok_or_else(|| nothing_moves(model))?,
    };
    diagnosis.method.baseline += &guessed::words(given, model);
    Ok(diagnosis)
}

/// The diagnosis of recordings that instruments have prepared; `None` where the rows refute the delay by which one of them shifted the currents.
fn diagnose_prepared(
    model: &Model,
    recorded: &[&TimeSeries],
    division: Division,
    options: &Options,
    instruments: &[&dyn for<'r> Instrument<Recordings<'r>>],
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Option<Diagnosis>> {
    progress("smoothing", 0.0);
    let Prepared { sessions, delay, earlier, shaken, ripple, as_recorded } =
        preparation::prepare(model, recorded, division, options, instruments)?;
    let sessions: Vec<&TimeSeries> = sessions.iter().map(AsRef::as_ref).collect();
    let mut problem = pose(model, &sessions, division, options)?;
    problem.taken_out = ripple;
    progress("fitting the baseline", 0.1);
    let rules = if as_recorded.is_some() { options.rules.beside_another() } else { options.rules };
    let mut selection = selection::select(&mut problem, &rules, progress).ok_or_else(|| nothing_moves(model))?;
    if delay::is_undone(&selection, delay) {
        return Ok(None);
    }
    substitutes::withdraw(&mut problem, &mut selection).ok_or_else(|| nothing_moves(model))?;
    if let Some(as_recorded) = as_recorded {
        selection.as_recorded = as_recorded.at_rows_of(&problem);
    }
    let confirmed =
        naming::name(&mut problem, &mut selection, [&rules, &options.rules]).ok_or_else(|| nothing_moves(model))?;
    let data = conclude::Data { model, sessions: &sessions, division, earlier, instruments: &ON_ROWS, shaken };
    let mut parts = conclude::conclude(&data, &problem, &selection, &confirmed, options, progress)?;
    parts.mistakes = mistakes::remaining::found(model, recorded, &parts);
    Ok(Some(parts.assembled()))
}

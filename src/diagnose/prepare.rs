//! What is found before rows of smooth motion are made, and taken off the recordings: a late current, lines in time, fast ripple.
//!
//! None of them shows in wide rows as what it is, and each disturbs what is judged there. Each is found in what is trained on, and taken off
//! where it gains on what is held out.

use std::borrow::Cow;

use super::conclude::Earlier;
use super::division::Division;
use super::gains;
use super::problem::Problem;
use super::result::{EffectGain, FoundEffect, Measured, Unexplained, Withdrawn};
use super::selection::Nominal;
use super::timing::{self, Late};
use super::{Options, confirm, lines, nothing_moves, pose, ripple};
use crate::error::Result;
use crate::robot::{Masses, Model};
use crate::timeseries::{Estimate, TimeSeries};

/// Recordings ready for wide rows.
pub struct Prepared<'s> {
    /// The recordings, as they are or corrected.
    pub sessions: Vec<Cow<'s, TimeSeries>>,
    /// What was named, or withdrawn.
    pub earlier: Earlier,
    /// Whether a fast torque was taken off.
    pub shaken: bool,
    /// Joint and order of each ripple that was taken off.
    pub ripple: Vec<(usize, f64)>,
    /// The nominal model beside the recordings as they are, where they were corrected.
    pub as_recorded: Option<AsRecorded>,
}

/// Residuals of the nominal model, with the rows that they belong to.
pub struct AsRecorded {
    session: Vec<usize>,
    time: Vec<f64>,
    residuals: Vec<Vec<f64>>,
}

impl AsRecorded {
    /// Poses and fits the nominal model.
    fn new(model: &Model, sessions: &[&TimeSeries], division: Division, options: &Options) -> Result<Self> {
        let mut problem = pose(model, sessions, division, options)?;
        let nominal = nominal(&mut problem).ok_or_else(|| nothing_moves(model))?;
        let (session, time) = (problem.motion.session, problem.motion.time);
        Ok(Self { session, time, residuals: nominal.residuals })
    }

    /// The residuals at the rows of another problem: of the nearest row in time. Corrected recordings may ask for other kernels.
    pub fn at_rows_of(&self, problem: &Problem) -> Vec<Vec<f64>> {
        let (sessions, times) = (&problem.motion.session, &problem.motion.time);
        if *sessions == self.session && *times == self.time {
            return self.residuals.clone();
        }
        let nearest = |(session, time): (&usize, &f64)| {
            let first = self.session.partition_point(|own| own < session);
            let last = self.session.partition_point(|own| own <= session);
            let next = first + self.time[first..last].partition_point(|own| own < time);
            let candidates = [next.saturating_sub(1).max(first), next.min(last.saturating_sub(1)).max(first)];
            let distance = |row: &usize| (self.time[*row] - time).abs();
            candidates.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(first)
        };
        let rows: Vec<usize> = sessions.iter().zip(times).map(nearest).collect();
        self.residuals.iter().map(|values| rows.iter().map(|row| values[*row]).collect()).collect()
    }
}

fn nominal(problem: &mut Problem) -> Option<Nominal> {
    problem.settle(&[])?;
    Nominal::new(problem)
}

/// Looks for what has to be taken off, in the order in which one disturbs the next.
///
/// # Errors
/// A session lacks a channel of a joint, or there is too little motion.
pub fn prepare<'s>(
    model: &Model,
    recorded: &[&'s TimeSeries],
    division: Division,
    options: &Options,
) -> Result<Prepared<'s>> {
    let sessions = recorded.iter().map(|session| Cow::Borrowed(*session)).collect();
    let mut prepared =
        Prepared { sessions, earlier: Earlier::default(), shaken: false, ripple: Vec::new(), as_recorded: None };
    // Where masses are a guess, no torque is evidence of anything.
    if model.masses == Masses::Estimated {
        return Ok(prepared);
    }
    if let Some(Aligned { told, sessions, as_recorded, .. }) = align(model, recorded, division, options)? {
        prepared.earlier = told;
        if !sessions.is_empty() {
            prepared.sessions = sessions.into_iter().map(Cow::Owned).collect();
            prepared.as_recorded = Some(as_recorded);
        }
    }
    if let Some(lines) = lines::find(model, &prepared.borrowed(), division, options) {
        prepared.shaken = !lines.mended.is_empty();
        prepared.note(lines.effects, lines.withdrawn, lines.mended);
    }
    if let Some(ripple) = ripple::find(model, &prepared.borrowed(), division, options) {
        prepared.ripple = ripple.lines;
        prepared.note(ripple.effects, ripple.withdrawn, ripple.mended);
    }
    let corrected = prepared.sessions.iter().any(|session| matches!(session, Cow::Owned(_)));
    if corrected && prepared.as_recorded.is_none() {
        prepared.as_recorded = Some(AsRecorded::new(model, recorded, division, options)?);
    }
    Ok(prepared)
}

impl Prepared<'_> {
    /// The recordings.
    pub fn borrowed(&self) -> Vec<&TimeSeries> {
        self.sessions.iter().map(AsRef::as_ref).collect()
    }

    fn note(&mut self, effects: Vec<FoundEffect>, withdrawn: Vec<Withdrawn>, corrected: Vec<TimeSeries>) {
        self.earlier.effects.extend(effects);
        self.earlier.withdrawn.extend(withdrawn);
        if !corrected.is_empty() {
            self.sessions = corrected.into_iter().map(Cow::Owned).collect();
        }
    }
}

/// Recordings whose late current was brought into step with the motion.
pub struct Aligned {
    /// How late it was.
    pub late: Late,
    /// What that is called, or why it is not.
    pub told: Earlier,
    /// The sessions in step; empty where that gains nothing.
    pub sessions: Vec<TimeSeries>,
    /// The nominal model beside the recordings as they are.
    as_recorded: AsRecorded,
}

/// Brings a late current into step with the motion, where that gains; what no effect of the catalogue explains is told without a name.
///
/// # Errors
/// A session lacks a channel of a joint, or there is too little motion.
pub fn align(
    model: &Model,
    sessions: &[&TimeSeries],
    division: Division,
    options: &Options,
) -> Result<Option<Aligned>> {
    let Some(late) = timing::late_current(model, sessions, division) else { return Ok(None) };
    let aligned: Vec<TimeSeries> = sessions.iter().map(|session| timing::aligned(session, late.lag.value)).collect();
    let as_recorded = AsRecorded::new(model, sessions, division, options)?;
    let mut problem = pose(model, &aligned.iter().collect::<Vec<_>>(), division, options)?;
    let after = nominal(&mut problem).ok_or_else(|| nothing_moves(model))?.residuals;
    let before = as_recorded.at_rows_of(&problem);
    let gain = gains::Judge::new(&problem, &before).effect(&problem.joints(), [&before, &after], [&before, &after]);
    let sessions = if gain.shown() { aligned } else { Vec::new() };
    let told = told(model, late, gain, options);
    Ok(Some(Aligned { late, told, sessions, as_recorded }))
}

/// The effect that a late current is, or what is said where the catalogue has none.
fn told(model: &Model, late: Late, gain: EffectGain, options: &Options) -> Earlier {
    let joints: Vec<String> = model.joints.iter().map(|joint| joint.name.clone()).collect();
    let Estimate { value: lag, std_error } = late.lag;
    let mut effects = options.catalogue.diagnosable();
    let Some((about, values)) = effects.find_map(|effect| Some((effect.about(), effect.of_lag(lag)?))) else {
        let pattern = format!("the current is recorded {:.2} ± {:.2} ms behind the motion", 1e3 * lag, 1e3 * std_error);
        let of_joint = |joint: String| Unexplained { joint, pattern: pattern.clone() };
        let unexplained = if gain.shown() { joints.into_iter().map(of_joint).collect() } else { Vec::new() };
        return Earlier { unexplained, ..Earlier::default() };
    };
    let parameters = about.parameters.iter().zip(values).filter(|(_, value)| *value > 0.0);
    let found = FoundEffect {
        effect: about.name.to_owned(),
        joints,
        kind: about.kind,
        parameters: parameters
            .map(|(spec, value)| (spec.name.to_owned(), Measured { value, std_error, unit: spec.unit }))
            .collect(),
        probability: late.probability,
        evidence_nats: 0.5 * (lag / std_error).powi(2),
        gain,
        confusable_with: Vec::new(),
        separate_by: about.separate_by.to_owned(),
    };
    let (effects, withdrawn) = confirm::part(vec![found], &options.catalogue);
    Earlier { effects, withdrawn, ..Earlier::default() }
}

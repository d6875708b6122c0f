//! A diagnosis of recordings, with nominal and extended model in simulation beside the data held out.

use crate::dataset::{self, Session};
use crate::diagnose::{
    self, Diagnosis, Division, EffectGain, JudgedEffect, Options, PredictionSeries, ReplayError, ResidualSeries, Split,
    Verdict, ZoneShares, judge,
};
use crate::error::{Error, Result};
use crate::replay::prediction::{Ahead, AheadErrors, HORIZONS, compare_predictions};
use crate::replay::{self, Compared, Observable, Replay};
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};
use crate::units::JointKind;

/// Prefix of the names of the healthy machine's sessions.
const REFERENCE: &str = "reference";

/// Name of a session of the healthy machine, where sessions of the present machine are in the same list.
pub fn reference_name(session: &str) -> String {
    format!("{REFERENCE}: {session}")
}

/// Channels that a diagnosis and its replay read; all others may be dropped once the recording is drawn.
pub fn channels() -> Vec<Channel> {
    let mut channels = diagnose::channels();
    channels.extend(replay::CHANNELS);
    channels
}

/// A diagnosis with the simulations of both models beside the data held out.
#[derive(Debug)]
pub struct Findings {
    /// The diagnosis, its replay errors filled in.
    pub diagnosis: Diagnosis,
    /// Why the models could not be replayed beside the data.
    pub replay_failure: Option<Error>,
    /// Why the models' predictions could not be compared with the data: of any joint, or of those that diverge.
    pub prediction_failures: Vec<Error>,
    /// Why the simulation could not judge.
    pub judge_failure: Option<Error>,
}

impl Findings {
    /// Completes the model with what the recordings show ([`dataset::meet`]), diagnoses, and replays; `show` receives the present step and the share of
    /// it that is done.
    ///
    /// # Errors
    /// As [`dataset::meet`] and [`diagnose::diagnose`]. A replay that fails is part of the findings.
    pub fn new(
        model: &Model,
        train: Vec<Session>,
        hold_out: Vec<Session>,
        show: &mut dyn FnMut(&str, f64),
    ) -> Result<Self> {
        let model = &dataset::meet(model, &train.iter().chain(&hold_out).collect::<Vec<_>>())?;
        let diagnosis = diagnose::diagnose(model, &series(&train), &series(&hold_out), &Options::default(), show)?;
        let mut findings = Self::of(diagnosis);
        findings.add_replay(held_out(train, hold_out), show);
        Ok(findings)
    }

    /// Lets the simulation judge by every sample of the recordings that were diagnosed. What it supports enters the diagnosis, and the models are
    /// replayed again. A judgement that fails changes nothing else.
    pub fn judge(
        &mut self,
        train: Vec<Session>,
        hold_out: Vec<Session>,
        options: &judge::Options,
        show: &mut dyn FnMut(&str, f64),
    ) {
        match judge::judge(&self.diagnosis, &series(&train), &series(&hold_out), options, show) {
            Ok(judgement) => (self.diagnosis.judgement, self.judge_failure) = (Some(judgement), None),
            Err(why) => {
                (self.diagnosis.judgement, self.judge_failure) = (None, Some(why));
                return;
            }
        }
        let judged = held_out(train, hold_out);
        adopt(&mut self.diagnosis, &judged, show);
        if self.diagnosis.judgement.as_ref().is_some_and(|judgement| judgement.adopted) {
            self.add_replay(judged, show);
        }
    }

    /// A diagnosis that nothing was simulated for.
    const fn of(diagnosis: Diagnosis) -> Self {
        Self { diagnosis, replay_failure: None, prediction_failures: Vec::new(), judge_failure: None }
    }

    /// Compares with recordings of the healthy machine, and replays it as it was and as it is.
    ///
    /// # Errors
    /// As [`dataset::meet`] and [`diagnose::compare`]. A replay that fails is part of the findings.
    pub fn compared(
        model: &Model,
        reference: Vec<Session>,
        mut now: Vec<Session>,
        hold_out: Vec<Session>,
        show: &mut dyn FnMut(&str, f64),
    ) -> Result<Self> {
        let model = &dataset::meet(model, &reference.iter().chain(&now).chain(&hold_out).collect::<Vec<_>>())?;
        let mut before: Vec<TimeSeries> = reference.into_iter().map(|session| session.series).collect();
        before.iter_mut().for_each(|session| session.name = reference_name(&session.name));
        let options = Options::default();
        let [present, held_out] = [series(&now), series(&hold_out)];
        let recorded: Vec<&TimeSeries> = before.iter().chain(&present).chain(&held_out).collect();
        let division = Division::of(&recorded, before.len() + now.len(), options.held_out_share);
        drop((present, held_out));
        let commands: Vec<TimeSeries> = now.iter_mut().map(take_commands).collect();
        let diagnosis = diagnose::compare(model, &before, &series(&now), &series(&hold_out), &options, show)?;
        let of_now = |(number, (session, commands)): (usize, (Session, TimeSeries))| {
            held_out_of(&with_commands(session, commands), before.len() + number, division)
        };
        let judged = match hold_out.is_empty() {
            true => now.into_iter().zip(commands).enumerate().flat_map(of_now).collect(),
            false => hold_out,
        };
        drop(before);
        let mut findings = Self::of(diagnosis);
        findings.add_replay(judged, show);
        Ok(findings)
    }

    /// Replays the models beside the data held out, and lets them predict, in place of earlier replays; what fails changes nothing else.
    fn add_replay(&mut self, mut judged: Vec<Session>, show: &mut dyn FnMut(&str, f64)) {
        if self.diagnosis.verdict == Verdict::MistakeSuspected {
            return;
        }
        show("replaying", 0.0);
        judged.iter_mut().for_each(|session| session.series.keep(&replay::CHANNELS));
        self.diagnosis.replay.clear();
        self.diagnosis.predictions.clear();
        self.replay_failure = replay(&mut self.diagnosis, &judged).err();
        self.prediction_failures = predict(&mut self.diagnosis, &judged).unwrap_or_else(|why| vec![why]);
    }
}

/// [s] Horizon by whose errors an effect of the judged machine is adopted: long enough for a torque to move what it moves, short enough for hundreds of
/// predictions in a minute.
const AHEAD: f64 = HORIZONS[1];

/// Takes what the score of every sample supports into the diagnosis, where it also predicts the data held out better; what cannot be predicted stays as it is.
fn adopt(diagnosis: &mut Diagnosis, held_out: &[Session], show: &mut dyn FnMut(&str, f64)) {
    let Some(machine) = diagnosis.judgement.as_mut().and_then(|judgement| judgement.machine.take()) else { return };
    show("predicting with what every sample supports", 0.0);
    let gain = |one: &JudgedEffect| -> Option<EffectGain> {
        let ahead = all_predicted(&one.without, &machine.extended, held_out)?;
        let own = ahead.iter().filter(|ahead| ahead.horizon == AHEAD);
        let own = own.filter(|ahead| one.joint.as_ref().is_none_or(|joint| *joint == ahead.joint));
        let most = own.max_by(|a, b| a.gain.gain_percent.total_cmp(&b.gain.gain_percent))?;
        Some(EffectGain::of(most.gain, &format!("position {AHEAD} s ahead")))
    };
    let Some(gains) = machine.effects.iter().map(gain).collect::<Option<Vec<_>>>() else { return };
    let beside = all_predicted(&diagnosis.extended_model, &machine.extended, held_out);
    if beside.is_some_and(|beside| is_better(&beside)) {
        judge::adopt(diagnosis, machine, &gains);
    }
}

/// Predictions of two models, where they can predict every joint.
fn all_predicted(before: &Model, after: &Model, held_out: &[Session]) -> Option<Vec<Ahead>> {
    let ahead = compare_predictions(before, after, held_out, &replay::Options::default()).ok()?;
    ahead.diverged.is_empty().then_some(ahead.made)
}

/// Whether the second model predicts some joint over some horizon better, and none worse.
fn is_better(ahead: &[Ahead]) -> bool {
    ahead.iter().any(|one| one.gain.shown) && !ahead.iter().any(|one| one.gain.interval_percent[1] < 0.0)
}

/// Both models in simulation beside the data held out.
fn replay(diagnosis: &mut Diagnosis, judged: &[Session]) -> Result<()> {
    let (nominal, extended) = (&diagnosis.baseline_model, &diagnosis.extended_model);
    let (compared, replays) = replay::compare_models(nominal, extended, judged, &replay::Options::default())?;
    diagnosis.replay = compared.into_iter().map(|one| replay_error(one, nominal)).collect();
    for joint in &mut diagnosis.shares {
        joint.zones = zone_shares(&joint.joint, &diagnosis.series, &replays);
    }
    Ok(())
}

/// Both models' predictions of the data held out. Returns why joints have none.
fn predict(diagnosis: &mut Diagnosis, judged: &[Session]) -> Result<Vec<Error>> {
    let (nominal, extended) = (&diagnosis.baseline_model, &diagnosis.extended_model);
    let ahead = compare_predictions(nominal, extended, judged, &replay::Options::default())?;
    diagnosis.replay.extend(ahead.made.iter().map(prediction_error));
    diagnosis.predictions = ahead.made.into_iter().flat_map(prediction_series).collect();
    Ok(ahead.diverged)
}

/// The signals alone, which share their samples with the sessions.
fn series(sessions: &[Session]) -> Vec<TimeSeries> {
    sessions.iter().map(|session| session.series.clone()).collect()
}

/// The data held out: the sessions given for it, or else the ends of the others.
fn held_out(train: Vec<Session>, hold_out: Vec<Session>) -> Vec<Session> {
    if !hold_out.is_empty() {
        return hold_out;
    }
    let recorded: Vec<&TimeSeries> = train.iter().map(|session| &session.series).collect();
    let division = Division::of(&recorded, train.len(), Options::default().held_out_share);
    train.iter().enumerate().flat_map(|(number, session)| held_out_of(session, number, division)).collect()
}

/// The held-out parts of a session, each with samples of its own: the rest can be freed.
fn held_out_of(session: &Session, number: usize, division: Division) -> Vec<Session> {
    // A pause may take all samples of a part.
    let parts = division.held_out(number, &session.series).into_iter().filter(|part| part.len() > 1);
    let copied = |part| Session { series: session.series.part(part).on_its_own(), ..session.clone() };
    parts.map(copied).collect()
}

/// Takes the commands out of a session: a comparison reads none, a replay does.
fn take_commands(session: &mut Session) -> TimeSeries {
    let mut commands = session.series.clone();
    commands.keep(&[Channel::CommandCurrent]);
    session.series.keep(&diagnose::compared_channels());
    commands
}

/// A session with its commands.
fn with_commands(mut session: Session, commands: TimeSeries) -> Session {
    for (joint, commands) in session.series.joints.iter_mut().zip(commands.joints) {
        joint.channels.extend(commands.channels);
    }
    session
}

/// Parts of the squared torque error of replays that lie in each zone of a joint.
fn zone_shares(joint: &str, series: &[ResidualSeries], replays: &[Replay]) -> Option<ZoneShares> {
    let (mut sums, mut times) = ([0.0; 3], [0.0; 3]);
    for replay in replays {
        let error = replay.errors.iter().find(|error| error.joint == joint && error.quantity == Observable::Torque)?;
        for series in series.iter().filter(|one| one.joint == joint && one.session == replay.session) {
            let (Some(first), Some(last)) = (series.time.first(), series.time.last()) else { continue };
            for (time, e) in replay.time.iter().zip(&error.difference) {
                if (first..=last).contains(&time) {
                    let row = series.time.partition_point(|row| row <= time).saturating_sub(1);
                    let zone = series.zone[row] as usize;
                    sums[zone] += e * e;
                    times[zone] += 1.0;
                }
            }
        }
    }
    let percent = |parts: [f64; 3]| {
        let total: f64 = parts.iter().sum();
        parts.map(|part| 100.0 * part / total.max(f64::MIN_POSITIVE))
    };
    let [rigid_percent, reversal_percent, rest_percent] = percent(sums);
    let zones = ZoneShares { rigid_percent, reversal_percent, rest_percent, time_percent: percent(times) };
    sums.iter().any(|sum| *sum > 0.0).then_some(zones)
}

/// One channel of the report.
fn replay_error(compared: Compared, model: &Model) -> ReplayError {
    let Compared { joint, quantity, unit, before, after, gain } = compared;
    let slides = model.joints.iter().any(|one| one.name == joint && one.kind == JointKind::Prismatic);
    let quantity = match quantity {
        Observable::Position => "position",
        Observable::Velocity => "velocity",
        Observable::Torque if slides => "force",
        Observable::Torque => "torque",
    };
    ReplayError { joint, quantity, unit, split: Split::HeldOut, horizon: None, before, after, floor: None, gain }
}

/// One horizon of the report.
fn prediction_error(ahead: &Ahead) -> ReplayError {
    let Ahead { joint, horizon, unit, before, after, floor, gain, .. } = ahead;
    ReplayError {
        joint: joint.clone(),
        quantity: "position",
        unit,
        split: Split::HeldOut,
        horizon: Some(*horizon),
        before: *before,
        after: *after,
        floor: Some(*floor),
        gain: *gain,
    }
}

/// Errors of one horizon over time.
fn prediction_series(ahead: Ahead) -> impl Iterator<Item = PredictionSeries> {
    let Ahead { joint, horizon, unit, errors, .. } = ahead;
    errors.into_iter().map(move |AheadErrors { session, time, before, after }| PredictionSeries {
        joint: joint.clone(),
        session,
        horizon,
        unit,
        time,
        before,
        after,
    })
}

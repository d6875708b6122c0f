//! `lostmotion diagnose --model M --data F...`.

use std::path::PathBuf;

use clap::Args;
use serde_json::Value;

use crate::dataset::Session;
use crate::diagnose::{self as diagnosis, Diagnosis, Options, ReplayError, ResidualSeries, Split, Verdict, ZoneShares};
use crate::error::{Error, Result};
use crate::replay::{self, Compared, Observable, Replay};
use crate::report::files::{envelope, planned};
use crate::report::recording::Motion;
use crate::report::{Report, diagnosis as rendering};
use crate::robot::Model;
use crate::timeseries::{Channel, Drawn, TimeSeries};
use crate::units::JointKind;

use super::console::{OutputOptions, Progress};
use super::folder::{Folder, Request};
use super::{Outcome, console, input};

/// Find what the simulation gets wrong: the named cause, the extended model, the gain
#[derive(Debug, Args)]
pub struct Diagnose {
    /// Nominal model: a file, or the name of a robot of the catalogue
    #[arg(long, value_name = "MODEL")]
    model: PathBuf,
    /// Recordings: canonical CSV, or manifests
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    data: Vec<PathBuf>,
    /// Recordings of the same machine when it was healthy: find what has changed between them and --data
    #[arg(long, value_name = "FILE", num_args = 1..)]
    reference: Vec<PathBuf>,
    /// Recordings to judge on [default: the last 30 % of each session of --data]
    #[arg(long, value_name = "FILE", num_args = 1..)]
    hold_out: Vec<PathBuf>,
    /// Exit with 1 if the nominal model does not explain the data
    #[arg(long)]
    fail_on_gap: bool,
    #[command(flatten)]
    output: OutputOptions,
}

impl Diagnose {
    /// Reads, diagnoses, replays the nominal and the extended model, reports.
    pub fn run(self) -> Result<Outcome> {
        let model = input::model(&self.model)?;
        let input::Recordings { data: train, hold_out, reference, mut drawn, drawn_before } =
            input::Recordings::read(&self.data, &self.hold_out, &self.reference, &model, &channels())?;
        let notes: Vec<String> =
            [&train, &hold_out, &reference].into_iter().flat_map(|one| input::notes(one)).collect();
        let folder = Folder::reserve(
            self.output.out.as_deref(),
            Request {
                verb: "diagnose",
                name: &model.name,
                files: planned(Some(&model), []),
                inputs: input::files(
                    &model,
                    &[&self.data, &self.hold_out, &self.reference],
                    &[&train, &hold_out, &reference],
                ),
            },
        )?;
        let progress = Progress::start("diagnosing", self.output.quiet);
        let found = if reference.is_empty() {
            Findings::new(&model, train, hold_out, &progress)?
        } else {
            drawn = drawn_before
                .into_iter()
                .map(|one| Drawn { name: named(&one.name, REFERENCE), ..one })
                .chain(drawn)
                .collect();
            Findings::compared(&model, reference, train, hold_out, &progress)?
        };
        drop(progress);
        let mut report = found.report(&model.name, drawn);
        report.document.warnings.extend(notes);
        let outcome = console::finish(&report, &folder, &self.output)?;
        let gap = !matches!(found.diagnosis.verdict, Verdict::NothingFound | Verdict::MistakeSuspected);
        Ok(if self.fail_on_gap && gap { Outcome::Failed } else { outcome })
    }
}

/// Prefix of the sessions of the healthy machine.
const REFERENCE: &str = "reference";

/// The name of a session with a prefix, so that it differs from another session of the same name.
fn named(session: &str, side: &str) -> String {
    format!("{side}: {session}")
}

/// Channels that a diagnosis and its replay read; all others may be dropped after the recording was reduced for
/// display.
pub fn channels() -> Vec<Channel> {
    let mut channels = diagnosis::channels();
    channels.extend(replay::CHANNELS);
    channels
}

/// A diagnosis with the simulations of both models beside the held-out data.
#[derive(Debug)]
pub struct Findings {
    /// The diagnosis, with its replay errors.
    pub diagnosis: Diagnosis,
    /// Why the models could not be replayed beside the data.
    replay_failure: Option<Error>,
}

impl Findings {
    /// Diagnoses and replays.
    ///
    /// # Errors
    /// As [`diagnosis::diagnose`]. A replay that fails is a warning of the report.
    pub fn new(model: &Model, train: Vec<Session>, hold_out: Vec<Session>, progress: &Progress) -> Result<Self> {
        let options = Options::default();
        let show = &mut |doing: &str, share: f64| progress.show(doing, share);
        let diagnosis = diagnosis::diagnose(model, &series(&train), &series(&hold_out), &options, show)?;
        let mut findings = Self { diagnosis, replay_failure: None };
        findings.add_replay(train, hold_out, options.held_out_share, progress);
        Ok(findings)
    }

    /// Compares with recordings of the healthy machine, and replays the healthy and the present machine.
    ///
    /// # Errors
    /// As [`diagnosis::compare`]. A replay that fails is a warning of the report.
    pub fn compared(
        model: &Model,
        reference: Vec<Session>,
        now: Vec<Session>,
        hold_out: Vec<Session>,
        progress: &Progress,
    ) -> Result<Self> {
        let mut before = input::series(reference);
        before.iter_mut().for_each(|session| session.name = named(&session.name, REFERENCE));
        let options = Options::default();
        let show = &mut |doing: &str, share: f64| progress.show(doing, share);
        let diagnosis = diagnosis::compare(model, &before, &series(&now), &series(&hold_out), &options, show)?;
        drop(before);
        let mut findings = Self { diagnosis, replay_failure: None };
        findings.add_replay(now, hold_out, options.held_out_share, progress);
        Ok(findings)
    }

    /// Replays. The diagnosis is kept even if the replay fails.
    fn add_replay(&mut self, train: Vec<Session>, hold_out: Vec<Session>, share: f64, progress: &Progress) {
        self.replay_failure = Self::replay(&mut self.diagnosis, train, hold_out, share, progress).err();
    }

    /// Simulates both models beside the held-out data.
    fn replay(
        diagnosis: &mut Diagnosis,
        train: Vec<Session>,
        hold_out: Vec<Session>,
        share: f64,
        progress: &Progress,
    ) -> Result<()> {
        if diagnosis.verdict == Verdict::MistakeSuspected {
            return Ok(());
        }
        let mut judged = if hold_out.is_empty() {
            train.into_iter().map(|session| tail(session, share)).collect()
        } else {
            drop(train);
            hold_out
        };
        judged.iter_mut().for_each(|session| session.series.keep(&replay::CHANNELS));
        progress.next("replaying");
        let (nominal, extended) = (&diagnosis.baseline_model, &diagnosis.extended_model);
        let (compared, replays) = replay::compare_models(nominal, extended, &judged, &replay::Options::default())?;
        diagnosis.replay = compared.into_iter().map(|one| replay_error(one, nominal)).collect();
        for joint in &mut diagnosis.shares {
            joint.zones = zone_shares(&joint.joint, &diagnosis.series, &replays);
        }
        Ok(())
    }

    /// The report: the reduced recordings with their residuals.
    pub fn report(&self, name: &str, drawn: Vec<Drawn>) -> Report<'_> {
        let json = serde_json::to_value(&self.diagnosis).unwrap_or(Value::Null);
        let model = &self.diagnosis.extended_model;
        let motions = drawn.into_iter().map(|session| {
            let traces = rendering::traces(&self.diagnosis, &session.name);
            Motion { traces, ..Motion::new(&model.robot, session) }
        });
        let mut document = rendering::document(name, &self.diagnosis);
        let failure = self.replay_failure.iter();
        document.warnings.extend(failure.map(|why| format!("the models were not replayed beside the data: {why}")));
        Report {
            document,
            json: envelope(Diagnosis::SCHEMA, name, json),
            motions: motions.collect(),
            model: Some(model.clone()),
            extra: Vec::new(),
        }
    }
}

/// The signals alone, which share their samples with the sessions.
fn series(sessions: &[Session]) -> Vec<TimeSeries> {
    sessions.iter().map(|session| session.series.clone()).collect()
}

/// The last part of a session.
fn tail(session: Session, share: f64) -> Session {
    let time = &session.series.time;
    let (Some(first), Some(last)) = (time.first(), time.last()) else { return session };
    let from = time.partition_point(|time| *time <= last - share * (last - first));
    Session { series: session.series.since(from), ..session }
}

/// Shares of the squared torque error of replays in each zone of a joint.
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
    ReplayError { joint, quantity, unit, split: Split::HeldOut, before, after, gain }
}

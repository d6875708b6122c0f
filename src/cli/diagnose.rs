//! `lostmotion diagnose --model M --data F...`.

use std::path::PathBuf;

use clap::Args;
use serde_json::Value;

use crate::dataset::Session;
use crate::diagnose::{self as diagnosis, Diagnosis, Options, ReplayError, ResidualSeries, Split, Verdict, ZoneShares};
use crate::error::Result;
use crate::replay::{self, Compared, Quantity, Replay};
use crate::report::files::envelope;
use crate::report::recording::Motion;
use crate::report::{Report, diagnosis as rendering};
use crate::robot::Model;
use crate::timeseries::TimeSeries;
use crate::units::JointKind;

use super::console::{OutputOptions, Progress};
use super::folder::Folder;
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
    /// Reads, diagnoses, replays nominal and extended model, reports.
    pub fn run(self) -> Result<Outcome> {
        let model = input::model(&self.model)?;
        let train = input::sessions(&self.data, &model)?;
        let hold_out = input::sessions(&self.hold_out, &model)?;
        let reference = input::sessions(&self.reference, &model)?;
        let folder = Folder::reserve(self.output.out.as_deref(), &model.name)?;
        let progress = Progress::start("diagnosing", self.output.quiet);
        let found = if reference.is_empty() {
            Findings::new(&model, &train, &hold_out, &progress)?
        } else {
            Findings::compared(&model, &reference, &train, &hold_out, &progress)?
        };
        drop(progress);
        let mut report = found.report(&model.name);
        report.document.warnings.extend(input::notes(&train));
        report.document.warnings.extend(input::notes(&hold_out));
        report.document.warnings.extend(input::notes(&reference));
        let outcome = console::finish(&report, &folder, &self.output)?;
        let gap = !matches!(found.diagnosis.verdict, Verdict::NothingFound | Verdict::MistakeSuspected);
        Ok(if self.fail_on_gap && gap { Outcome::Failed } else { outcome })
    }
}

/// A diagnosis with the simulations of both models beside the data held out.
#[derive(Debug)]
pub struct Findings {
    /// The diagnosis, its replay errors filled in.
    pub diagnosis: Diagnosis,
    /// All recordings.
    sessions: Vec<TimeSeries>,
}

impl Findings {
    /// Diagnoses and replays.
    ///
    /// # Errors
    /// As [`diagnosis::diagnose`] and [`replay::replay`].
    pub fn new(model: &Model, train: &[Session], hold_out: &[Session], progress: &Progress) -> Result<Self> {
        let mut findings = Self::without_replay(model, train, hold_out, progress)?;
        let share = Options::default().held_out_share;
        Self::replay(&mut findings.diagnosis, train, hold_out, share, progress)?;
        Ok(findings)
    }

    /// Compares with recordings of the healthy machine, and replays it as it was and as it is.
    ///
    /// # Errors
    /// As [`diagnosis::compare`] and [`replay::replay`].
    pub fn compared(
        model: &Model,
        reference: &[Session],
        now: &[Session],
        hold_out: &[Session],
        progress: &Progress,
    ) -> Result<Self> {
        let series = |sessions: &[Session]| sessions.iter().map(|session| session.series.clone()).collect::<Vec<_>>();
        let (before, after, judged) = (named(series(reference), "reference"), series(now), series(hold_out));
        let options = Options::default();
        let mut diagnosis = diagnosis::compare(model, &before, &after, &judged, &options, &mut |doing, share| {
            progress.show(doing, share);
        })?;
        Self::replay(&mut diagnosis, now, hold_out, options.held_out_share, progress)?;
        Ok(Self { diagnosis, sessions: before.into_iter().chain(after).chain(judged).collect() })
    }

    /// Diagnoses alone.
    ///
    /// # Errors
    /// As [`diagnosis::diagnose`].
    fn without_replay(model: &Model, train: &[Session], hold_out: &[Session], progress: &Progress) -> Result<Self> {
        let series = |sessions: &[Session]| sessions.iter().map(|session| session.series.clone()).collect::<Vec<_>>();
        let options = Options::default();
        let (train_series, hold_out_series) = (series(train), series(hold_out));
        let diagnosis = diagnosis::diagnose(model, &train_series, &hold_out_series, &options, &mut |doing, share| {
            progress.show(doing, share);
        })?;
        let sessions = train_series.into_iter().chain(hold_out_series).collect();
        Ok(Self { diagnosis, sessions })
    }

    /// Both models in simulation beside the data held out.
    fn replay(
        diagnosis: &mut Diagnosis,
        train: &[Session],
        hold_out: &[Session],
        share: f64,
        progress: &Progress,
    ) -> Result<()> {
        if diagnosis.verdict == Verdict::MistakeSuspected {
            return Ok(());
        }
        let judged: Vec<Session> = if hold_out.is_empty() {
            train.iter().map(|session| tail(session, share)).collect()
        } else {
            hold_out.to_vec()
        };
        progress.next("replaying");
        let (nominal, extended) = (&diagnosis.baseline_model, &diagnosis.extended_model);
        let (compared, replays) = replay::compare_models(nominal, extended, &judged, &replay::Options::default())?;
        diagnosis.replay = compared.into_iter().map(|one| replay_error(one, nominal)).collect();
        for joint in &mut diagnosis.shares {
            joint.zones = zone_shares(&joint.joint, &diagnosis.series, &replays);
        }
        Ok(())
    }

    /// The report: first the recordings with their residuals, then the extended model beside the data held out.
    pub fn report(&self, name: &str) -> Report<'_> {
        let json = serde_json::to_value(&self.diagnosis).unwrap_or(Value::Null);
        let model = &self.diagnosis.extended_model;
        let motions = self.sessions.iter().map(|session| {
            let traces = rendering::traces(&self.diagnosis, &session.name);
            Motion { traces, ..Motion::new(&model.robot, session) }
        });
        Report {
            document: rendering::document(name, &self.diagnosis),
            json: envelope(Diagnosis::SCHEMA, name, json),
            motions: motions.collect(),
            model: Some(model.clone()),
            extra: Vec::new(),
        }
    }
}

/// Sessions whose names tell them from others of the same names.
fn named(mut sessions: Vec<TimeSeries>, side: &str) -> Vec<TimeSeries> {
    for session in &mut sessions {
        session.name = format!("{side}: {}", session.name);
    }
    sessions
}

/// The last part of a session.
fn tail(session: &Session, share: f64) -> Session {
    let mut session = session.clone();
    let (first, last) = match (session.series.time.first(), session.series.time.last()) {
        (Some(first), Some(last)) => (*first, *last),
        _ => return session,
    };
    let from = session.series.time.partition_point(|time| *time <= last - share * (last - first));
    session.series.time.drain(..from);
    for joint in &mut session.series.joints {
        joint.channels.values_mut().for_each(|values| {
            values.drain(..from);
        });
    }
    session
}

/// Parts of the squared torque error of replays that lie in each zone of a joint.
fn zone_shares(joint: &str, series: &[ResidualSeries], replays: &[Replay]) -> Option<ZoneShares> {
    let (mut sums, mut times) = ([0.0; 3], [0.0; 3]);
    for replay in replays {
        let error = replay.errors.iter().find(|error| error.joint == joint && error.quantity == Quantity::Torque)?;
        for series in series.iter().filter(|one| one.joint == joint && one.session == replay.recorded.name) {
            let (Some(first), Some(last)) = (series.time.first(), series.time.last()) else { continue };
            for (time, e) in replay.recorded.time.iter().zip(&error.difference) {
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
        Quantity::Position => "position",
        Quantity::Velocity => "velocity",
        Quantity::Torque if slides => "force",
        Quantity::Torque => "torque",
    };
    ReplayError { joint, quantity, unit, split: Split::HeldOut, before, after, gain }
}

//! `lostmotion run SCENARIO` and `lostmotion demo`.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};

use crate::dataset::{self, Session};
use crate::effects;
use crate::error::{Error, Result};
use crate::identify::{self as identification, Options};
use crate::report::diagnosis::traces as residuals;
use crate::report::files::{Content, File, envelope, planned};
use crate::report::recording::Motion;
use crate::report::{Report, contacts};
use crate::robot::Model;
use crate::scenario::{self, Keep, Procedure, Recorded, Scenario};
use crate::timeseries::{Drawn, TimeSeries};

use super::console::{self, OutputOptions, Progress};
use super::diagnose::{self, Findings};
use super::folder::{Folder, Request};
use super::limits::LimitOptions;
use super::{Outcome, catalogue, identify, input};

/// Scenario of the catalogue that `demo` carries out.
const DEMO: &str = "02_name_the_cause";

/// Simulate a scenario and carry out its procedure
#[derive(Debug, Args)]
pub struct Run {
    /// Scenario file, or a name of `lostmotion list scenarios`
    scenario: PathBuf,
    /// Change a value of the scenario, or of its model with a key that begins with `model.`
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    common: Common,
}

/// The main job on built-in files: an arm with something wrong is simulated, identified, diagnosed, and the cause named
#[derive(Debug, Args)]
pub struct Demo {
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Args)]
struct Common {
    /// Seed of the sensors' noise [default: the scenario's]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Write what the sensors recorded as well, one CSV a session
    #[arg(long)]
    csv: bool,
    #[command(flatten)]
    limits: LimitOptions,
    #[command(flatten)]
    output: OutputOptions,
}

impl Run {
    /// Simulates, carries out the procedure, checks what is expected.
    pub fn run(self) -> Result<Outcome> {
        carry_out(&self.scenario, &self.set, &self.common)
    }
}

impl Demo {
    /// The scenario of the catalogue that shows the main job.
    pub fn run(self) -> Result<Outcome> {
        carry_out(Path::new(DEMO), &[], &self.common)
    }
}

fn carry_out(given: &Path, set: &[String], common: &Common) -> Result<Outcome> {
    let source = catalogue::find(given, "scenarios", "scenario.toml")?;
    if let Some(recorded) = Recorded::load(&source, set)? {
        return on_recordings(&source, &recorded, common);
    }
    let mut scenario = Scenario::load(&source, set)?;
    scenario.limits = common.limits.limits();
    let seed = common.seed.unwrap_or(scenario.seed);
    let folder = reserve(&scenario, common)?;
    let cost = scenario.affordable()?;
    if !common.output.quiet {
        eprintln!("{cost}");
    }
    let progress = Progress::start("simulating", common.output.quiet);
    // The truth is drawn, but no procedure gets it.
    let keep = if scenario.procedure == Procedure::None && !common.csv { Keep::Nothing } else { Keep::Measured };
    let mut run = scenario::simulate_keeping(keep, &scenario, seed, &|done, all| progress.set(done / all))?;
    let drawn = std::mem::take(&mut run.drawn);
    let (mut report, mut unmet) = match scenario.procedure {
        Procedure::None => (simulated(&scenario, drawn), Vec::new()),
        Procedure::Identify => {
            identified(&scenario.model, &scenario.model, &scenario, drawn, &run.sessions, &progress)?
        }
        Procedure::Diagnose => diagnosed(&scenario, drawn, &run.sessions, &progress)?,
    };
    drop(progress);
    let met = scenario.contact_expectations.iter().filter_map(|expectation| expectation.check(&run));
    unmet.extend(met.map(|unmet| unmet.to_string()));
    note_contacts(&mut report, &scenario, &run);
    note(&mut report, &scenario, seed, &unmet);
    if common.csv {
        report.extra.extend(run.sessions.iter().map(|session| csv(&scenario, session)));
    }
    let outcome = console::finish(&report, &folder, &common.output)?;
    Ok(judged(outcome, &unmet))
}

/// The outcome of a report, or a failure if an expectation is not met.
fn judged(outcome: Outcome, unmet: &[String]) -> Outcome {
    unmet.iter().for_each(|unmet| eprintln!("expectation failed: {unmet}"));
    if unmet.is_empty() { outcome } else { Outcome::Failed }
}

/// The folder of a simulated scenario.
fn reserve(scenario: &Scenario, common: &Common) -> Result<Folder> {
    let mut inputs = input::files(&scenario.model, &[], &[]);
    inputs.push(scenario.source.clone());
    let model = Some(&scenario.model).filter(|_| scenario.procedure != Procedure::None);
    let recordings = scenario.sessions.iter().filter(|_| common.csv).map(|session| csv_name(&session.name));
    let request = Request { verb: "run", name: &scenario.name, files: planned(model, recordings), inputs };
    Folder::reserve(common.output.out.as_deref(), request)
}

/// Diagnoses recordings, and checks the named effects.
fn on_recordings(source: &Path, scenario: &Recorded, common: &Common) -> Result<Outcome> {
    let model = Model::load(&scenario.robot)?;
    let wanted = diagnose::channels();
    let input::Recordings { data: train, hold_out, drawn, .. } =
        input::Recordings::read(&scenario.data, &scenario.hold_out, &[], &model, &wanted)?;
    let mut inputs = input::files(&model, &[&scenario.data, &scenario.hold_out], &[&train, &hold_out]);
    inputs.push(source.to_owned());
    let request = Request { verb: "run", name: &scenario.name, files: planned(Some(&model), []), inputs };
    let folder = Folder::reserve(common.output.out.as_deref(), request)?;
    let progress = Progress::start("diagnosing", common.output.quiet);
    let findings = Findings::new(&model, train, hold_out, &progress)?;
    drop(progress);
    let unmet: Vec<String> = scenario.check(&findings.diagnosis).iter().map(ToString::to_string).collect();
    let mut report = findings.report(&scenario.name, drawn);
    report.document.title = format!("{}: {}", scenario.name, scenario.question);
    if let Value::Object(content) = &mut report.json {
        content.insert("failed_expectations".into(), unmet.clone().into());
    }
    let outcome = console::finish(&report, &folder, &common.output)?;
    Ok(judged(outcome, &unmet))
}

/// The report of a run without a procedure.
fn simulated(scenario: &Scenario, drawn: Vec<Drawn>) -> Report<'_> {
    let mut document = crate::report::Document { title: scenario.name.clone(), ..crate::report::Document::default() };
    let seconds: f64 = scenario.sessions.iter().map(|session| session.duration).sum();
    document.verdict = format!("{} simulated for {seconds:.1} s.", scenario.model.name);
    let motions = drawn.into_iter().map(|session| Motion::new(&scenario.model.robot, session)).collect();
    let json = envelope("lostmotion/run/1", &scenario.name, json!({}));
    Report { document, json, motions, model: None, extra: Vec::new() }
}

/// Identification of the measured data with a trusted model, beside the injected values.
fn identified<'a>(
    trusted: &Model,
    base: &Model,
    scenario: &'a Scenario,
    drawn: Vec<Drawn>,
    measured: &[TimeSeries],
    progress: &Progress,
) -> Result<(Report<'a>, Vec<String>)> {
    progress.next("identifying");
    let mut found = identification::identify(trusted, measured, &Options::default())?;
    scenario.truth.compare(&mut found);
    let unmet =
        scenario.expectations.iter().filter_map(|expectation| Some(expectation.check(&found)?.to_string())).collect();
    let report = identify::report(&scenario.name, &found, Some(&scenario.truth), &scenario.model, drawn);
    Ok((Report { model: Some(found.apply(base)), ..report }, unmet))
}

/// Diagnosis of the measured data with the nominal machine; then identification of friction and gap, with a model that
/// contains the named cause.
fn diagnosed<'a>(
    scenario: &'a Scenario,
    drawn: Vec<Drawn>,
    measured: &[TimeSeries],
    progress: &Progress,
) -> Result<(Report<'a>, Vec<String>)> {
    let recordings: Vec<_> = measured.iter().map(|series| recording(series, &scenario.source)).collect();
    let findings = Findings::new(&scenario.model, recordings, Vec::new(), progress)?;
    let extended = &findings.diagnosis.extended_model;
    let diagnosis = findings.report(&scenario.name, Vec::new());
    let identification = corrected(extended)
        .and_then(|trusted| identified(&trusted, extended, scenario, drawn.clone(), measured, progress));
    let (mut report, mut unmet) = match identification {
        // A finished diagnosis is written even if the identification fails.
        Err(why) => {
            let (json, mut document, model) = (diagnosis.json, diagnosis.document, Some(extended.clone()));
            let mut unmet = Vec::new();
            // Without steady motion, friction laws cannot be identified; that is not worth a warning if no expectation
            // needs them.
            if !(matches!(why, Error::TooLittleData { .. }) && scenario.expectations.is_empty()) {
                document.warnings.push(format!("friction and gap were not identified: {why}"));
            }
            if !scenario.expectations.is_empty() {
                unmet.push(format!("friction and gap were expected and not identified: {why}"));
            }
            (Report { json, document, model, ..simulated(scenario, drawn) }, unmet)
        }
        Ok((mut report, unmet)) => {
            let joints = std::mem::take(&mut report.json["joints"]);
            report.json = diagnosis.json;
            report.json["identification"] = json!({ "joints": joints });
            let friction = std::mem::replace(&mut report.document, diagnosis.document);
            report.document.verdict += &format!("\n{}", friction.verdict);
            let details = report.document.sections.iter().position(|section| section.detail);
            let at = details.unwrap_or(report.document.sections.len());
            report.document.sections.splice(at..at, friction.sections);
            (report, unmet)
        }
    };
    let named = scenario.diagnosis_expectation.check(&findings.diagnosis);
    unmet.splice(0..0, named.iter().map(ToString::to_string));
    for motion in &mut report.motions {
        motion.traces = residuals(&findings.diagnosis, &motion.session.name);
    }
    Ok((report, unmet))
}

/// The model with its effects applied to its parameters, as far as they change parameters.
fn corrected(model: &Model) -> Result<Model> {
    let mut corrected = Model { effects: Vec::new(), ..model.clone() };
    for entry in &model.effects {
        let joint = entry.joint.as_deref().and_then(|name| model.robot.joint_index(name));
        if let Some(effect) = effects::find(&entry.effect) {
            effect.install(&mut corrected, joint, &entry.parameters)?;
        }
    }
    Ok(corrected)
}

/// A simulated recording, as if it had been read from a file.
fn recording(series: &TimeSeries, source: &Path) -> Session {
    let controllers = vec![None; series.joints.len()];
    Session { series: series.clone(), notes: Vec::new(), source: source.to_owned(), controllers }
}

/// Writes the contacts into the report and its recording.
fn note_contacts<'a>(report: &mut Report<'a>, scenario: &'a Scenario, run: &scenario::Run) {
    for ((motion, session), touched) in report.motions.iter_mut().zip(&run.sessions).zip(&run.contacts) {
        motion.obstacles = &scenario.options.obstacles;
        contacts::trace(motion, &session.time, touched);
    }
    if let Some(section) = contacts::section(run) {
        report.document.sections.insert(0, section);
        report.json["contacts"] = contacts::json(run).into();
    }
}

/// Writes question, seed and failed expectations into the report.
fn note(report: &mut Report<'_>, scenario: &Scenario, seed: u64, unmet: &[String]) {
    if let Value::Object(content) = &mut report.json {
        content.insert("seed".into(), seed.into());
        content.insert("failed_expectations".into(), unmet.into());
    }
    if !scenario.question.is_empty() {
        report.document.title = format!("{}: {}", scenario.name, scenario.question);
    }
}

/// Name of the file of a session.
fn csv_name(session: &str) -> String {
    format!("{session}.csv")
}

/// Name and content of a session in the format of a real machine's recording.
fn csv<'a>(scenario: &Scenario, session: &'a TimeSeries) -> File<'a> {
    let kinds: Vec<_> = scenario.model.joints.iter().map(|joint| joint.kind).collect();
    let rows = Content::Stream(Box::new(move |out| dataset::write_csv_rows(out, session, &kinds)));
    (csv_name(&session.name), rows)
}

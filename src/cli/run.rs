//! `lostmotion run SCENARIO` and `lostmotion demo`.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::error::Result;
use crate::report::files::planned;
use crate::report::run as rendering;
use crate::scenario::{self, Recorded, Scenario, channels};

use super::console::{self, OutputOptions, Progress};
use super::folder::{Folder, Request};
use super::limits::LimitOptions;
use super::{Outcome, catalogue, input};

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
    /// Also write what the sensors recorded, one CSV file per session
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
    console::remark(&scenario.model.remarks);
    scenario.limits = common.limits.limits();
    let seed = common.seed.unwrap_or(scenario.seed);
    let folder = reserve(&scenario, common)?;
    let cost = scenario.affordable()?;
    if !common.output.quiet {
        eprintln!("{cost}");
    }
    let progress = Progress::start("simulating", common.output.quiet);
    let keep = scenario.procedure.keep(common.csv);
    let mut run = scenario::simulate_keeping(keep, &scenario, seed, &|done, all| progress.set(done / all))?;
    let drawn = std::mem::take(&mut run.drawn);
    let conclusion = scenario.carry_out(&run, &mut |doing, share| progress.show(doing, share))?;
    drop(progress);
    let mut report = rendering::report(&scenario, seed, &run, &conclusion, drawn);
    if common.csv {
        report.extra.extend(run.sessions.iter().map(|session| rendering::csv(&scenario, session)));
    }
    let outcome = console::finish(&report, &folder, &common.output)?;
    Ok(judged(outcome, &conclusion.unmet))
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
    let request =
        Request { verb: "run", name: &scenario.name, files: rendering::planned(scenario, common.csv), inputs };
    Folder::reserve(common.output.out.as_deref(), request)
}

/// Diagnoses recordings, and checks the named effects.
fn on_recordings(source: &Path, scenario: &Recorded, common: &Common) -> Result<Outcome> {
    let model = scenario.model()?;
    console::remark(&model.remarks);
    let Recorded { data, hold_out, reference, .. } = scenario;
    let recordings = input::Recordings::read(data, hold_out, reference, &model, &channels())?;
    let mut inputs = recordings.files(&[data, hold_out, reference]);
    inputs.push(source.to_owned());
    let files = planned(Some(&recordings.model), []);
    let folder =
        Folder::reserve(common.output.out.as_deref(), Request { verb: "run", name: &scenario.name, files, inputs })?;
    let notes = recordings.notes();
    let (findings, drawn) = recordings.findings(common.output.quiet)?;
    let unmet: Vec<String> = scenario.check(&findings.diagnosis).iter().map(ToString::to_string).collect();
    let mut report = rendering::of_recordings(scenario, &findings, &unmet, drawn);
    report.document.warnings.extend(notes);
    let outcome = console::finish(&report, &folder, &common.output)?;
    Ok(judged(outcome, &unmet))
}

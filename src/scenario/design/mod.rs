//! Finds by simulation the experiment that separates two causes, or measures one best.
//!
//! Each experiment within the budget is simulated with one cause in the machine and then with the other, of a strength
//! that changes the torque by a tenth, and the recording is diagnosed. If the result decides, further machines with
//! other strengths and noise are simulated. The confidence of an experiment is the smaller of the two causes' mean
//! probabilities that the right cause is named and the other one is ruled out. Experiments that the effects declare as
//! best are tried first, shorter before longer ones, and the first one that decides is taken. For a single cause it is
//! the experiment with the smallest standard error of the cause's largest parameter.

mod experiments;

use std::path::Path;

use serde::Serialize;

use super::{Limits, Scenario, simulate};
use crate::diagnose::{self, Diagnosis, Options};
use crate::effects::{Catalogue, Experiment};
use crate::error::{Error, Place, Result};
use crate::robot::{EffectEntry, Model};
use crate::timeseries::TimeSeries;
use crate::toml_input::nearest;
use experiments::{Plan, plans, scenario_text};

/// [1] An experiment decides if its probability of naming the right cause is at least this.
pub const DECIDES: f64 = 0.9;
/// [1] RMS shares of the torque that a cause adds in the simulated machines; the further ones are used only if the
/// first decides.
const STRENGTHS: [f64; 3] = [0.1, 0.07, 0.14];
/// Seed of the noise of a prediction; the machine that carries out the experiment has other noise.
const SEED: u64 = 4711;

/// The question to be answered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question(Vec<String>);

impl Question {
    /// Reads `A` or `A|B`: names of effects that a diagnosis can recognise.
    ///
    /// # Errors
    /// A name that the catalogue lacks, an effect that no diagnosis recognises, or more than two names.
    pub fn parse(text: &str, catalogue: &Catalogue) -> Result<Self> {
        let refused = |expected: String| Error::input("command line".as_ref(), Place::File, "question", text, expected);
        let names: Vec<String> = text.split('|').map(|name| name.trim().to_owned()).collect();
        if names.len() > 2 || names.iter().any(String::is_empty) || (names.len() == 2 && names[0] == names[1]) {
            return Err(refused(
                "one effect, or two different ones with a | between them; or friction, backlash or friction,backlash"
                    .to_owned(),
            ));
        }
        for name in &names {
            match catalogue.find(name) {
                None => {
                    let near = nearest(name, catalogue.iter().map(|effect| effect.name()));
                    let hint = near.map_or_else(String::new, |near| format!(", such as {near}"));
                    return Err(refused(format!("names of `lostmotion list effects`, or friction, backlash{hint}")));
                }
                Some(effect) if !effect.can_be_told() => {
                    return Err(refused(format!(
                        "effects that a diagnosis can recognise; {name} can only be simulated"
                    )));
                }
                Some(_) => {}
            }
        }
        Ok(Self(names))
    }

    /// The causes, one or two.
    pub fn causes(&self) -> &[String] {
        &self.0
    }
}

/// Predicted result of an experiment if a cause is present.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Forecast {
    /// The cause in the simulated machines.
    pub cause: String,
    /// Its strength in the first machine.
    pub assumed: EffectEntry,
    /// Number of machines simulated with it.
    pub machines: usize,
    /// Probability that it is named and the other cause is not, 0 to 1; mean over the machines.
    pub probability: f64,
    /// [1] Relative standard error of its largest parameter, if it is named.
    pub relative_error: Option<f64>,
    /// Other effects that are named.
    pub also_named: Vec<String>,
}

/// An experiment that was simulated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TriedExperiment {
    /// The kinds of experiment.
    pub experiment: Vec<Experiment>,
    /// [s] Total length of its sessions.
    pub duration: f64,
    /// One per cause.
    pub predictions: Vec<Forecast>,
    /// The scenario file; the model is `model.toml` beside it.
    #[serde(skip)]
    pub scenario: String,
}

impl TriedExperiment {
    /// Confidence of its decision, 0 to 1.
    pub fn certainty(&self) -> f64 {
        self.predictions.iter().map(|one| one.probability).fold(1.0, f64::min)
    }

    /// Quality, larger is better: for two causes the confidence of the decision, for one the precision of the
    /// measurement.
    fn merit(&self) -> f64 {
        match self.predictions.as_slice() {
            [one] => -one.relative_error.unwrap_or(f64::INFINITY),
            _ => self.certainty(),
        }
    }
}

/// A designed experiment.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Design {
    /// Whether the best one decides with [`DECIDES`]; for a single cause, whether it names it.
    pub decides: bool,
    /// The experiment that is recommended.
    pub best: TriedExperiment,
    /// All that were simulated, in this order.
    pub tried: Vec<TriedExperiment>,
    /// [s] The shortest experiment that exceeds the budget; `None` if none does.
    pub beyond_budget: Option<f64>,
    /// How to separate the causes, from the catalogue, one text per cause.
    pub told_apart_by: Vec<&'static str>,
}

/// Budget of an experiment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// [s] on the machine.
    pub seconds: f64,
    /// Limits of its simulation.
    pub limits: Limits,
}

impl From<f64> for Budget {
    /// This many seconds, and the default limits of simulations.
    fn from(seconds: f64) -> Self {
        Self { seconds, limits: Limits::default() }
    }
}

/// Designs the experiment for a machine within a budget of seconds and of simulation cost; `progress` gets the present
/// step and the share that is done.
///
/// # Errors
/// The model lacks friction; no experiment fits the budget (the error gives the length of the shortest) or the
/// machine's limits; or a simulation fails.
pub fn design(
    model: &Model,
    question: &Question,
    budget: impl Into<Budget>,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Design> {
    let Budget { seconds: budget, limits } = budget.into();
    let refused = |key: &str, expected: &str| Error::input(&model.source, Place::File, key, "", expected);
    if let Some(joint) = model.joints.iter().find(|joint| joint.friction.is_none()) {
        let key = format!("joints.{}.friction", joint.name);
        return Err(refused(
            &key,
            "friction to simulate with: take the model.toml that identify or diagnose has written",
        ));
    }
    let catalogue = Catalogue::default();
    let Affordable { experiments, beyond_budget } = affordable(model, question, &catalogue, limits, budget)?;
    let (tried, too_little) = try_in_order(question, experiments, progress)?;
    let best = tried.iter().max_by(|a, b| a.merit().total_cmp(&b.merit()).then(b.duration.total_cmp(&a.duration)));
    let none = || {
        too_little.unwrap_or_else(|| refused("joints", "limits that leave room for an experiment without a collision"))
    };
    let best = best.cloned().ok_or_else(none)?;
    let decides = match question.causes().len() {
        1 => best.certainty() > 0.5,
        _ => best.certainty() >= DECIDES,
    };
    let about = question.causes().iter().filter_map(|cause| catalogue.find(cause));
    Ok(Design {
        decides,
        best,
        tried,
        beyond_budget,
        told_apart_by: about.map(|effect| effect.about().separate_by).collect(),
    })
}

/// An experiment that can be simulated.
struct PlannedRun {
    /// Sum of its ranks, see [`rank`].
    rank: usize,
    plan: Plan,
    text: String,
    scenario: Scenario,
}

/// Experiments within the budget, the most suitable first, and of these the shortest.
struct Affordable {
    experiments: Vec<PlannedRun>,
    /// [s] The shortest that is beyond the budget.
    beyond_budget: Option<f64>,
}

/// Experiments that this machine can carry out within the budget.
fn affordable(
    model: &Model,
    question: &Question,
    catalogue: &Catalogue,
    limits: Limits,
    budget: f64,
) -> Result<Affordable> {
    let mut experiments: Vec<PlannedRun> = Vec::new();
    let mut beyond_budget: Option<f64> = None;
    let mut too_costly = None;
    for plan in plans() {
        let Some(rank) = rank(&plan, question, catalogue) else { continue };
        let text = text_of(model, question, &plan);
        // A plan that this machine cannot carry out is skipped.
        let Ok(scenario) = Scenario::of_model(&text, Path::new("scenario.toml"), model) else { continue };
        let scenario = Scenario { limits, ..scenario };
        if let Err(error) = scenario.affordable() {
            too_costly = Some(error);
        } else if scenario.check_motion().is_err() {
            continue;
        } else if duration(&scenario) <= budget {
            experiments.push(PlannedRun { rank, plan, text, scenario });
        } else {
            beyond_budget = Some(beyond_budget.map_or(duration(&scenario), |least| least.min(duration(&scenario))));
        }
    }
    match (experiments.is_empty(), beyond_budget, too_costly) {
        (true, Some(least), _) => {
            let expected = format!("at least {:.0} s: no experiment for this question is shorter", least.ceil());
            Err(Error::input("command line".as_ref(), Place::File, "budget", format!("{budget} s"), expected))
        }
        (true, None, Some(error)) => Err(error),
        _ => {
            let length = |one: &PlannedRun| duration(&one.scenario);
            experiments.sort_by(|a, b| a.rank.cmp(&b.rank).then(length(a).total_cmp(&length(b))));
            Ok(Affordable { experiments, beyond_budget })
        }
    }
}

/// Simulates experiments until one decides; also returns the last error of those that are too short for this machine.
fn try_in_order(
    question: &Question,
    experiments: Vec<PlannedRun>,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<(Vec<TriedExperiment>, Option<Error>)> {
    let mut tried: Vec<TriedExperiment> = Vec::new();
    let mut too_little = None;
    let count = experiments.len() as f64;
    for (index, PlannedRun { plan, text, scenario, .. }) in experiments.into_iter().enumerate() {
        progress("simulating experiments", index as f64 / count);
        let trial = match attempt(question, &plan, text, &scenario) {
            // Too short for this machine; another plan may be long enough.
            Err(error @ Error::TooLittleData { .. }) => {
                too_little = Some(error);
                continue;
            }
            result => result?,
        };
        let enough = question.causes().len() > 1 && trial.certainty() >= DECIDES;
        tried.push(trial);
        if enough {
            break;
        }
    }
    Ok((tried, too_little))
}

/// Sum of the ranks of the plan's best kind in the causes' lists of suitable experiments; `None` if the plan has no
/// suitable kind for one of them.
fn rank(plan: &Plan, question: &Question, catalogue: &Catalogue) -> Option<usize> {
    let of_cause = |cause: &String| {
        let wanted = catalogue.find(cause).map_or(&[][..], |effect| effect.shown_by());
        if wanted.is_empty() { Some(0) } else { wanted.iter().position(|kind| plan.holds(*kind)) }
    };
    question.causes().iter().map(of_cause).sum()
}

/// The scenario file; its place is beside the model file.
fn text_of(model: &Model, question: &Question, plan: &Plan) -> String {
    scenario_text(model, plan, "model.toml", "design", &question.causes().join(" or "))
}

fn duration(scenario: &Scenario) -> f64 {
    scenario.sessions.iter().map(|session| session.duration).sum()
}

fn attempt(question: &Question, plan: &Plan, text: String, scenario: &Scenario) -> Result<TriedExperiment> {
    let options = Options { backlash: false, ..Options::default() };
    let told = &scenario.model;
    let plain = simulate(&with(scenario, None), SEED, &|_, _| {})?.measured();
    let mut seed = SEED;
    let mut predict = |cause: &String, strength: f64| -> Result<Forecast> {
        let Some(assumed) = diagnose::typical(told, &plain, cause, strength, &options)? else {
            let expected = "effects that can move the torque of this machine in an experiment";
            return Err(Error::input("command line".as_ref(), Place::File, "question", cause, expected));
        };
        seed += 1;
        let recorded: Vec<TimeSeries> = simulate(&with(scenario, Some(&assumed)), seed, &|_, _| {})?.measured();
        let found = diagnose::diagnose(told, &recorded, &[], &options, &mut |_, _| {})?;
        Ok(prediction(&found, cause, question, assumed))
    };
    let [first, further @ ..] = STRENGTHS;
    let predictions = question.causes().iter().map(|cause| predict(cause, first)).collect::<Result<_>>()?;
    let mut trial =
        TriedExperiment { experiment: plan.parts.clone(), duration: duration(scenario), predictions, scenario: text };
    for strength in further {
        if question.causes().len() < 2 || trial.certainty() < DECIDES {
            break;
        }
        for one in &mut trial.predictions {
            let again = predict(&one.cause, strength)?;
            let machines = one.machines as f64;
            one.probability = (one.probability * machines + again.probability) / (machines + 1.0);
            one.machines += 1;
        }
    }
    Ok(trial)
}

/// The scenario with this effect, and no other, in its machine.
fn with(scenario: &Scenario, effect: Option<&EffectEntry>) -> Scenario {
    let mut scenario = scenario.clone();
    scenario.truth.alter(|machine| machine.effects = effect.into_iter().cloned().collect());
    scenario
}

fn prediction(found: &Diagnosis, cause: &str, question: &Question, assumed: EffectEntry) -> Forecast {
    let other = |name: &String| name != cause && question.causes().contains(name);
    let named = found.effects.iter().find(|one| one.effect == cause);
    let wrong = found.effects.iter().any(|one| other(&one.effect));
    let probability = match named {
        Some(one) if !wrong && one.confusable_with.iter().any(other) => one.probability.min(0.5),
        Some(one) if !wrong => one.probability,
        _ => 0.0,
    };
    let first = assumed.parameters.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map(|(name, _)| name);
    let measured = named.and_then(|one| one.parameters.get(first?));
    let relative_error = measured.map(|one| (one.std_error / one.value).abs());
    let also_named = found.effects.iter().map(|one| one.effect.clone()).filter(|name| name != cause).collect();
    Forecast { cause: cause.to_owned(), assumed, machines: 1, probability, relative_error, also_named }
}

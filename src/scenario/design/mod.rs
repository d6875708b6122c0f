//! The experiment that separates causes, or measures one best, found by simulation.
//!
//! Each experiment within the budget is simulated with one cause in the machine and then with the other, of a strength that moves a
//! tenth of the torque, and diagnosed as a recording would be; how surely it decides is the smaller of the probabilities with which
//! the right cause is named. The shortest that decides is taken. Of one cause: the one that gives its first parameter the smallest standard error.

mod experiments;

use std::path::Path;

use serde::Serialize;

use super::{Scenario, simulate};
use crate::diagnose::{self, Diagnosis, Options};
use crate::effects::{Catalogue, Experiment};
use crate::error::{Error, Place, Result};
use crate::robot::{EffectEntry, Model};
use crate::timeseries::TimeSeries;
use crate::toml_input::nearest;
use experiments::{Plan, plans, scenario_text};

/// [1] Probability of naming the right cause from which an experiment counts as one that decides.
pub const DECIDES: f64 = 0.9;
/// [1] Share of the torque that a cause moves in RMS where it is assumed to be there.
const STRENGTH: f64 = 0.1;
/// Seed of the noise of a prediction; a machine that carries the experiment out has noise of its own.
const SEED: u64 = 4711;

/// What is to be found out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question(Vec<String>);

impl Question {
    /// Reads `A` or `A|B`: names of effects that a diagnosis can tell.
    ///
    /// # Errors
    /// A name that the catalogue lacks, an effect that no diagnosis tells, or more than two of them.
    pub fn parse(text: &str, catalogue: &Catalogue) -> Result<Self> {
        let refused = |expected: String| Error::input("command line".as_ref(), Place::File, "question", text, expected);
        let names: Vec<String> = text.split('|').map(|name| name.trim().to_owned()).collect();
        if names.len() > 2 || names.iter().any(String::is_empty) || (names.len() == 2 && names[0] == names[1]) {
            return Err(refused("one effect, or two different ones with a | between them".to_owned()));
        }
        for name in &names {
            match catalogue.find(name) {
                None => {
                    let near = nearest(name, catalogue.iter().map(|effect| effect.name()));
                    let hint = near.map_or_else(String::new, |near| format!(", such as {near}"));
                    return Err(refused(format!("names of `lostmotion list effects`{hint}")));
                }
                Some(effect) if effect.diagnosable().is_none() => {
                    return Err(refused(format!("effects that a diagnosis can tell; {name} can only be simulated")));
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

/// What an experiment would say if a cause were there.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Prediction {
    /// The cause that was put into the machine.
    pub cause: String,
    /// Its strength there.
    pub assumed: EffectEntry,
    /// Probability that it is named, and no other of the question, 0 to 1.
    pub probability: f64,
    /// [1] Standard error of its first parameter relative to it, where it is named.
    pub relative_error: Option<f64>,
    /// What else is named.
    pub also_named: Vec<String>,
}

/// An experiment that was simulated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trial {
    /// What is done.
    pub experiment: Vec<Experiment>,
    /// [s] its sessions together.
    pub duration: f64,
    /// One a cause.
    pub predictions: Vec<Prediction>,
    /// The scenario file; the model is `model.toml` beside it.
    #[serde(skip)]
    pub scenario: String,
}

impl Trial {
    /// How surely it decides, 0 to 1.
    pub fn certainty(&self) -> f64 {
        self.predictions.iter().map(|one| one.probability).fold(1.0, f64::min)
    }

    /// Larger is better: for two causes how surely it decides, for one how finely it measures.
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
    /// Whether the best decides with [`DECIDES`]; of one cause, whether it names it.
    pub decides: bool,
    /// The experiment that is recommended.
    pub best: Trial,
    /// All that were simulated, in that order.
    pub tried: Vec<Trial>,
}

/// Designs the experiment for a machine, `budget` [s] long at most; `progress` hears what is simulated and which share is done.
///
/// # Errors
/// The model lacks friction, no experiment fits the budget or the machine's limits, or a simulation fails.
pub fn design(model: &Model, question: &Question, budget: f64, progress: &mut dyn FnMut(&str, f64)) -> Result<Design> {
    let refused = |key: &str, expected: &str| Error::input(&model.source, Place::File, key, "", expected);
    if let Some(joint) = model.joints.iter().find(|joint| joint.friction.is_none()) {
        let key = format!("joints.{}.friction", joint.name);
        return Err(refused(
            &key,
            "friction to simulate with: take the model.toml that identify or diagnose has written",
        ));
    }
    let catalogue = Catalogue::default();
    let suits = |plan: &Plan| {
        question.causes().iter().all(|cause| {
            let wanted = catalogue.find(cause).map_or(&[][..], |effect| effect.shown_by());
            wanted.is_empty() || wanted.iter().any(|kind| plan.holds(*kind))
        })
    };
    let mut scenarios: Vec<(Plan, String, Scenario)> = Vec::new();
    for plan in plans().into_iter().filter(suits) {
        let text = text_of(model, question, &plan);
        let scenario = Scenario::of_model(&text, Path::new("scenario.toml"), model)?;
        if duration(&scenario) <= budget && scenario.check_motion().is_ok() {
            scenarios.push((plan, text, scenario));
        }
    }
    scenarios.sort_by(|a, b| duration(&a.2).total_cmp(&duration(&b.2)));
    let mut tried: Vec<Trial> = Vec::new();
    let mut too_little = None;
    let count = scenarios.len() as f64;
    for (index, (plan, text, scenario)) in scenarios.into_iter().enumerate() {
        progress("simulating experiments", index as f64 / count);
        let trial = match attempt(question, &plan, text, &scenario) {
            // Too short for this machine: another may not be.
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
    let best = tried.iter().max_by(|a, b| a.merit().total_cmp(&b.merit()).then(b.duration.total_cmp(&a.duration)));
    let none =
        || too_little.unwrap_or_else(|| refused("budget", "long enough for an experiment within the joints' limits"));
    let best = best.cloned().ok_or_else(none)?;
    let decides = match question.causes().len() {
        1 => best.certainty() > 0.5,
        _ => best.certainty() >= DECIDES,
    };
    Ok(Design { decides, best, tried })
}

/// The scenario file, to lie beside the model file.
fn text_of(model: &Model, question: &Question, plan: &Plan) -> String {
    scenario_text(model, plan, "model.toml", "design", &question.causes().join(" or "))
}

fn duration(scenario: &Scenario) -> f64 {
    scenario.sessions.iter().map(|session| session.duration).sum()
}

/// The machine as a diagnosis is told of it: without effects, its friction and gaps to be found.
fn nominal(model: &Model) -> Model {
    let mut nominal = Model { effects: Vec::new(), ..model.clone() };
    for joint in &mut nominal.joints {
        joint.friction = None;
        joint.backlash = None;
    }
    nominal
}

fn attempt(question: &Question, plan: &Plan, text: String, scenario: &Scenario) -> Result<Trial> {
    let options = Options { backlash: false, ..Options::default() };
    let told = nominal(&scenario.model);
    let plain = simulate(&with(scenario, None), SEED, &|_, _| {})?.measured();
    let mut predictions = Vec::new();
    for (index, cause) in question.causes().iter().enumerate() {
        let Some(assumed) = diagnose::typical(&told, &plain, cause, STRENGTH, &options)? else {
            let expected = "effects that can move the torque of this machine in an experiment";
            return Err(Error::input("command line".as_ref(), Place::File, "question", cause, expected));
        };
        let seed = SEED + 1 + index as u64;
        let recorded: Vec<TimeSeries> = simulate(&with(scenario, Some(&assumed)), seed, &|_, _| {})?.measured();
        let found = diagnose::diagnose(&told, &recorded, &[], &options, &mut |_, _| {})?;
        predictions.push(prediction(&found, cause, question, assumed));
    }
    Ok(Trial { experiment: plan.parts.clone(), duration: duration(scenario), predictions, scenario: text })
}

/// The scenario with one effect in its machine and no other.
fn with(scenario: &Scenario, effect: Option<&EffectEntry>) -> Scenario {
    let mut scenario = scenario.clone();
    scenario.model.effects = effect.into_iter().cloned().collect();
    scenario
}

fn prediction(found: &Diagnosis, cause: &str, question: &Question, assumed: EffectEntry) -> Prediction {
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
    Prediction { cause: cause.to_owned(), assumed, probability, relative_error, also_named }
}

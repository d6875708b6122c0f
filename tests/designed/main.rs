//! Designed experiments, carried out on the simulated machine with either cause truly inside: the ambiguity is gone.
//!
//! The prediction of the design and the machine that carries it out share the program's plant, but neither noise nor strength.

#[path = "../hidden_effects/machine.rs"]
#[allow(dead_code, reason = "only the machine is drawn here, not what is hidden in it")]
mod machine;

use std::path::Path;

use lostmotion::diagnose::{Diagnosis, Options, diagnose};
use lostmotion::effects::Catalogue;
use lostmotion::robot::{EffectEntry, Model};
use lostmotion::scenario::{Design, Question, Scenario, design, simulate};
use machine::Machine;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// A machine of a seed in a folder of its own, as a model file with friction and gaps.
fn machine(folder: &Path, seed: u64) -> Model {
    let drawn = Machine::draw(&mut ChaCha8Rng::seed_from_u64(seed));
    std::fs::write(folder.join("robot.urdf"), drawn.urdf()).expect("the robot");
    std::fs::write(folder.join("model.toml"), drawn.truth(&[])).expect("the model");
    Model::load(&folder.join("model.toml")).expect("a good model")
}

/// Carries the experiment out on a machine with an effect in it and diagnoses the recording.
fn carried_out(model: &Model, found: &Design, effect: &EffectEntry, strength: f64, seed: u64) -> Diagnosis {
    let mut scenario =
        Scenario::of_model(&found.best.scenario, Path::new("scenario.toml"), model).expect("a good scenario");
    let mut nominal = scenario.model.clone();
    for joint in &mut nominal.joints {
        joint.friction = None;
        joint.backlash = None;
    }
    let mut effect = effect.clone();
    // The first parameter of these effects is their size; places and angles stay.
    let about = Catalogue::default().find(&effect.effect).expect("an effect").about();
    *effect.parameters.get_mut(about.parameters[0].name).expect("its size") *= strength;
    scenario.model.effects.push(effect);
    let recorded = simulate(&scenario, seed, &|_, _| {}).expect("a run").measured();
    let options = Options { backlash: false, ..Options::default() };
    diagnose(&nominal, &recorded, &[], &options, &mut |_, _| {}).expect("a diagnosis")
}

fn designed(question: &str, seed: u64) -> (Model, Design) {
    let folder = tempfile::tempdir().expect("a folder");
    let model = machine(folder.path(), seed);
    let asked = Question::parse(question, &Catalogue::default()).expect("a question");
    let found = design(&model, &asked, 150.0, &mut |_, _| {}).expect("a design");
    for trial in &found.tried {
        let of = |one: &lostmotion::scenario::Prediction| {
            format!("{} {:.2} (also {:?})", one.cause, one.probability, one.also_named)
        };
        let predicted: Vec<String> = trial.predictions.iter().map(of).collect();
        println!("{question}: {:?} {:.0} s: {}", trial.experiment, trial.duration, predicted.join(", "));
    }
    (model, found)
}

/// The right cause is named and the other is not, whichever of both is inside.
fn separates(question: &str, seed: u64) {
    let (model, found) = designed(question, seed);
    assert!(found.decides, "{question}: {:?}", found.best.predictions);
    for (index, prediction) in found.best.predictions.iter().enumerate() {
        let said = carried_out(&model, &found, &prediction.assumed, 0.8, seed + 1 + index as u64);
        let named: Vec<&str> = said.effects.iter().map(|one| one.effect.as_str()).collect();
        assert!(named.contains(&prediction.cause.as_str()), "{} inside, {named:?} named", prediction.cause);
        let other = question.split('|').find(|name| *name != prediction.cause).expect("two causes");
        assert!(!named.contains(&other), "{} inside, {named:?} named", prediction.cause);
        let doubt = said.effects.iter().any(|one| one.confusable_with.iter().any(|name| name == other));
        assert!(!doubt, "{} inside, still in doubt", prediction.cause);
    }
}

#[test]
fn recover_which_of_cable_and_tilt_it_is() {
    separates("cable_spring|base_tilt", 910_100);
}

#[test]
fn property_a_question_that_makes_no_sense_is_refused_by_name() {
    for (question, word) in [
        ("payload|payload", "two different"),
        ("payload|", "two different"),
        ("payload|base_tilt|cogging", "two different"),
        ("payloud", "payload"),
    ] {
        let error = Question::parse(question, &Catalogue::default()).expect_err(question).to_string();
        assert!(error.contains(word), "{question}: {error}");
    }
}

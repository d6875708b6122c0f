//! Designed experiments, carried out on the simulated machine with either cause truly inside: an ambiguity of ordinary data is gone.
//!
//! The prediction of the design and the machine that carries it out share the program's plant, but neither noise nor strength, friction
//! or gaps.

use std::path::Path;

use crate::machine::Machine;
use lostmotion::diagnose::{Diagnosis, Options, diagnose};
use lostmotion::effects::Catalogue;
use lostmotion::gearhead::FrictionLaw;
use lostmotion::robot::{EffectEntry, Load, Model};
use lostmotion::scenario::{Design, Forecast, Question, Scenario, design, simulate};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// A machine of a seed in a folder of its own, as a model file with friction and gaps.
fn machine(folder: &Path, seed: u64) -> Model {
    let drawn = Machine::draw(&mut ChaCha8Rng::seed_from_u64(seed));
    std::fs::write(folder.join("robot.urdf"), drawn.urdf()).expect("the robot");
    std::fs::write(folder.join("model.toml"), drawn.truth(&[])).expect("the model");
    Model::load(&folder.join("model.toml")).expect("a good model")
}

/// What the machine that carries an experiment out has of the design's friction and gaps: a model is never quite the machine.
const FRICTION: f64 = 1.15;
const GAP: f64 = 0.85;
/// What it has of the strength that the design assumed.
const STRENGTH: f64 = 0.8;

/// A scenario's recordings of a machine with an effect in it, diagnosed.
fn carried_out(scenario: &Scenario, effect: Option<&EffectEntry>, seed: u64) -> Diagnosis {
    let mut machine = scenario.clone();
    machine.truth.alter(|machine| {
        for joint in &mut machine.joints {
            joint.backlash = joint.backlash.map(|gap| GAP * gap);
            if let Some(FrictionLaw::Exponential(law)) = joint.friction.as_mut().map(|friction| &mut friction.law) {
                law.iter_mut().for_each(|side| {
                    side.coulomb *= FRICTION;
                    side.breakaway *= FRICTION;
                    side.viscous *= FRICTION;
                });
            }
        }
    });
    if let Some(mut effect) = effect.cloned() {
        // The first parameter of these effects is their size; places and angles stay.
        let about = Catalogue::default().find(&effect.effect).expect("an effect").about();
        *effect.parameters.get_mut(about.parameters[0].name).expect("its size") *= STRENGTH;
        machine.truth.alter(|machine| machine.effects.push(effect));
    }
    let recorded = simulate(&machine, seed, &|_, _| {}).expect("a run").measured();
    let options = Options { backlash: false, ..Options::default() };
    diagnose(&scenario.model, &recorded, &[], &options, &mut |_, _| {}).expect("a diagnosis")
}

fn scenario(text: &str, model: &Model) -> Scenario {
    Scenario::of_model(text, Path::new("scenario.toml"), model).expect("a good scenario")
}

fn designed(question: &str, seed: u64) -> (Model, Design) {
    let folder = tempfile::tempdir().expect("a folder");
    let model = machine(folder.path(), seed);
    let asked = Question::parse(question, &Catalogue::default()).expect("a question");
    let found = design(&model, &asked, 120.0, &mut |_, _| {}).expect("a design");
    for trial in &found.tried {
        let of = |one: &Forecast| format!("{} {:.2} (also {:?})", one.cause, one.probability, one.also_named);
        let predicted: Vec<String> = trial.predictions.iter().map(of).collect();
        println!("{question}: {:?} {:.0} s: {}", trial.experiment, trial.duration, predicted.join(", "));
    }
    (model, found)
}

/// Names of the question that a diagnosis leaves open: those it names, and those it cannot tell from them.
fn left_open<'q>(said: &Diagnosis, question: &'q str) -> Vec<&'q str> {
    let open = |name: &&str| {
        said.effects.iter().any(|one| one.effect == *name || one.confusable_with.iter().any(|other| other == name))
    };
    question.split('|').filter(open).collect()
}

/// With the ordinary recording that `ordinary` makes of the designed experiment the answer is not the cause alone for one of the causes at
/// least; with the experiment itself the right cause is named and the other is ruled out, whichever of both is inside.
fn separates(question: &str, seed: u64, ordinary: impl Fn(&Scenario, &Model) -> Scenario) -> Vec<usize> {
    let (model, found) = designed(question, seed);
    assert!(found.decides, "{question}: {:?}", found.best.predictions);
    let experiment = scenario(&found.best.scenario, &model);
    let (mut before, mut after) = (Vec::new(), Vec::new());
    for (index, Forecast { cause, assumed, .. }) in found.best.predictions.iter().enumerate() {
        let seed = seed + 1 + index as u64;
        before.push(left_open(&carried_out(&ordinary(&experiment, &model), Some(assumed), seed), question));
        after.push(left_open(&carried_out(&experiment, Some(assumed), seed), question));
        assert_eq!(after[index], [cause.as_str()], "{cause} inside");
    }
    println!("{question}: left open by ordinary data {before:?}, by the experiment {after:?}");
    assert_ne!(before, after, "ordinary data tell as well");
    before.into_iter().map(|open| open.len()).collect()
}

/// Both joints to and fro, `half` [rad] to either side.
fn narrow(half: f64, model: &Model) -> Scenario {
    let speed = 2.0 * half;
    let joint = format!("lowest = {}, highest = {half}, speed = {speed}, acceleration = 2.0", -half);
    let text = format!(
        "schema = \"lostmotion/scenario/1\"\nname = \"narrow\"\nrobot = \"model.toml\"\n\
         [[session]]\nname = \"loaded\"\nkind = \"fast\"\nduration = 50.0\njoints.joint1 = {{ {joint} }}\njoints.joint2 = {{ {joint} }}\n\
         [controller]\nlaw = \"pi\"\nvelocity = \"sensor\"\njoints.joint1 = {{ proportional = 6.0, integral = 35.0 }}\n\
         joints.joint2 = {{ proportional = 1.1, integral = 6.5 }}\n"
    );
    scenario(&text, model)
}

/// The torque of a spring and of a slope are both straight lines along a short way.
#[test]
fn recover_which_of_cable_and_tilt_it_is() {
    separates("cable_spring|base_tilt", 910_100, |_, model| narrow(0.16, model));
}

/// The same motions without the known mass: a payload makes the arm heavier, a weaker motor makes it look so.
#[test]
fn recover_which_of_payload_and_torque_constant_it_is() {
    let open = separates("payload|torque_constant_error", 910_200, |experiment, _| {
        let mut bare = experiment.clone();
        assert_eq!(bare.model.loads.len(), 1, "a known mass in one of the sessions");
        bare.model.loads.clear();
        bare.truth.alter(|machine| machine.loads.clear());
        bare
    });
    assert!(open.contains(&2), "both are open in one of the machines without the known mass: {open:?}");
}

/// Where dry friction does not fall, an asymmetry is the same constant in every motion as an offset, and what a drive reads at rest is
/// worth a few nats only: no experiment decides, and the answer says what would.
#[test]
fn property_what_no_experiment_tells_apart_is_said_to_be_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut model = machine(folder.path(), 910_300);
    for joint in &mut model.joints {
        if let Some(FrictionLaw::Exponential(law)) = joint.friction.as_mut().map(|friction| &mut friction.law) {
            law.iter_mut().for_each(|side| side.breakaway = side.coulomb);
        }
    }
    let asked = Question::parse("current_offset|coulomb_asymmetry", &Catalogue::default()).expect("a question");
    let found = design(&model, &asked, 45.0, &mut |_, _| {}).expect("a design");
    assert!(!found.decides, "{:?}", found.best.predictions);
    assert!(
        found.told_apart_by.iter().any(|advice| advice.contains("with the drive off")),
        "{:?}",
        found.told_apart_by
    );
}

/// A mass that the model knows of in that recording is no payload; the same recording under a model that does not, is.
#[test]
fn property_a_known_mass_is_named_only_where_the_model_lacks_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = machine(folder.path(), 910_400);
    let asked = Question::parse("payload|torque_constant_error", &Catalogue::default()).expect("a question");
    let mut experiment = narrow(0.25, &model);
    experiment.model.loads = vec![Load { session: "loaded".to_owned(), mass: 0.5, position: [0.2, 0.0, 0.0] }];
    let loads = experiment.model.loads.clone();
    experiment.truth.alter(|machine| machine.loads = loads);
    let options = Options { backlash: false, ..Options::default() };
    let mut named = 0;
    for seed in 910_401..910_404 {
        let said = carried_out(&experiment, None, seed);
        assert!(said.effects.is_empty(), "{seed}: {:?}", said.effects);
        let recorded = simulate(&experiment, seed, &|_, _| {}).expect("a run").measured();
        let mut unknown = experiment.model.clone();
        unknown.loads.clear();
        let said = diagnose(&unknown, &recorded, &[], &options, &mut |_, _| {}).expect("a diagnosis");
        named += usize::from(said.effects.iter().any(|one| asked.causes()[0] == one.effect));
    }
    // In 22 of 24 recordings, these three among them, half of them twice as wide, it is named: fewer than two of three have a probability of 2 %.
    assert!(named >= 2, "{named} of 3");
}

#[test]
fn property_a_budget_too_small_is_refused_with_the_least_that_would_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = machine(folder.path(), 910_500);
    let asked = Question::parse("payload|torque_constant_error", &Catalogue::default()).expect("a question");
    let least = |budget: f64| match design(&model, &asked, budget, &mut |_, _| {}) {
        Err(error) => error.to_string(),
        Ok(found) => panic!("{:?}", found.best),
    };
    let said = least(10.0);
    let words: Vec<&str> = said.split_whitespace().collect();
    let after = words.windows(3).find(|words| words[..2] == ["at", "least"]).expect("what would do");
    let seconds: f64 = after[2].parse().expect("a number of seconds");
    assert!(seconds > 10.0 && least(seconds - 2.0).contains(&format!("at least {seconds} s")), "{said}");
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

//! Nominal models whose masses, centres, inertias, rotors and torque constants are off by as much as their accuracy states: a healthy machine
//! gets no name, and a load that the model lacks is named first.
//!
//! Machines, errors of their models, motions and noise are drawn by seed. Nothing was tuned to these seeds.

#[path = "support/drawn/machine.rs"]
mod machine;
#[path = "support/drawn/motion.rs"]
mod motion;
#[path = "support/drawn/record.rs"]
mod record;
#[path = "support/rough.rs"]
mod rough;

use std::path::Path;

use lostmotion::diagnose::{Diagnosis, Options, diagnose};
use lostmotion::robot::{EffectEntry, Model};
use machine::Machine;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// [kg] The nominal second link with its tool, half of which is the load.
const SECOND_LINK: f64 = 1.4;

/// A machine of this seed that carries a load, as it is diagnosed with a rough model of it.
fn diagnosed(seed: u64, load: Option<f64>) -> Diagnosis {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let drawn = Machine::draw(&mut rng);
    let payload = |mass: f64| EffectEntry {
        effect: "payload".to_owned(),
        joint: None,
        parameters: [("mass".to_owned(), mass), ("x".to_owned(), drawn.reach())].into(),
    };
    let read = |text: &str| Model::from_texts(text, &drawn.urdf(), Path::new("model.toml")).expect("a good model");
    let machine = read(&drawn.truth(&load.map(payload).into_iter().collect::<Vec<_>>()));
    let motions = [motion::staircase(&mut rng), motion::fast(&mut rng), motion::fast(&mut rng), motion::fast(&mut rng)];
    let recorded: Vec<_> = (0_u64..)
        .zip(&motions)
        .map(|(index, motion)| record::record(&format!("run_{index}"), &machine, motion, 4 * seed + index))
        .collect();
    let nominal = rough::off(&read(&drawn.nominal()), seed, 1.0);
    let options = Options { backlash: false, ..Options::default() };
    let found = diagnose(&nominal, &recorded[..3], &recorded[3..], &options, &mut |_, _| {}).expect("a diagnosis");
    for one in &found.effects {
        println!("{seed} {load:?}: {} {:?} p {:.2} {:?}", one.effect, one.joints, one.probability, one.parameters);
    }
    println!("{seed} {load:?}: mistakes {:?}, unexplained {:?}", found.mistakes, found.unexplained);
    found
}

/// The negative control.
#[test]
fn property_a_healthy_machine_with_a_rough_model_gets_no_name() {
    let named = |seed: u64| {
        let found = diagnosed(seed, None);
        let names: Vec<String> = found.effects.iter().map(|one| one.effect.clone()).collect();
        (!names.is_empty() || !found.mistakes.is_empty()).then_some((seed, names, found.mistakes))
    };
    let wrong: Vec<_> = (7100..7104).into_par_iter().filter_map(named).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// The load sits at the tip, where 0.7 kg have as much inertia as the whole nominal link: the accuracy of masses does not hide it.
#[test]
fn recover_a_load_of_half_a_link_beside_a_rough_model() {
    (7110..7112).into_par_iter().for_each(|seed| {
        let load = 0.5 * SECOND_LINK;
        let found = diagnosed(seed, Some(load));
        let first = found.effects.first().expect("something is found");
        assert_eq!(first.effect, "payload", "{seed}");
        let mass = &first.parameters["mass"];
        // Three standard errors, which contain what the links may deviate by.
        assert!((mass.value - load).abs() < 3.0 * mass.std_error, "{seed}: {mass:?}");
    });
}

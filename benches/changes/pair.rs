//! A machine as it was and as it is, and recordings of both.

use std::path::Path;

use lostmotion::diagnose::{Diagnosis, Options, compare};
use lostmotion::robot::Model;
use lostmotion::timeseries::TimeSeries;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::machine::Machine;
use super::motion;
use super::record::record;

/// What is different now.
#[derive(Debug, Clone)]
pub struct Alteration {
    /// Factors on viscous friction, on the gap and on the rotor's inertia of both joints.
    pub viscous: [f64; 2],
    pub backlash: [f64; 2],
    pub rotor_inertia: [f64; 2],
}

impl Alteration {
    pub fn none() -> Self {
        let ones = [1.0, 1.0];
        Self { viscous: ones, backlash: ones, rotor_inertia: ones }
    }

    fn apply(&self, machine: &Machine) -> Machine {
        let mut machine = machine.clone();
        for i in 0..2 {
            machine.friction[i].viscous *= self.viscous[i];
            machine.backlash[i] *= self.backlash[i];
            machine.rotor_inertia[i] *= self.rotor_inertia[i];
        }
        machine
    }
}

/// A machine and what is different now.
#[derive(Debug, Clone)]
pub struct Pair {
    pub machine: Machine,
    pub alteration: Alteration,
}

impl Pair {
    pub fn draw(seed: u64) -> Self {
        let machine = Machine::draw(&mut ChaCha8Rng::seed_from_u64(seed));
        Self { machine, alteration: Alteration::none() }
    }

    /// What the program is given.
    pub fn nominal(&self) -> Model {
        Model::from_texts(&self.machine.nominal(), &self.machine.urdf(), Path::new("model.toml")).expect("a good model")
    }

    /// A staircase and two fast runs of a machine; the seed decides motions and noise.
    fn sessions(machine: &Machine, seed: u64) -> Vec<TimeSeries> {
        let text = machine.truth(&[]);
        let model = Model::from_texts(&text, &machine.urdf(), Path::new("truth.toml")).expect("a good model");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let motions = [motion::staircase(&mut rng), motion::fast(&mut rng), motion::fast(&mut rng)];
        let named = ["staircase", "fast_1", "fast_2"].iter().zip(&motions).enumerate();
        named.map(|(index, (name, motion))| record(name, &model, motion, 10 * seed + index as u64)).collect()
    }

    pub fn reference(&self, seed: u64) -> Vec<TimeSeries> {
        Self::sessions(&self.machine, 2 * seed)
    }

    pub fn now(&self, seed: u64) -> Vec<TimeSeries> {
        Self::sessions(&self.alteration.apply(&self.machine), 2 * seed + 1)
    }

    pub fn compared(&self, seed: u64) -> Diagnosis {
        let (reference, now) = rayon::join(|| self.reference(seed), || self.now(seed));
        compare(&self.nominal(), &reference, &now, &[], &Options::default(), &mut |_, _| {}).expect("a comparison")
    }
}

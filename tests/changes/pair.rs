//! A machine as it was and as it is, and recordings of both.

use std::path::{Path, PathBuf};

use lostmotion::dataset;
use lostmotion::diagnose::{Diagnosis, Options, compare};
use lostmotion::robot::{EffectEntry, Model};
use lostmotion::timeseries::TimeSeries;
use lostmotion::units::JointKind;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::machine::Machine;
use super::motion;
use super::record::record;

/// What is different now.
#[derive(Debug, Clone, Default)]
pub struct Alteration {
    /// Factors on viscous friction, on the gap and on the rotor's inertia of both joints.
    pub viscous: [f64; 2],
    pub backlash: [f64; 2],
    pub rotor_inertia: [f64; 2],
    /// Factor on Coulomb and breakaway friction.
    pub coulomb: [f64; 2],
    /// Effects of the catalogue.
    pub effects: Vec<EffectEntry>,
}

impl Alteration {
    pub fn none() -> Self {
        let ones = [1.0, 1.0];
        Self { viscous: ones, backlash: ones, rotor_inertia: ones, coulomb: ones, effects: Vec::new() }
    }

    fn apply(&self, machine: &Machine) -> Machine {
        let mut machine = machine.clone();
        for i in 0..2 {
            machine.friction[i].viscous *= self.viscous[i];
            machine.friction[i].coulomb *= self.coulomb[i];
            machine.friction[i].breakaway *= self.coulomb[i];
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
    /// Effects that were there before already.
    pub always: Vec<EffectEntry>,
    pub alteration: Alteration,
}

impl Pair {
    pub fn draw(seed: u64) -> Self {
        let machine = Machine::draw(&mut ChaCha8Rng::seed_from_u64(seed));
        Self { machine, always: Vec::new(), alteration: Alteration::none() }
    }

    /// What the program is given.
    pub fn nominal(&self) -> Model {
        Model::from_texts(&self.machine.nominal(), &self.machine.urdf(), Path::new("model.toml")).expect("a good model")
    }

    /// A staircase and two fast runs of a machine; the seed decides motions and noise.
    fn sessions(&self, machine: &Machine, effects: &[EffectEntry], seed: u64) -> Vec<TimeSeries> {
        let text = machine.truth(effects);
        let model = Model::from_texts(&text, &machine.urdf(), Path::new("truth.toml")).expect("a good model");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let motions = [motion::staircase(&mut rng), motion::fast(&mut rng), motion::fast(&mut rng)];
        let named = ["staircase", "fast_1", "fast_2"].iter().zip(&motions).enumerate();
        named.map(|(index, (name, motion))| cached(&text, name, &model, motion, 10 * seed + index as u64)).collect()
    }

    pub fn reference(&self, seed: u64) -> Vec<TimeSeries> {
        self.sessions(&self.machine, &self.always, 2 * seed)
    }

    pub fn now(&self, seed: u64) -> Vec<TimeSeries> {
        let effects = [self.always.as_slice(), &self.alteration.effects].concat();
        self.sessions(&self.alteration.apply(&self.machine), &effects, 2 * seed + 1)
    }

    pub fn compared(&self, seed: u64) -> Diagnosis {
        let (reference, now) = rayon::join(|| self.reference(seed), || self.now(seed));
        compare(&self.nominal(), &reference, &now, &[], &Options::default(), &mut |_, _| {}).expect("a comparison")
    }
}

/// Recordings are kept in the folder `CHANGES_CACHE` where it is set: simulating them takes longer than comparing them.
fn cached(text: &str, name: &str, model: &Model, motion: &motion::Motion, seed: u64) -> TimeSeries {
    use std::hash::{DefaultHasher, Hash, Hasher};
    let Some(folder) = std::env::var_os("CHANGES_CACHE").map(PathBuf::from) else {
        return record(name, model, motion, seed);
    };
    let mut hasher = DefaultHasher::new();
    (text, seed).hash(&mut hasher);
    let file = folder.join(format!("{:016x}_{name}.csv", hasher.finish()));
    if !file.is_file() {
        let series = record(name, model, motion, seed);
        let part = file.with_extension(format!("{}.part", std::process::id()));
        dataset::write_csv(&part, &series, &[JointKind::Revolute; 2]).expect("a recording");
        std::fs::rename(&part, &file).expect("a recording");
    }
    let mut series = dataset::load(&file, &dataset::joints_of(model)).expect("a recording").series;
    name.clone_into(&mut series.name);
    series
}

fn entry(effect: &str, joint: Option<&str>, parameters: &[(&str, f64)]) -> EffectEntry {
    let parameters = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    EffectEntry { effect: effect.to_owned(), joint: joint.map(str::to_owned), parameters }
}

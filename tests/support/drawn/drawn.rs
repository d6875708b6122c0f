//! A set as it is drawn, before anything of it is written: what tests plant in memory is what the blind sets hold.

use std::path::Path;

use lostmotion::robot::{EffectEntry, Model};
use lostmotion::timeseries::TimeSeries;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::arm::SixJoints;
use super::hidden::{self, Arm, Field, Order};
use super::machine::Machine;
use super::motion::{self, INTERVAL, Motion, Space};
use super::record::{self, Gains, record, record_at};
use super::rough;
use super::sampling::Sampling;

/// Names of the sessions of a laboratory; the last one is held out.
pub const SESSIONS: [&str; 4] = ["staircase", "fast_1", "fast_2", "fast_3"];
/// Names of the sessions of the field.
pub const FIELD_SESSIONS: [&str; 4] = ["staircase", "run_1", "run_2", "run_3"];
/// Speeds of the staircase of six joints, which takes as long as that of two.
const STEPS: usize = 6;

/// The streams of random numbers of one seed.
const MACHINE: u64 = 0;
const EFFECTS: u64 = 1;
/// Of the motion; one more on another day.
const MOTION: u64 = 2;
const SENSORS: u64 = 4;
const TIMES: u64 = 5;

/// A machine of an order, with what is hidden in it.
#[derive(Debug)]
pub struct Drawn {
    /// The model that the program is given.
    pub nominal: Model,
    /// The machine that moves, without what is hidden in it.
    pub machine: Model,
    /// What is hidden in it.
    pub entries: Vec<EffectEntry>,
    /// How it is sampled; `None`: as in a laboratory.
    pub sampling: Option<Sampling>,
    six_joints: Option<SixJoints>,
    seed: u64,
    /// Another day has other motions and other noise.
    later: u64,
}

/// Streams of random numbers of one seed: the machine and its motion are the same whatever it hides, and whatever model of it is given.
fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}

impl Drawn {
    pub fn new(order: &Order) -> Self {
        let mut effects = stream(order.seed, EFFECTS);
        let (nominal, machine, entries, six_joints) = match order.field.map(|field| field.arm) {
            None | Some(Arm::Planar) => {
                let mut machine = Machine::draw(&mut stream(order.seed, MACHINE));
                let entries = hidden::draw(&mut effects, order, &mut machine);
                hidden::change(&mut effects, order, &mut machine);
                let model = |text: &str| {
                    Model::from_texts(text, &machine.urdf(), Path::new("model.toml")).expect("a good model")
                };
                (model(&machine.nominal()), model(&machine.truth(&[])), entries, None)
            }
            Some(Arm::SixJoints) => {
                let mut arm = SixJoints::draw(&mut stream(order.seed, MACHINE));
                let entries = hidden::draw(&mut effects, order, &mut arm);
                (arm.nominal(), arm.truth.clone(), entries, Some(arm))
            }
        };
        let later = u64::from(order.changed().is_some());
        let drawn = Self { nominal, machine, entries, sampling: None, six_joints, seed: order.seed, later };
        match &order.field {
            None => drawn,
            Some(field) => drawn.in_field(field),
        }
    }

    /// With sensors, sampling and errors of the nominal model as users have them.
    fn in_field(mut self, field: &Field) -> Self {
        let sampling = Sampling::draw(&mut stream(self.seed, SENSORS));
        sampling.equip(&mut self.machine);
        sampling.equip(&mut self.nominal);
        self.nominal = rough::off(&self.nominal, self.seed, field.rough);
        self.sampling = Some(sampling);
        self
    }

    /// The machine that moves, with what is hidden in it.
    pub fn truth(&self) -> Model {
        Model { effects: self.entries.clone(), ..self.machine.clone() }
    }

    /// Names of its sessions, in their order.
    pub fn names(&self) -> [&'static str; 4] {
        if self.sampling.is_some() { FIELD_SESSIONS } else { SESSIONS }
    }

    /// Records the sessions, one after the other.
    pub fn sessions(&self) -> impl Iterator<Item = TimeSeries> {
        let truth = self.truth();
        let mut moves = stream(self.seed, MOTION + self.later);
        let mut times = stream(self.seed, TIMES);
        let picks = self.sampling.is_some() && times.random_bool(0.5);
        self.names().into_iter().enumerate().map(move |(index, name)| {
            let motion = self.motion(&mut moves, index == 0, picks);
            let seed = 4 * self.seed + index as u64 + (self.later << 40);
            let Some(sampling) = &self.sampling else { return record(name, &truth, &motion, seed) };
            let times = sampling.times(&mut times, motion.velocity[0].len() as f64 * INTERVAL);
            record_at(name, &truth, &self.gains(&motion.start), &motion, times.into_iter(), seed)
        })
    }

    /// A staircase, or a run: pick and place, or fast.
    fn motion(&self, rng: &mut ChaCha8Rng, slow: bool, picks: bool) -> Motion {
        let spaces: Vec<Space> = if self.six_joints.is_some() { SixJoints::spaces() } else { Space::PLANAR.into() };
        match (slow, picks) {
            (true, _) if self.six_joints.is_none() => motion::staircase(rng),
            (true, _) => {
                let start = spaces.iter().map(|space| space.middle + 0.5 * space.half * rng.random_range(-1.0..1.0));
                let start = start.collect();
                motion::stairs(rng, start, STEPS)
            }
            (false, true) => motion::pick_and_place(rng, &spaces),
            (false, false) => motion::fast_in(rng, &spaces),
        }
    }

    fn gains(&self, start: &[f64]) -> Vec<Gains> {
        self.six_joints.as_ref().map_or_else(|| record::PLANAR.into(), |arm| arm.gains(start))
    }
}

//! Which machines are drawn by which seeds: `FIRST + 0..400` hide nothing, `FIRST + 400..1000` two effects, and the effect of index `k`
//! in alphabetical order has `FIRST + 1000 + 200 k + 0..100` at strength 1, `+ 100..200` at other strengths. Machines that are compared
//! with themselves have `FIRST + 8000 + 100 k + 0..100`, `k` the index of what has changed, the last of them nothing. No two share a seed.

use rand::SeedableRng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use super::arguments::Arguments;
use super::hidden::{CHANGED, CHANGES, Field, Order};
use super::strengths::EFFECTS;

const PAIRS: u64 = 400;
const SINGLE: u64 = 1000;
const OF_EACH: u64 = 200;
const WEAKER: u64 = 100;
const LATER: u64 = 8000;
/// A joint's friction remembers one thing at a time.
const WITH_A_MEMORY: [&str; 2] = ["dwell_stiction", "presliding"];

/// Machines to be drawn.
pub struct Plan<'a> {
    pub effects: &'a [String],
    pub machines: std::ops::Range<u64>,
    pub strength: f64,
    pub seeds: u64,
    /// `None`: sets of the laboratory. The same seed has the same machine whatever the errors of its model.
    pub field: Option<Field>,
}

impl<'a> Plan<'a> {
    pub fn of(arguments: &'a Arguments, field: Option<Field>) -> Self {
        let Arguments { effects, machines, skip, strength, seeds, .. } = arguments;
        Self { effects, machines: *skip..skip + machines, strength: *strength, seeds: *seeds, field }
    }

    /// One order a machine, the effects taking turns.
    pub fn orders(&self) -> Vec<Order> {
        let in_field = |order: Order| Order { field: self.field, ..order };
        self.machines
            .clone()
            .flat_map(|machine| self.effects.iter().map(move |name| in_field(self.order(name, machine))))
            .collect()
    }

    /// Number of a machine that hides one effect, among those of its effect and strength, whatever the first seed (a multiple of 100).
    pub fn number(order: &Order) -> u64 {
        order.seed % WEAKER
    }

    fn order(&self, name: &str, machine: u64) -> Order {
        let within = |most: u64| {
            assert!(machine < most, "there are seeds for {most} machines of {name}");
            machine
        };
        match name {
            "none" => Order::nothing(self.seeds + within(PAIRS)),
            "pairs" => {
                let seed = self.seeds + PAIRS + within(SINGLE - PAIRS);
                let effects = pair(&mut ChaCha8Rng::seed_from_u64(seed), &EFFECTS);
                Order { field: None, effects, strength: self.strength, seed }
            }
            _ => {
                let index = EFFECTS.iter().position(|one| *one == name).expect("a known effect") as u64;
                let offset = if self.strength == 1.0 { 0 } else { WEAKER };
                let seed = self.seeds + SINGLE + OF_EACH * index + offset + within(WEAKER);
                Order::one(name, self.strength, seed)
            }
        }
    }
}

/// Machines to be compared with themselves, `machines` for each change and as many without one.
pub fn later(seeds: u64, machines: u64) -> Vec<Order> {
    let quantities = CHANGES.iter().map(|(quantity, _)| *quantity).chain([""]);
    let of = |(index, quantity): (usize, &'static str)| {
        let seed = seeds + LATER + 100 * index as u64;
        (0..machines).map(move |machine| Order::one(&format!("{CHANGED}{quantity}"), 1.0, seed + machine))
    };
    quantities.enumerate().flat_map(of).collect()
}

/// Two different effects that one machine can have at once.
fn pair(rng: &mut ChaCha8Rng, among: &[&str]) -> Vec<String> {
    loop {
        let two: Vec<&str> = among.sample(rng, 2).copied().collect();
        if two.len() < 2 || two.iter().any(|one| !WITH_A_MEMORY.contains(one)) {
            return two.into_iter().map(str::to_owned).collect();
        }
    }
}

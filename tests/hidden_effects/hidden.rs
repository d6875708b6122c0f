//! What is hidden in a machine: nothing, an effect of the catalogue, or two.

use lostmotion::robot::EffectEntry;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::machine::{JOINTS, Machine};
use super::strengths::{self, EFFECTS};

/// Part by which a strength scatters around what was ordered.
const SPREAD: f64 = 0.1;

/// What is to be hidden, and by which seed everything else is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Order {
    /// Names of the catalogue, none to two.
    pub effects: Vec<String>,
    /// 1 or 0.5: see [`strengths`].
    pub strength: f64,
    pub seed: u64,
}

impl Order {
    /// A machine that hides nothing.
    pub fn nothing(seed: u64) -> Self {
        Self { effects: Vec::new(), strength: 0.0, seed }
    }

    /// One effect.
    pub fn one(effect: &str, strength: f64, seed: u64) -> Self {
        Self { effects: vec![effect.to_owned()], strength, seed }
    }

    /// Name of its folder: `cogging_1000`, `cogging+payload_1001`, `none_1002`.
    pub fn name(&self) -> String {
        let effects = if self.effects.is_empty() { "none".to_owned() } else { self.effects.join("+") };
        format!("{effects}_{}", self.seed)
    }
}

/// Draws what was ordered, on one joint or both; may change the machine so that the effect can show.
pub fn draw(rng: &mut ChaCha8Rng, order: &Order, machine: &mut Machine) -> Vec<EffectEntry> {
    let mut entries = Vec::new();
    for effect in &order.effects {
        assert!(EFFECTS.contains(&effect.as_str()), "{effect} is none of {EFFECTS:?}");
        let strength = order.strength * (1.0 + rng.random_range(-SPREAD..SPREAD));
        // What a free friction law would take for its own shows only where the law is known to lack it.
        if effect == "stribeck" {
            machine.know_friction();
        }
        match strengths::of_machine(rng, effect, strength, machine) {
            Some(drawn) => entries.push(entry(effect, None, drawn)),
            None => {
                for joint in joints(rng) {
                    let drawn = strengths::of_joint(rng, effect, strength, machine, joint);
                    entries.push(entry(effect, Some(joint), drawn));
                }
            }
        }
    }
    entries
}

/// In one of four the first joint alone, in one the second, in two both.
fn joints(rng: &mut ChaCha8Rng) -> Vec<usize> {
    match rng.random_range(0..4) {
        0 => vec![0],
        1 => vec![1],
        _ => vec![0, 1],
    }
}

fn entry(effect: &str, joint: Option<usize>, drawn: strengths::Drawn) -> EffectEntry {
    let parameters = drawn.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    EffectEntry { effect: effect.to_owned(), joint: joint.map(|joint| JOINTS[joint].to_owned()), parameters }
}

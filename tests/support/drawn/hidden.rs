//! What is hidden in a machine: nothing, an effect of the catalogue, or two.

use lostmotion::robot::EffectEntry;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::machine::{JOINTS, Machine};
use super::strengths::{self, EFFECTS};

/// Part by which a strength scatters around what was ordered.
const SPREAD: f64 = 0.1;

/// What a machine can have changed of its own, and by how much: what the baseline fits anyway, so that it takes two recordings to see it.
pub const CHANGES: [(&str, f64); 3] = [("backlash", 1.25), ("rotor_inertia", 1.1), ("viscous", 1.2)];
/// What stands before the name of such a quantity where it is ordered.
pub const CHANGED: &str = "changed:";

/// What is to be hidden, and by which seed everything else is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Order {
    /// Names of the catalogue, none to two; or [`CHANGED`] with one of [`CHANGES`] or nothing behind it: the machine of this seed some
    /// time later, along motions of its own.
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

    /// What has changed of it, if it is a machine some time later.
    pub fn changed(&self) -> Option<&str> {
        self.effects.first()?.strip_prefix(CHANGED)
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
    if let Some(quantity) = order.changed() {
        change(rng, quantity, machine);
        return entries;
    }
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

/// Changes a quantity on one joint or both.
fn change(rng: &mut ChaCha8Rng, quantity: &str, machine: &mut Machine) {
    let Some((_, factor)) = CHANGES.iter().find(|(name, _)| *name == quantity) else { return };
    for joint in joints(rng) {
        match quantity {
            "backlash" => machine.backlash[joint] *= factor,
            "rotor_inertia" => machine.rotor_inertia[joint] *= factor,
            _ => machine.friction[joint].viscous *= factor,
        }
    }
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

//! What is hidden in a machine: nothing, an effect of the catalogue, or two.
#![allow(dead_code, reason = "every test file is its own crate and uses its own part")]

use lostmotion::robot::EffectEntry;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::machine::{GEAR_RATIO, JOINTS, Machine};
use super::strengths::{self, EFFECTS, JointSizes, Payload};

/// Part by which a strength scatters around what was ordered.
const SPREAD: f64 = 0.1;

/// What a machine can have changed of its own, and by how much: what the baseline fits anyway, so that it takes two recordings to see it.
pub const CHANGES: [(&str, f64); 3] = [("backlash", 1.25), ("rotor_inertia", 1.1), ("viscous", 1.2)];
/// What stands before the name of such a quantity where it is ordered.
pub const CHANGED: &str = "changed:";

/// Kinds of machines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arm {
    /// Two joints with vertical axes.
    Planar,
    /// Six joints under gravity.
    SixJoints,
}

impl Arm {
    pub const ALL: [Self; 2] = [Self::Planar, Self::SixJoints];

    /// Its name on a command line and in the names of sets.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Planar => "planar",
            Self::SixJoints => "six_joints",
        }
    }
}

/// A set as users have it: sampling, sensors and motion are drawn, and the nominal model is off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Field {
    pub arm: Arm,
    /// [1] Errors of the nominal model in units of the default accuracy; 0: exact, and the model file says so.
    pub rough: f64,
}

impl Field {
    /// As it stands in the name of a set: `planar_rough_0.5`.
    pub fn name(&self) -> String {
        format!("{}_rough_{}", self.arm.name(), self.rough)
    }
}

/// What is to be hidden, and by which seed everything else is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Order {
    /// `None`: a set of the laboratory, a planar arm with an exact nominal model, the same sensors and sampling for all.
    pub field: Option<Field>,
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
        Self { field: None, effects: Vec::new(), strength: 0.0, seed }
    }

    /// One effect.
    pub fn one(effect: &str, strength: f64, seed: u64) -> Self {
        Self { field: None, effects: vec![effect.to_owned()], strength, seed }
    }

    /// What has changed of it, if it is a machine some time later.
    pub fn changed(&self) -> Option<&str> {
        self.effects.first()?.strip_prefix(CHANGED)
    }

    /// Name of its folder: `cogging_1000`, `cogging+payload_1001`, `none_1002`, `none_planar_rough_1_1002`.
    pub fn name(&self) -> String {
        let effects = if self.effects.is_empty() { "none".to_owned() } else { self.effects.join("+") };
        let field = self.field.map_or(String::new(), |field| format!("{}_", field.name()));
        format!("{effects}_{field}{}", self.seed)
    }
}

/// A machine in which something can be hidden.
pub trait Host {
    /// Names of its joints.
    fn joints(&self) -> Vec<String>;
    /// What strengths on a joint are measured by.
    fn sizes(&self, joint: usize) -> JointSizes;
    /// A load of strength 1.
    fn payload(&self) -> Payload;
    /// Takes the falling part from the friction, and puts the friction in the nominal model.
    fn know_friction(&mut self);
}

impl Host for Machine {
    fn joints(&self) -> Vec<String> {
        JOINTS.map(str::to_owned).into()
    }

    fn sizes(&self, joint: usize) -> JointSizes {
        JointSizes {
            gear_ratio: GEAR_RATIO[joint],
            rotor_inertia: self.rotor_inertia[joint],
            backlash: self.backlash[joint],
            friction: self.friction[joint],
            link_share: self.link_share,
            middle: 0.0,
            reach: 1.0,
            cable: [0.15, 0.08][joint],
            contact: [2.5, 1.25][joint],
            drag: [0.15, 0.07][joint],
            disturbance: [0.07, 0.05][joint],
            offset: 0.5,
            dead_band: 0.45,
            soft: 245.0,
            load_friction: 0.15,
        }
    }

    fn payload(&self) -> Payload {
        Payload { mass: 0.5, x: self.reach(), z: 0.0 }
    }

    fn know_friction(&mut self) {
        Machine::know_friction(self);
    }
}

/// Draws what was ordered, on one joint or two; may change the machine so that the effect can show.
pub fn draw(rng: &mut ChaCha8Rng, order: &Order, machine: &mut impl Host) -> Vec<EffectEntry> {
    let mut entries = Vec::new();
    if order.changed().is_some() {
        return entries;
    }
    let names = machine.joints();
    for effect in &order.effects {
        assert!(EFFECTS.contains(&effect.as_str()), "{effect} is none of {EFFECTS:?}");
        let strength = order.strength * (1.0 + rng.random_range(-SPREAD..SPREAD));
        // What a free friction law would take for its own shows only where the law is known to lack it.
        if ["stribeck", "regularised_friction"].contains(&effect.as_str()) {
            machine.know_friction();
        }
        match strengths::of_machine(rng, effect, strength, &machine.payload()) {
            Some(drawn) => entries.push(entry(effect, None, drawn)),
            None => {
                for joint in joints(rng, names.len()) {
                    let drawn = strengths::of_joint(rng, effect, strength, &machine.sizes(joint));
                    entries.push(entry(effect, Some(&names[joint]), drawn));
                }
            }
        }
    }
    entries
}

/// Changes the quantity that was ordered to change, on one joint or both.
pub fn change(rng: &mut ChaCha8Rng, order: &Order, machine: &mut Machine) {
    let Some((quantity, factor)) = CHANGES.iter().find(|(name, _)| order.changed() == Some(name)) else { return };
    for joint in joints(rng, JOINTS.len()) {
        match *quantity {
            "backlash" => machine.backlash[joint] *= factor,
            "rotor_inertia" => machine.rotor_inertia[joint] *= factor,
            _ => machine.friction[joint].viscous *= factor,
        }
    }
}

/// In one of four the first joint alone, in one the second, in two both; of more joints, the same of two neighbours.
fn joints(rng: &mut ChaCha8Rng, count: usize) -> Vec<usize> {
    let first = if count > 2 { rng.random_range(0..count - 1) } else { 0 };
    match rng.random_range(0..4) {
        0 => vec![first],
        1 => vec![first + 1],
        _ => vec![first, first + 1],
    }
}

fn entry(effect: &str, joint: Option<&String>, drawn: strengths::Drawn) -> EffectEntry {
    let parameters = drawn.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    EffectEntry { effect: effect.to_owned(), joint: joint.cloned(), parameters }
}

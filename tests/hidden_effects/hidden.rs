//! What is hidden in a machine: an effect of the catalogue, drawn by seed, with its strength.
//!
//! A strength of 1 moves the torque by roughly a tenth to a third of what friction and inertia take; it is drawn from 0.7 to 1.5.

use std::f64::consts::PI;

use lostmotion::robot::EffectEntry;
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use super::machine::{JOINTS, Machine};

/// The effects that may be hidden.
pub const EFFECTS: [&str; 12] = [
    "base_tilt",
    "cable_spring",
    "cogging",
    "coulomb_asymmetry",
    "current_offset",
    "load_dependent_friction",
    "payload",
    "position_dependent_friction",
    "quadratic_drag",
    "sensor_delay",
    "stribeck",
    "viscous_asymmetry",
];

/// What was hidden.
#[derive(Debug, Clone)]
pub struct Hidden {
    /// Name of the catalogue; `None`: nothing.
    pub effect: Option<&'static str>,
    /// Against the middle strength.
    pub strength: f64,
    /// One entry a joint that it acts on.
    pub entries: Vec<EffectEntry>,
}

impl Hidden {
    /// Nothing is hidden. In one set of four the nominal model file holds the friction.
    pub fn nothing(rng: &mut ChaCha8Rng, machine: &mut Machine) -> Self {
        know_friction(rng, machine);
        Self { effect: None, strength: 0.0, entries: Vec::new() }
    }

    /// One of the effects, on one joint or both; may change the machine so that the effect can show.
    pub fn draw(rng: &mut ChaCha8Rng, machine: &mut Machine) -> Self {
        let effect = *EFFECTS.choose(rng).expect("the list is not empty");
        let strength = rng.random_range(0.7..1.5);
        if effect == "stribeck" {
            machine.friction_unknown = false;
            for friction in &mut machine.friction {
                friction.breakaway = friction.coulomb;
            }
        } else {
            know_friction(rng, machine);
        }
        let entries = match effect {
            "base_tilt" => {
                let azimuth = rng.random_range(-PI..PI);
                vec![of_machine(effect, &[("tilt", 0.05 * strength), ("azimuth", azimuth)])]
            }
            "payload" => vec![of_machine(effect, &[("mass", 0.5 * strength), ("x", machine.reach())])],
            "sensor_delay" => {
                let channel = if rng.random_bool(0.5) { "current_delay" } else { "position_delay" };
                vec![of_machine(effect, &[(channel, 0.01 * strength)])]
            }
            _ => joints(rng).into_iter().map(|joint| of_joint(rng, effect, joint, strength, machine)).collect(),
        };
        Self { effect: Some(effect), strength, entries }
    }
}

/// In one set of four the friction has no falling part and the nominal model file holds it.
fn know_friction(rng: &mut ChaCha8Rng, machine: &mut Machine) {
    if rng.random_bool(0.25) {
        machine.friction_unknown = false;
        for friction in &mut machine.friction {
            friction.breakaway = friction.coulomb;
        }
    }
}

fn joints(rng: &mut ChaCha8Rng) -> Vec<usize> {
    match rng.random_range(0..4) {
        0 => vec![0],
        1 => vec![1],
        _ => vec![0, 1],
    }
}

fn of_machine(effect: &str, parameters: &[(&str, f64)]) -> EffectEntry {
    let parameters = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    EffectEntry { effect: effect.to_owned(), joint: None, parameters }
}

fn of_joint(rng: &mut ChaCha8Rng, effect: &str, joint: usize, strength: f64, machine: &Machine) -> EffectEntry {
    let friction = machine.friction[joint];
    let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let phase = rng.random_range(-PI..PI);
    let parameters = match effect {
        "cable_spring" => {
            vec![("stiffness", [0.15, 0.08][joint] * strength), ("rest_position", rng.random_range(-1.0..1.0))]
        }
        "cogging" => {
            let order = f64::from(rng.random_range(3..13));
            vec![("amplitude", 0.15 * friction.coulomb * strength), ("order", order), ("phase", phase)]
        }
        "coulomb_asymmetry" => vec![("asymmetry", 0.15 * strength * sign)],
        "current_offset" => vec![("offset", 0.5 * strength * sign)],
        "load_dependent_friction" => vec![("coefficient", 0.15 * strength)],
        "position_dependent_friction" => {
            let order = f64::from(rng.random_range(1..4));
            vec![("amplitude", 0.25 * strength), ("order", order), ("phase", phase)]
        }
        "quadratic_drag" => vec![("coefficient", [0.15, 0.07][joint] * strength)],
        "stribeck" => vec![
            ("breakaway", friction.coulomb * (1.0 + 0.3 * strength)),
            ("stribeck_velocity", friction.stribeck_velocity),
        ],
        "viscous_asymmetry" => {
            let difference = 0.25 * strength * sign;
            vec![
                ("positive", friction.viscous * (1.0 + difference)),
                ("negative", friction.viscous * (1.0 - difference)),
            ]
        }
        other => unreachable!("{other} is not drawn"),
    };
    EffectEntry { joint: Some(JOINTS[joint].to_owned()), ..of_machine(effect, &parameters) }
}

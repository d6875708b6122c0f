//! A machine by seed with one of the effects of the reversal zone in it, or with none.

use std::f64::consts::PI;
use std::path::Path;

use lostmotion::robot::{EffectEntry, Model};
use lostmotion::timeseries::TimeSeries;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::machine::{JOINTS, Machine};
use super::motion;
use super::record::record;

/// Recordings of one machine.
pub struct Set {
    /// What the program is given.
    pub nominal: Model,
    /// Staircase and three fast runs.
    pub sessions: Vec<TimeSeries>,
    /// What is in the machine.
    pub entries: Vec<EffectEntry>,
}

/// Draws a machine, puts the effect on one of its joints, and records it.
pub fn set(effect: &str, seed: u64) -> Set {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let machine = Machine::draw(&mut rng);
    let joint = rng.random_range(0..2_usize);
    let strength = rng.random_range(0.7..1.3);
    let entries = entries(&mut rng, &machine, effect, joint, strength);
    let truth = machine.truth(&entries);
    let model = Model::from_texts(&truth, &machine.urdf(), Path::new("truth.toml")).expect("a good model");
    let nominal =
        Model::from_texts(&machine.nominal(), &machine.urdf(), Path::new("model.toml")).expect("a good model");
    let sessions = ["staircase", "fast_1", "fast_2", "fast_3"]
        .into_iter()
        .enumerate()
        .map(|(index, name)| {
            let motion = if index == 0 { motion::staircase(&mut rng) } else { motion::fast(&mut rng) };
            record(name, &model, &motion, 4 * seed + index as u64)
        })
        .collect();
    Set { nominal, sessions, entries }
}

fn entries(rng: &mut ChaCha8Rng, machine: &Machine, effect: &str, joint: usize, strength: f64) -> Vec<EffectEntry> {
    let friction = machine.friction[joint];
    let parameters: Vec<(&str, f64)> = match effect {
        "none" => return Vec::new(),
        "presliding" => {
            let stiffness = friction.coulomb / (0.0025 * strength);
            vec![("stiffness", stiffness), ("damping", (stiffness * machine.rotor_inertia[joint]).sqrt())]
        }
        "dwell_stiction" => vec![
            ("growth", 0.5 * strength * friction.coulomb),
            ("time_constant", rng.random_range(0.1..1.0)),
            ("slip_distance", rng.random_range(0.005..0.015)),
        ],
        "coupling_slip" => {
            let jump = 1.5 * strength * machine.backlash[joint] * if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            vec![("jump", jump), ("time", rng.random_range(8.0..32.0))]
        }
        "position_dependent_friction" => {
            vec![("amplitude", 0.25 * strength), ("order", 2.0), ("phase", rng.random_range(-PI..PI))]
        }
        "joint_compliance" => vec![("stiffness", 60.0 * strength)],
        "cogging" => vec![("amplitude", 0.15 * strength * friction.coulomb), ("order", 7.0), ("phase", 0.3)],
        other => unreachable!("{other}"),
    };
    let parameters = parameters.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    vec![EffectEntry { effect: effect.to_owned(), joint: Some(JOINTS[joint].to_owned()), parameters }]
}

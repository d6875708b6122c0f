//! Mistakes over every effect, on a six-joint arm and in recordings: too long for the tests.
//!
//! `cargo test --release --bench mistakes`. Checks on recordings that are missing are reported as ignored, never as passed.

#[path = "../../tests/support/drawn/hidden.rs"]
mod hidden;
#[path = "../../tests/mistakes/judged.rs"]
mod judged;
#[path = "../../tests/support/drawn/machine.rs"]
#[allow(dead_code)]
mod machine;
#[path = "../../tests/mistakes/machines.rs"]
#[allow(dead_code)]
mod machines;
#[path = "../../tests/support/drawn/motion.rs"]
mod motion;
#[path = "../../tests/mistakes/planted.rs"]
#[allow(dead_code)]
mod planted;
#[path = "../../tests/support/drawn/record.rs"]
mod record;
#[path = "../../tests/support/six_joints.rs"]
#[allow(dead_code)]
mod six_joints;
#[path = "../../tests/support/drawn/strengths.rs"]
#[allow(dead_code)]
mod strengths;

use std::process::ExitCode;

use hidden::Order;
use judged::{mostly_told, sound, table};
use libtest_mimic::{Arguments, Trial};
use rayon::prelude::*;
use strengths::EFFECTS;

/// Seed of the machines here: none of the tuning.
const SEED: u64 = 30_500;
/// Strengths of an effect: 1 is clearly visible, see `strengths`.
const STRENGTHS: [f64; 3] = [0.5, 1.0, 2.0];
/// [s] Both halves of the fast run, the second in part: a coupling slips after 8 to 32 s.
const SECONDS: f64 = 28.0;
/// A gap that changes along the way by more than its width is none.
const WIDEST_CHANGE_OF_A_GAP: f64 = 1.8;

fn every_effect_at_every_strength_is_sound() {
    let of = |(k, effect): (u64, &&str)| -> Vec<Order> {
        let most = if *effect == "position_dependent_backlash" { WIDEST_CHANGE_OF_A_GAP } else { f64::INFINITY };
        (0..)
            .zip(STRENGTHS)
            .map(|(i, strength)| Order::one(effect, strength.min(most), SEED + 500 + 10 * k + i))
            .collect()
    };
    let mut orders: Vec<Order> = (0..).zip(&EFFECTS).flat_map(of).collect();
    orders.push(Order::nothing(SEED + 20));
    sound(&orders.par_iter().map(|order| machines::planar_for(order, SECONDS)).collect::<Vec<_>>());
}

fn planted_in_an_arm_under_gravity() {
    mostly_told(table(&[machines::six_axis("", 8)]));
}

fn planted_in_recordings() {
    mostly_told(table(&machines::some_recorded(&machines::data().expect("recordings"))));
}

fn main() -> ExitCode {
    let missing = machines::data().err();
    if let Some(missing) = &missing {
        eprintln!("ignored for want of {missing}: mistakes planted in recordings");
    }
    let trial = |name, check: fn()| {
        Trial::test(name, move || {
            check();
            Ok(())
        })
    };
    let trials = vec![
        trial(
            "property_no_mistake_is_suspected_for_any_effect_at_any_strength",
            every_effect_at_every_strength_is_sound,
        ),
        trial("recover_mistakes_planted_in_an_arm_under_gravity", planted_in_an_arm_under_gravity),
        trial("recover_mistakes_planted_in_recordings", planted_in_recordings).with_ignored_flag(missing.is_some()),
    ];
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}

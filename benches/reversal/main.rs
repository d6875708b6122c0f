//! What shows only where joints turn around, planted in simulated machines and found again in their recordings.
//!
//! The machines, their motions and what is planted are those of the blind sets (`benches/hidden_effects`, `benches/blind`), strength 1.
//! The seeds belong to this test alone: nothing may be tuned to them.

#[path = "../../tests/support/drawn/arm.rs"]
mod arm;
#[path = "../../tests/support/drawn/drawn.rs"]
mod drawn;
#[path = "../../tests/support/drawn/hidden.rs"]
mod hidden;
#[path = "../../tests/support/drawn/machine.rs"]
mod machine;
#[path = "../../tests/support/drawn/motion.rs"]
mod motion;
#[path = "../../tests/support/drawn/record.rs"]
mod record;
#[path = "../../tests/support/rough.rs"]
mod rough;
#[path = "../../tests/support/drawn/sampling.rs"]
mod sampling;
#[path = "../../tests/support/six_joints.rs"]
mod six_joints;
#[path = "../../tests/support/drawn/strengths.rs"]
mod strengths;

mod planted;

use hidden::Order;
use lostmotion::diagnose::{Diagnosis, FoundEffect, Options, diagnose};
use lostmotion::robot::EffectEntry;
use lostmotion::timeseries::TimeSeries;
use rayon::prelude::*;

/// Effects that show where joints turn around only.
const TURNS: [&str; 3] = ["coupling_slip", "dwell_stiction", "presliding"];

/// Diagnoses a set with its last run held out, the gap left to the turns; what was found, and what is in the machine.
fn diagnosed(order: &Order) -> (Diagnosis, Vec<EffectEntry>) {
    diagnosed_later(order, 0.0)
}

/// As [`diagnosed`], with times that begin `epoch` [s] later.
fn diagnosed_later(order: &Order, epoch: f64) -> (Diagnosis, Vec<EffectEntry>) {
    let mut set = planted::set(order);
    set.sessions.iter_mut().flat_map(|session| &mut session.time).for_each(|time| *time += epoch);
    let (hold_out, train): (&TimeSeries, &[TimeSeries]) = set.sessions.split_last().expect("four sessions");
    let options = Options { backlash: false, ..Options::default() };
    let found = diagnose(&set.nominal, train, std::slice::from_ref(hold_out), &options, &mut |_, _| {});
    (found.expect("a diagnosis"), set.entries)
}

/// Names of the effects found, with their joints.
fn names(found: &Diagnosis) -> Vec<(&str, Vec<&str>)> {
    found.effects.iter().map(|one| (one.effect.as_str(), one.joints.iter().map(String::as_str).collect())).collect()
}

/// A parameter as it was found, its standard error, and what was planted.
#[derive(Debug)]
struct Recovered {
    found: f64,
    std_error: f64,
    truth: f64,
}

/// Machines of these seeds with the effect in them: of those in which it and nothing else is named, on a joint that has it, the parameters of
/// each such joint. At least `least` of the machines must be such.
fn recovered<const N: usize>(
    effect: &str,
    seeds: std::ops::Range<u64>,
    least: usize,
    parameters: [&str; N],
) -> Vec<[Recovered; N]> {
    let orders: Vec<Order> = seeds.map(|seed| Order::one(effect, 1.0, seed)).collect();
    let all: Vec<_> = orders.par_iter().map(|order| (order.name(), diagnosed(order))).collect();
    let mut values = Vec::new();
    let mut right = 0;
    for (name, (found, entries)) in &all {
        println!("{name}: {:?}, planted {entries:?}", names(found));
        let planted = |one: &FoundEffect| entries.iter().find(|entry| entry.joint.as_ref() == one.joints.first());
        if found.effects.is_empty() || !found.effects.iter().all(|one| one.effect == effect && planted(one).is_some()) {
            continue;
        }
        right += 1;
        for one in &found.effects {
            let entry = planted(one).expect("on a joint that has it");
            values.push(parameters.map(|name| {
                let measured = &one.parameters[name];
                Recovered { found: measured.value, std_error: measured.std_error, truth: entry.parameters[name] }
            }));
        }
    }
    assert!(right >= least, "{effect} alone is named in {right} of {} machines", all.len());
    values
}

#[test]
fn recover_presliding() {
    for [stiffness] in recovered("presliding", 520_000..520_003, 3, ["stiffness"]) {
        let Recovered { found, std_error, truth } = stiffness;
        // Three standard errors; and a standard error that leaves the size of the stiffness known: hard flanks along a smooth motion are wrong
        // by a fifth of it themselves, which the standard error counts.
        assert!((found - truth).abs() < 3.0 * std_error, "{found} ± {std_error}, true {truth}");
        assert!(std_error < 0.3 * truth, "{found} ± {std_error}, true {truth}");
    }
}

/// These machines have no second encoder, which alone would rule out a softer gear.
#[test]
fn property_presliding_is_told_with_the_soft_gear_that_looks_alike() {
    let (found, _) = diagnosed(&Order::one("presliding", 1.0, 520_000));
    let named: Vec<&FoundEffect> = found.effects.iter().filter(|one| one.effect == "presliding").collect();
    assert!(!named.is_empty(), "{:?}", found.effects);
    for one in named {
        assert!(one.confusable_with.iter().any(|rival| rival == "joint_compliance"), "{one:?}");
    }
}

/// Friction that grows at rest is not named on these machines, whose rests are short beside its time constant: neither is anything else.
#[test]
fn property_dwell_stiction_is_taken_for_nothing_else() {
    let all: Vec<_> =
        (520_100..520_103).into_par_iter().map(|seed| diagnosed(&Order::one("dwell_stiction", 1.0, seed))).collect();
    for (found, entries) in &all {
        let found = names(found);
        assert!(found.iter().all(|(name, _)| *name == "dwell_stiction"), "{found:?}, planted {entries:?}");
    }
}

#[test]
fn recover_coupling_slip() {
    for [time, jump] in recovered("coupling_slip", 520_200..520_203, 2, ["time", "jump"]) {
        // The rotor leaves its course when the ramp of 10 ms has taken up some counts; a controller's interval more or less.
        assert!((time.found - time.truth).abs() < 3.0 * time.std_error && time.std_error < 0.01, "{time:?}");
        // Where in its gap the link stands is not known: a step of 1 to 2 gaps is known to one.
        assert!((jump.found - jump.truth).abs() < 3.0 * jump.std_error && jump.found * jump.truth > 0.0, "{jump:?}");
        assert!((jump.found / jump.truth - 1.0).abs() < 1.0, "{jump:?}");
    }
}

#[test]
fn regress_a_slip_does_not_depend_on_the_zero_of_time() {
    // Seconds since 1970, a power of two: samples stay where they are to a tenth of a microsecond.
    let slips = [0.0, 1_073_741_824.0].map(|epoch| {
        let (found, _) = diagnosed_later(&Order::one("coupling_slip", 1.0, 520_201), epoch);
        let slips = found.effects.iter().filter(|one| one.effect == "coupling_slip");
        slips.map(|one| one.parameters["time"].value).collect::<Vec<f64>>()
    });
    assert!(!slips[0].is_empty(), "the slip is found where time begins with zero");
    // The time of a sample of 1 ms.
    assert!(slips[0].iter().zip(&slips[1]).all(|(one, other)| (one - other).abs() < 1e-3), "{slips:?}");
    assert_eq!(slips[0].len(), slips[1].len());
}

#[test]
fn property_clean_machines_name_nothing() {
    let all: Vec<_> =
        (520_300..520_303).into_par_iter().map(|seed| (seed, diagnosed(&Order::nothing(seed)).0)).collect();
    for (seed, found) in &all {
        assert!(names(found).is_empty(), "seed {seed}: {:?}", found.effects);
    }
}

#[test]
fn property_other_effects_are_not_taken_for_those_of_turns() {
    let others = [("joint_compliance", 520_400), ("position_dependent_friction", 520_401), ("cogging", 520_402)];
    others.into_par_iter().for_each(|(effect, seed)| {
        let (found, entries) = diagnosed(&Order::one(effect, 1.0, seed));
        let found = names(&found);
        assert!(found.iter().all(|(name, _)| !TURNS.contains(name)), "{found:?}, planted {entries:?}");
    });
}

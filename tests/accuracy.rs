//! What the identification reaches on the simulated arm of the paper, its sensors on: pulse-period velocity from 500 pulses per
//! turn in quadrature, 30 mA of current noise, a 12-bit converter. Ten seeds each, other ones than its numbers were chosen on.
//!
//! Figures beside the tolerances: the worst of ten seeds when the test was written. A tolerance is the figure that the project
//! promises; tighter ones (`TIGHT`) hold what was reached, with room for the scatter of other seeds.

use std::path::Path;

use lostmotion::identify::{Identification, JointIdentification, LawKind, Options, Quantity, identify};
use lostmotion::plant::{Engine, Evaluations};
use lostmotion::scenario::{Scenario, simulate};
use rayon::prelude::*;

/// Seeds that nothing was fitted to. They were looked at while the method was made faster; `intervals` below takes others.
const SEEDS: std::ops::Range<u64> = 1001..1011;
/// Intervals that may leave the truth out, of 160: 8 on average at 95 %, and 16 is the promised nine in ten. Those of one run
/// depend on each other, so their number scatters more than a binomial one.
const MISSES: usize = 16;

/// Runs of the staircase with a friction law on rapier, each identified from what the sensors said, and compared with the truth.
fn runs(robot: &str, seeds: std::ops::Range<u64>, evaluations: Evaluations) -> Vec<Identification> {
    runs_with(&[format!("robot=../../robots/scara/{robot}")], seeds, evaluations)
}

/// The same with values of the scenario and its model changed.
fn runs_with(set: &[String], seeds: std::ops::Range<u64>, evaluations: Evaluations) -> Vec<Identification> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/01_identify_scara/scenario.toml");
    let mut scenario = Scenario::load(&path, set).unwrap();
    (scenario.options.engine, scenario.options.evaluations) = (Engine::Rapier, evaluations);
    let options = Options { backlash: false, ..Options::default() };
    seeds
        .into_par_iter()
        .map(|seed| {
            let run = simulate(&scenario, seed, &|_, _| {}).unwrap();
            let mut found = identify(&scenario.model, &run.measured(), &options).unwrap();
            scenario.truth.compare(&mut found);
            found
        })
        .collect()
}

/// Largest error of a coefficient over all runs, joints and directions [%].
fn worst(runs: &[Identification], of: impl Fn(&JointIdentification) -> [f64; 2]) -> f64 {
    runs.iter().flat_map(|run| &run.joints).flat_map(of).fold(0.0, |worst: f64, error| worst.max(error.abs()))
}

/// Intervals that leave the truth out.
fn misses(runs: &[Identification], of: impl Fn(&JointIdentification) -> Vec<Quantity>) -> usize {
    let all = runs.iter().flat_map(|run| &run.joints).flat_map(of);
    all.filter(|quantity| quantity.covers_truth() == Some(false)).count()
}

/// Both joints found in every run, and the law that was injected preferred.
fn assert_law(runs: &[Identification], law: LawKind) {
    for run in runs {
        let names: Vec<&str> = run.joints.iter().map(|joint| joint.joint.as_str()).collect();
        assert_eq!(names, ["joint1", "joint2"]);
        assert!(run.joints.iter().all(|joint| joint.friction.preferred == law));
    }
}

/// `C_ii` of a joint that moves alone is zero: at most two of twenty 95 % intervals may leave it out (three: 1 in 13).
fn assert_no_centrifugal(runs: &[Identification]) {
    assert!(misses(runs, |joint| vec![joint.centrifugal.clone()]) <= 2);
}

#[test]
fn recover_exponential_law_of_both_joints_over_ten_seeds() {
    hold_exponential_law(&runs("model.toml", SEEDS, Evaluations::AsNeeded));
}

#[test]
#[ignore = "long: .ci/run carries it out"]
fn recover_exponential_law_with_rapier_asked_every_millisecond() {
    hold_exponential_law(&runs("model.toml", SEEDS, Evaluations::EveryInterval));
}

fn hold_exponential_law(runs: &[Identification]) {
    assert_law(runs, LawKind::Exponential);
    assert_no_centrifugal(runs);
    let error = |of: fn(&lostmotion::identify::ExponentialEstimate) -> f64| {
        worst(runs, |joint| joint.friction.exponential.each().map(of))
    };
    let curve = error(|law| law.curve_error_percent.unwrap());
    let coulomb = error(|law| law.coulomb.error_percent.unwrap());
    let viscous = error(|law| law.viscous.error_percent.unwrap());
    let breakaway = error(|law| law.breakaway.error_percent.unwrap());
    let stribeck = error(|law| law.stribeck_velocity.error_percent.unwrap());
    let missed = misses(runs, |joint| {
        let laws = joint.friction.exponential.each();
        laws.iter()
            .flat_map(|law| [&law.coulomb, &law.breakaway, &law.stribeck_velocity, &law.viscous])
            .cloned()
            .collect()
    });
    println!(
        "worst of ten seeds [%]: curve {curve:.3} F_C {coulomb:.3} F_V {viscous:.3} F_S {breakaway:.3} v_S {stribeck:.3}; \
         {missed} of 160 intervals miss"
    );
    assert!(curve <= 0.10, "friction curve, promised 0.5 %: {curve} %");
    assert!(coulomb <= 1.0, "F_C, promised 2 %: {coulomb} %");
    assert!(viscous <= 2.0, "F_V, promised 2 %: {viscous} %");
    assert!(breakaway <= 0.6, "F_S, promised 5 %: {breakaway} %");
    assert!(stribeck <= 2.5, "v_S, promised 5 %: {stribeck} %");
    assert!(missed <= MISSES, "{missed} of 160 intervals leave the truth out");
}

/// The wind-up of gears ten times softer than the paper's: 1.5 and 1.5 mrad under breakaway friction, more while the arm swings.
#[test]
fn recover_friction_behind_soft_gears() {
    let soft =
        [("joint1", 300), ("joint2", 200)].map(|(joint, k)| format!("model.joints.{joint}.gear_stiffness={k}.0"));
    for run in &runs_with(&soft, 1001..1003, Evaluations::AsNeeded) {
        let of_arm = run.joints[0].friction.exponential.each().map(|law| law.viscous.error_percent.unwrap().abs());
        // RMS over six seeds 1.4 %; 18 % where rotor and link are taken for one mass that the encoder shows.
        assert!(of_arm.iter().all(|error| *error < 6.0), "{of_arm:?}");
    }
}

#[test]
#[ignore = "long: .ci/run carries it out"]
fn recover_two_lines_of_both_joints_over_ten_seeds() {
    let runs = runs("model_two_lines.toml", SEEDS, Evaluations::AsNeeded);
    assert_law(&runs, LawKind::TwoLines);
    assert_no_centrifugal(&runs);
    let error =
        |of: fn(&lostmotion::identify::LinesEstimate) -> f64| worst(&runs, |joint| joint.friction.lines.each().map(of));
    let a1 = error(|law| law.a1.error_percent.unwrap());
    let b1 = error(|law| law.b1.error_percent.unwrap());
    let a2 = error(|law| law.a2.error_percent.unwrap());
    let b2 = error(|law| law.b2.error_percent.unwrap());
    let missed = misses(&runs, |joint| {
        joint.friction.lines.each().iter().flat_map(|law| [&law.a1, &law.b1, &law.a2, &law.b2]).cloned().collect()
    });
    println!("worst of ten seeds [%]: a1 {a1:.3} b1 {b1:.3} a2 {a2:.3} b2 {b2:.3}; {missed} of 160 intervals miss");
    assert!(a1 <= 0.5, "a1, promised 1 %: {a1} %");
    assert!(b1 <= 2.5, "b1, promised 5 %: {b1} %");
    assert!(a2 <= 0.5, "a2, promised 1 %: {a2} %");
    assert!(b2 <= 1.5, "b2, promised 5 %: {b2} %");
    assert!(missed <= MISSES, "{missed} of 160 intervals leave the truth out");
}

/// One row of the table: what is estimated, in which direction, and how often its interval held the truth.
fn row(runs: &[Identification], joint: usize, name: &str, of: impl Fn(&JointIdentification) -> Quantity) {
    let all: Vec<Quantity> = runs.iter().map(|run| of(&run.joints[joint])).collect();
    let n = all.len() as f64;
    let percent: Vec<f64> = all.iter().map(|one| one.error_percent.unwrap_or(100.0 * one.value)).collect();
    let bias = percent.iter().sum::<f64>() / n;
    let scatter = (percent.iter().map(|error| (error - bias).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let worst = percent.iter().fold(0.0_f64, |worst, error| worst.max(error.abs()));
    let held = all.iter().filter(|one| one.covers_truth() == Some(true)).count();
    let stated = |one: &Quantity| Some(((one.value - one.truth?) / one.std_error).powi(2));
    let of_stated = (all.iter().filter_map(stated).sum::<f64>() / n).sqrt();
    println!(
        "| joint{} | {name} | {bias:.3} | {scatter:.3} | {worst:.3} | {of_stated:.2} | {:.1} |",
        joint + 1,
        100.0 * held as f64 / n
    );
}

/// The table of the scenario's README: `LOSTMOTION_COVERAGE=100 cargo test --release --test accuracy intervals -- --ignored --nocapture`.
#[test]
#[ignore = "prints a table of as many runs as LOSTMOTION_COVERAGE says"]
fn property_intervals_hold_the_truth_in_many_runs() {
    let count: u64 = std::env::var("LOSTMOTION_COVERAGE").map_or(100, |count| count.parse().expect("a number of runs"));
    let seeds = 2001..2001 + count;
    println!(
        "| joint | coefficient | bias % | scatter % | worst % | RMS error per standard error | interval held % |\n|{}",
        "---|".repeat(7)
    );
    let exponential = runs("model.toml", seeds.clone(), Evaluations::AsNeeded);
    let lines = runs("model_two_lines.toml", seeds, Evaluations::AsNeeded);
    for joint in 0..2 {
        for (k, sign) in ["+", "-"].into_iter().enumerate() {
            let law = move |one: &JointIdentification| one.friction.exponential.each()[k].clone();
            row(&exponential, joint, &format!("F_C{sign}"), move |one| law(one).coulomb);
            row(&exponential, joint, &format!("F_S{sign}"), move |one| law(one).breakaway);
            row(&exponential, joint, &format!("v_S{sign}"), move |one| law(one).stribeck_velocity);
            row(&exponential, joint, &format!("F_V{sign}"), move |one| law(one).viscous);
            let law = move |one: &JointIdentification| one.friction.lines.each()[k].clone();
            row(&lines, joint, &format!("a1{sign}"), move |one| law(one).a1);
            row(&lines, joint, &format!("b1{sign}"), move |one| law(one).b1);
            row(&lines, joint, &format!("a2{sign}"), move |one| law(one).a2);
            row(&lines, joint, &format!("b2{sign}"), move |one| law(one).b2);
        }
        row(&exponential, joint, "C_ii (1e-2 N·m·s²/rad²)", |one| one.centrifugal.clone());
    }
    let all = misses(&exponential, |joint| {
        let laws = joint.friction.exponential.each();
        laws.iter()
            .flat_map(|law| [&law.coulomb, &law.breakaway, &law.stribeck_velocity, &law.viscous])
            .cloned()
            .collect()
    });
    assert!(all as f64 <= 0.1 * 16.0 * count as f64, "{all} intervals of equation 6 leave the truth out");
}

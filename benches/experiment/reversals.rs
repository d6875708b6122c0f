//! What the error of single reversals is made of: `cargo bench --bench experiment -- reversals [--runs N] [--budgets …]`.
//!
//! Per joint and experiment: bias, scatter and RMS of the mean gap, and the scatter of single reversals with the part of its variance that is a
//! function of where in a count the rotor turned, all in counts. Seeds from 3021 on: constants of the plan and of the estimator may be chosen by them.

use lostmotion::identify::backlash::{Reversal, find_reversals};
use lostmotion::identify::{Options, identify};
use lostmotion::scenario::{Run, Scenario, simulate};
use lostmotion::timeseries::{Channel, TimeSeries};
use rayon::prelude::*;

/// First seed: those by which constants are chosen.
const SEEDS: u64 = 3021;
/// Parts into which a count is divided.
const PARTS: usize = 8;

/// A single reversal, in counts: error of its gap, and where in a count the rotor turned, 0 to 1.
#[derive(Clone, Copy)]
struct Single {
    error: f64,
    phase: f64,
}

/// One run: error of the mean gap, its standard error, single reversals and how many were left out.
struct One {
    error: f64,
    std_error: f64,
    singles: Vec<Single>,
    left_out: usize,
}

/// Where in a count [1] the rotor was farthest, in the direction in which it came.
fn phase(series: &TimeSeries, joint: &str, reversal: &Reversal, count: f64) -> Option<f64> {
    let recorded = series.joint(joint)?;
    let [position, truth] = [recorded.get(Channel::Position)?, recorded.get(Channel::TrueMotorPosition)?];
    let sign = reversal.sign();
    let turn = (reversal.start..reversal.end).min_by(|&a, &b| (sign * truth[a]).total_cmp(&(sign * truth[b])))?;
    Some((sign * (truth[turn] - position[turn]) / count + 0.5).rem_euclid(1.0))
}

fn one(scenario: &Scenario, run: &Run, joint: &str) -> Option<One> {
    let found = identify(&scenario.model, &run.measured(), &Options::default()).ok()?;
    let gap = &found.joint(joint)?.backlash.as_ref()?.best;
    let truth = scenario.truth.backlash(joint)?;
    let count = scenario.model.joints.iter().find(|one| one.name == joint)?.encoder_step();
    let mut turns = run.sessions.iter().filter(|session| session.name.starts_with(joint)).flat_map(|session| {
        let position = session.joint(joint).and_then(|one| one.get(Channel::Position)).unwrap_or_default();
        find_reversals(position, count).into_iter().map(move |turn| (session, turn))
    });
    // Values are in the order of recordings and of time.
    let singles = gap.values.iter().filter_map(|value| {
        let (session, turn) = turns.find(|(session, turn)| session.time[turn.turn] == value.time)?;
        Some(Single { error: (value.gap - truth) / count, phase: phase(session, joint, &turn, count)? })
    });
    Some(One {
        error: (gap.mean.value - truth) / count,
        std_error: gap.mean.std_error / count,
        singles: singles.collect(),
        left_out: gap.left_out.len(),
    })
}

fn mean_and_deviation(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    [mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()]
}

/// Part of the variance of single errors that is a function of the phase.
fn by_phase(singles: &[Single]) -> f64 {
    let errors = |part: Option<usize>| -> Vec<f64> {
        let inside = |one: &&Single| part.is_none_or(|part| (one.phase * PARTS as f64) as usize == part);
        singles.iter().filter(inside).map(|one| one.error).collect()
    };
    let within: f64 = (0..PARTS)
        .map(|part| errors(Some(part)))
        .filter(|errors| !errors.is_empty())
        .map(|errors| {
            let [_, deviation] = mean_and_deviation(&errors);
            errors.len() as f64 * deviation * deviation
        })
        .sum();
    let [_, whole] = mean_and_deviation(&errors(None));
    1.0 - within / (singles.len() as f64 * whole * whole)
}

/// Prints the rows of an experiment.
pub fn rows(name: &str, scenario: &Scenario, number: u64, joints: [&str; 2]) {
    let all: Vec<Option<[Option<One>; 2]>> = (SEEDS..SEEDS + number)
        .into_par_iter()
        .map(|seed| {
            let run = simulate(scenario, seed, &|_, _| {}).ok()?;
            Some(joints.map(|joint| one(scenario, &run, joint)))
        })
        .collect();
    for (k, joint) in joints.iter().enumerate() {
        let runs: Vec<&One> = all.iter().flatten().filter_map(|run| run[k].as_ref()).collect();
        let errors: Vec<f64> = runs.iter().map(|one| one.error).collect();
        let singles: Vec<Single> = runs.iter().flat_map(|one| one.singles.iter().copied()).collect();
        let [bias, scatter] = mean_and_deviation(&errors);
        let [_, single] = mean_and_deviation(&singles.iter().map(|one| one.error).collect::<Vec<f64>>());
        let mean = |of: &dyn Fn(&One) -> f64| runs.iter().map(|one| of(one)).sum::<f64>() / runs.len() as f64;
        println!(
            "| {joint} | {name} | {} | {:.1} | {:.1} | {bias:.3} | {scatter:.3} | {:.3} | {:.3} | {single:.2} | {:.2} |",
            runs.len(),
            mean(&|one| one.singles.len() as f64),
            mean(&|one| one.left_out as f64),
            bias.hypot(scatter),
            mean(&|one| one.std_error),
            by_phase(&singles)
        );
    }
}

/// Prints the head of the table.
pub fn head() {
    println!(
        "| joint | experiment | found | reversals | left out | bias | scatter | RMS | own error | single | by phase |"
    );
    println!("|{}", "---|".repeat(11));
}

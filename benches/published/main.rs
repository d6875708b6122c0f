//! What the paper's own estimators make of its experiment, beside those of the program: the tables of `docs/published.md`.
//!
//! `cargo bench --bench published -- [--seeds N]`
//!
//! Ten seeds (6001 to 6010) of the staircase of scenario 01, with friction of equation 6 and with friction of two lines, on 500 pulses a turn
//! counted once or in quadrature, with a signed and with an absolute current, and with ideal sensors; two rows with steps of 12 s.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lostmotion::gearhead::FrictionLaw;
use lostmotion::identify::backlash::EstimatorResult;
use lostmotion::identify::published::{AveragePoint, friction};
use lostmotion::identify::{JointIdentification, LawKind, LinesEstimate, Options, PerDirection, Quantity, identify};
use lostmotion::plant::Engine;
use lostmotion::scenario::{Scenario, simulate};
use lostmotion::units::{DEG, JointKind};
use rayon::prelude::*;

/// First seed: those of this bench.
const SEEDS: u64 = 6001;
/// Joints that the staircase moves.
const JOINTS: [&str; 2] = ["joint1", "joint2"];
/// Friction that is injected.
const MACHINES: [(&str, &str); 2] = [("equation 6", "model.toml"), ("two lines", "model_two_lines.toml")];

/// Steady times of the scenario's steps, and of long ones [s]: these are closer to the paper's strokes over the whole range.
const STEADY: [[&str; 2]; 2] =
    [["steady_time = 1.2", "steady_time = 12.0"], ["steady_time = 0.8", "steady_time = 12.0"]];

/// The sensors and steps of a row.
struct Sensors {
    name: &'static str,
    set: Vec<String>,
    long: bool,
}

fn sensors() -> Vec<Sensors> {
    let ideal = vec!["sensors=ideal".to_owned()];
    let mut all = vec![
        Sensors { name: "ideal, 12 s a step", set: ideal.clone(), long: true },
        Sensors { name: "×4, signed, 12 s a step", set: Vec::new(), long: true },
        Sensors { name: "ideal", set: ideal, long: false },
    ];
    for (name, counts, sensing) in [
        ("×4, signed", 2000, "signed"),
        ("×4, absolute", 2000, "absolute"),
        ("×1, signed", 500, "signed"),
        ("×1, absolute", 500, "absolute"),
    ] {
        let of = |joint: &&str| {
            let at = format!("model.joints.{joint}");
            [format!("{at}.encoder.counts_per_turn={counts}"), format!("{at}.current_sensor.sensing={sensing}")]
        };
        all.push(Sensors { name, set: JOINTS.iter().flat_map(of).collect(), long: false });
    }
    all
}

/// Errors of one joint in one run [%]; NaN where there is no estimate.
struct Errors {
    /// RMS error of the curve of the published two lines, and of the law that the program prefers: worse direction.
    curve: [f64; 2],
    /// Of a1, b1, a2, b2 as published and of the program: worse direction; where the truth is two lines.
    coefficients: [[f64; 4]; 2],
    /// `C_ii` as published over its standard error.
    centrifugal: f64,
    /// Of the gap: literal, filtered, and the program's.
    gap: [f64; 3],
    /// Paper's mean deviation of the single gaps: literal and filtered.
    deviation: [f64; 2],
}

fn worse(errors: [Option<f64>; 2]) -> f64 {
    errors.into_iter().map(|one| one.map_or(f64::NAN, f64::abs)).fold(0.0, |a, b| if a > b { a } else { b })
}

fn of_lines(lines: &PerDirection<LinesEstimate>) -> [f64; 4] {
    let of = |one: fn(&LinesEstimate) -> &Quantity| worse(lines.each().map(|law| one(law).error_percent));
    [of(|law| &law.a1), of(|law| &law.b1), of(|law| &law.a2), of(|law| &law.b2)]
}

fn errors(found: &JointIdentification) -> Errors {
    let published = found.published.friction.as_ref();
    let own = match found.friction.preferred {
        LawKind::TwoLines => worse(found.friction.lines.each().map(|law| law.curve_error_percent)),
        LawKind::Exponential => worse(found.friction.exponential.each().map(|law| law.curve_error_percent)),
    };
    let gap = |one: Option<&EstimatorResult>| one.and_then(|gap| gap.mean.error_percent).unwrap_or(f64::NAN);
    let deviation = |one: Option<&EstimatorResult>| one.map_or(f64::NAN, |gap| gap.mean_deviation_percent);
    let [literal, filtered] = [&found.published.backlash, &found.published.backlash_filtered].map(Option::as_ref);
    Errors {
        curve: [published.map_or(f64::NAN, |one| worse(one.lines.each().map(|law| law.curve_error_percent))), own],
        coefficients: [published.map_or([f64::NAN; 4], |one| of_lines(&one.lines)), of_lines(&found.friction.lines)],
        centrifugal: published.map_or(f64::NAN, |one| one.centrifugal.value / one.centrifugal.std_error),
        gap: [gap(literal), gap(filtered), gap(found.backlash.as_ref().map(|one| &one.best))],
        deviation: [deviation(literal), deviation(filtered)],
    }
}

fn scenario_01() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/01_identify_scara/scenario.toml")
}

/// The errors of every run that was identified, one list per joint.
fn runs(machine: &str, sensors: &Sensors, seeds: u64) -> Result<[Vec<Errors>; 2], String> {
    let path = scenario_01();
    let set = [&[format!("robot=../../robots/scara/{machine}")], &sensors.set[..]].concat();
    let mut text = std::fs::read_to_string(&path).map_err(|why| why.to_string())?;
    for [short, long] in STEADY.into_iter().filter(|_| sensors.long) {
        text = text.replace(short, long);
    }
    let mut scenario = Scenario::from_text(&text, &path, &set).map_err(|why| why.to_string())?;
    scenario.options.engine = Engine::Reduced;
    let found: Vec<_> = (SEEDS..SEEDS + seeds)
        .into_par_iter()
        .filter_map(|seed| {
            let run = simulate(&scenario, seed, &|_, _| {}).ok()?;
            let mut found = identify(&scenario.model, &run.measured(), &Options::default()).ok()?;
            scenario.truth.compare(&mut found);
            Some(found)
        })
        .collect();
    Ok(JOINTS.map(|joint| found.iter().filter_map(|one| one.joint(joint)).map(errors).collect()))
}

/// Mean of the values that exist, and the largest of them, `mean (worst)`.
fn shown(values: impl Iterator<Item = f64>) -> String {
    let found: Vec<f64> = values.filter(|one| one.is_finite()).collect();
    if found.is_empty() {
        return "–".to_owned();
    }
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    let worst = found.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(f64::NAN);
    format!("{} ({})", figure(mean), figure(worst))
}

/// Two significant digits.
fn figure(value: f64) -> String {
    match value.abs() {
        size if size >= 9.95 => format!("{value:.0}"),
        size if size >= 0.995 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

fn friction_row(name: &str, joint: &str, runs: &[Errors], seeds: u64, lines: bool) {
    let pair =
        |k: usize| format!("{} | {}", each(runs, |e| e.coefficients[0][k]), each(runs, |e| e.coefficients[1][k]));
    let curves = format!("{} | {}", each(runs, |e| e.curve[0]), each(runs, |e| e.curve[1]));
    let coefficients = if lines { (0..4).map(|k| format!(" {} |", pair(k))).collect() } else { String::new() };
    let beyond = runs.iter().filter(|e| e.centrifugal.abs() > 2.0).count();
    let seen = runs.iter().filter(|e| e.curve[0].is_finite()).count();
    println!("| {name} | {joint} | {seen} of {seeds} | {curves} |{coefficients} {beyond} of {seen} |");
}

fn each(runs: &[Errors], of: impl Fn(&Errors) -> f64) -> String {
    shown(runs.iter().map(of))
}

fn gap_row(name: &str, joint: &str, runs: &[Errors]) {
    let of = |k: usize| each(runs, |e| e.gap[k]);
    let deviation = |k: usize| each(runs, |e| e.deviation[k]);
    println!("| {name} | {joint} | {} | {} | {} | {} | {} |", of(0), deviation(0), of(1), deviation(1), of(2));
}

/// RMS error [%] of the published lines through points on the injected law itself, 0.5 to 10 deg/s: the worse direction.
fn without_any_error(law: &FrictionLaw) -> f64 {
    let speeds = (1..=20).flat_map(|k| [0.5 * DEG * f64::from(k), -0.5 * DEG * f64::from(k)]);
    let points: Vec<_> = speeds.map(|v| AveragePoint { velocity: v, friction: law.kinetic(v) }).collect();
    let Some(found) = friction(JointKind::Revolute, &points) else { return f64::NAN };
    let lines = FrictionLaw::TwoLines(found.lines.each().map(LinesEstimate::law));
    let worse = [1.0, -1.0].map(|sign: f64| {
        let along = (0..200).map(|k| sign * DEG * (0.5 + 9.5 * f64::from(k) / 199.0));
        let error: f64 = along.clone().map(|v| (lines.kinetic(v) - law.kinetic(v)).powi(2)).sum();
        100.0 * (error / along.map(|v| law.kinetic(v).powi(2)).sum::<f64>()).sqrt()
    });
    worse[0].max(worse[1])
}

fn tables(seeds: u64) -> Result<(), String> {
    for (truth, machine) in MACHINES {
        let set = [format!("robot=../../robots/scara/{machine}")];
        let truth_of_all = Scenario::load(&scenario_01(), &set).map_err(|why| why.to_string())?.truth;
        let laws = JOINTS.iter().filter_map(|joint| truth_of_all.friction(joint));
        let errors: Vec<String> = laws.map(|law| figure(without_any_error(&law))).collect();
        println!("Truth {truth}, two lines through points on the law itself: curve {} % off", errors.join(" and "));
    }
    for (truth, machine) in MACHINES {
        let lines = machine != MACHINES[0].1;
        let all = sensors().into_iter().map(|one| Ok((one.name, runs(machine, &one, seeds)?)));
        let all = all.collect::<Result<Vec<_>, String>>()?;
        let coefficients = if lines { " a1 | ours | b1 | ours | a2 | ours | b2 | ours |" } else { "" };
        let columns = 6 + if lines { 8 } else { 0 };
        println!("\nFriction, truth {truth}; error in per cent, mean (worst) over the seeds\n");
        println!(
            "| sensors | joint | found | curve | ours |{coefficients} C_ii beyond 2σ |\n|{}",
            "---|".repeat(columns)
        );
        for (name, runs) in &all {
            JOINTS.iter().zip(runs).for_each(|(joint, runs)| friction_row(name, joint, runs, seeds, lines));
        }
        println!("\nGap, friction {truth}; error in per cent, mean (worst) over the seeds\n");
        println!("| sensors | joint | equation 15 | deviation | filtered | deviation | ours |\n|{}", "---|".repeat(7));
        for (name, runs) in &all {
            JOINTS.iter().zip(runs).for_each(|(joint, runs)| gap_row(name, joint, runs));
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let seeds = match &words[..] {
        [] => Some(10),
        [flag, count] if flag == "--seeds" => count.parse().ok().filter(|count| *count > 0),
        _ => None,
    };
    let Some(seeds) = seeds else {
        eprintln!("error: expected [--seeds N], N > 0");
        return ExitCode::from(2);
    };
    match tables(seeds) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::from(2)
        }
    }
}

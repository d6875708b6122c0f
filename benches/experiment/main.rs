//! What a planned experiment measures, and what the paper's uniform staircase of the same length does: the tables of `docs/experiment.md`.
//!
//! `cargo bench --bench experiment -- [table|reversals] [--runs N] [--budgets 60,120,240] [--question backlash]`
//!
//! The arm of scenario 01, joints 1 and 2, with its encoders, current sensors and controller. Every budget is planned for friction, for
//! the gap and for both, and given to the staircase of the scenario with as many of its twenty speeds as can be steady for 0.8 s. All
//! experiments are simulated with the same seeds, from 8001 on, and identified. Intervals of ratios: 95 %, bootstrap over the runs.

mod reversals;
#[path = "../../tests/support/uniform.rs"]
mod uniform;

use std::path::Path;
use std::process::ExitCode;

use lostmotion::gearhead::FrictionLaw;
use lostmotion::identify::{ExponentialEstimate, LawKind, Options, identify};
use lostmotion::plant::Engine;
use lostmotion::robot::Model;
use lostmotion::scenario::{Measurands, Scenario, measurement, simulate};
use lostmotion::units::DEG;
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// First seed: those of this bench.
const SEEDS: u64 = 8001;
/// Joints that are measured.
const JOINTS: [&str; 2] = ["joint1", "joint2"];
/// Row, question, and whether the friction is known when it is planned; the staircase is the first row.
const QUESTIONS: [(&str, &str, bool); 4] = [
    ("friction", "friction", true),
    ("backlash", "backlash", true),
    ("friction,backlash", "friction,backlash", true),
    ("friction, unknown before", "friction", false),
];
/// Quantities of the table.
const QUANTITIES: [&str; 6] = ["F_C", "F_S", "v_S", "F_V", "curve", "gap"];
/// Resamplings of a ratio's interval.
const RESAMPLINGS: usize = 4000;

/// Mean squared relative errors of one joint in one run [%²]; NaN where there is no estimate.
type Squares = [f64; 6];

/// Runs of an experiment: one list per joint, `None` where a joint was not identified.
type Runs = [Vec<Option<Squares>>; 2];

fn squares(run: &lostmotion::identify::Identification, scenario: &Scenario, joint: &str) -> Option<Squares> {
    let found = run.joint(joint)?;
    let Some(FrictionLaw::Exponential(truth)) = scenario.truth.friction(joint) else { return None };
    let gap = scenario.truth.backlash(joint)?;
    let laws = found.friction.exponential.each().map(ExponentialEstimate::law);
    let error = |value: f64, truth: f64| (100.0 * (value / truth - 1.0)).powi(2);
    let both = |of: fn(&lostmotion::gearhead::Exponential) -> f64| {
        0.5 * (error(of(&laws[0]), of(&truth[0])) + error(of(&laws[1]), of(&truth[1])))
    };
    let own = found.friction.law(LawKind::Exponential);
    let law = FrictionLaw::Exponential(truth);
    let speeds = (0..200).flat_map(|k| [1.0, -1.0].map(|sign| sign * DEG * (0.5 + 9.5 * f64::from(k) / 199.0)));
    let (off, size) = speeds.fold((0.0, 0.0), |(off, size), v| {
        (off + (own.kinetic(v) - law.kinetic(v)).powi(2), size + law.kinetic(v).powi(2))
    });
    Some([
        both(|law| law.coulomb),
        both(|law| law.breakaway),
        both(|law| law.stribeck_velocity),
        both(|law| law.viscous),
        1e4 * off / size,
        found.backlash.as_ref().map_or(f64::NAN, |one| error(one.best.mean.value, gap)),
    ])
}

fn runs(scenario: &Scenario, number: u64) -> Runs {
    let found: Vec<[Option<Squares>; 2]> = (SEEDS..SEEDS + number)
        .into_par_iter()
        .map(|seed| {
            let recorded = simulate(scenario, seed, &|_, _| {}).map(|run| run.measured());
            let found = recorded.and_then(|recorded| identify(&scenario.model, &recorded, &Options::default()));
            JOINTS.map(|joint| squares(found.as_ref().ok()?, scenario, joint))
        })
        .collect();
    [0, 1].map(|joint| found.iter().map(|run| run[joint]).collect())
}

/// The scenario with the sessions of a plan, and its controller; the model that it is planned with knows the friction, or does not.
fn planned(scenario: &Scenario, question: &str, known: bool, budget: f64) -> Result<Scenario, String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/scara/model.toml");
    let with_friction = Model::load(&file).map_err(|why| why.to_string())?;
    // Procedures of a scenario get its model without what they identify.
    let model = if known { &with_friction } else { &scenario.model };
    let asked = Measurands::parse(&format!("{question} of {}", JOINTS.join(",")), model);
    let asked = asked.map_err(|why| why.to_string())?.ok_or("a question about friction or backlash")?;
    let plan = measurement(model, &asked, budget).map_err(|why| why.to_string())?;
    let read = Scenario::of_model(&plan.scenario, Path::new("scenario.toml"), model).map_err(|why| why.to_string())?;
    // A machine whose friction is not known has a controller all the same: the careful one of the plan would lag by half a radian.
    let controller = if known { read.controller } else { scenario.controller.clone() };
    Ok(Scenario { sessions: read.sessions, controller, ..scenario.clone() })
}

/// Root mean square of a quantity over the runs that have it.
fn rms(runs: &[Option<Squares>], quantity: usize) -> f64 {
    let values: Vec<f64> = runs.iter().flatten().map(|one| one[quantity]).filter(|one| one.is_finite()).collect();
    (values.iter().sum::<f64>() / values.len() as f64).sqrt()
}

/// Ratio of the first's error to the second's, with its interval.
fn ratio(first: &[Option<Squares>], second: &[Option<Squares>], quantity: usize) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let drawn = |runs: &[Option<Squares>], rng: &mut ChaCha8Rng| -> f64 {
        let again: Vec<Option<Squares>> = runs.iter().map(|_| runs[rng.random_range(0..runs.len())]).collect();
        rms(&again, quantity)
    };
    let mut ratios: Vec<f64> = (0..RESAMPLINGS)
        .map(|_| drawn(first, &mut rng) / drawn(second, &mut rng))
        .filter(|one| one.is_finite())
        .collect();
    ratios.sort_by(f64::total_cmp);
    let whole = rms(first, quantity) / rms(second, quantity);
    if ratios.is_empty() || !whole.is_finite() {
        return "–".to_owned();
    }
    let at = |part: f64| ratios[(part * (ratios.len() - 1) as f64) as usize];
    format!("{whole:.1} ({:.1} … {:.1})", at(0.025), at(0.975))
}

/// What is asked for.
struct Asked {
    /// Runs of an experiment.
    number: u64,
    /// [s]
    budgets: Vec<f64>,
    /// Only the plans whose question contains this; otherwise all.
    question: Option<String>,
}

impl Asked {
    /// Plans for the questions with a budget: row and scenario.
    fn plans(&self, base: &Scenario, budget: f64) -> Vec<(&'static str, Result<Scenario, String>)> {
        let asked = |question: &str| self.question.as_deref().is_none_or(|part| question.contains(part));
        let plan = |(name, question, known)| {
            let scenario = planned(base, question, known, budget).map(|mut scenario| {
                scenario.options.engine = Engine::Reduced;
                scenario
            });
            (name, scenario)
        };
        QUESTIONS.into_iter().filter(|(_, question, _)| asked(question)).map(plan).collect()
    }
}

fn table(asked: &Asked) -> Result<(), String> {
    let number = asked.number;
    let base = uniform::scenario_01()?;
    for &budget in &asked.budgets {
        let staircase = uniform::staircase(budget)?;
        let mut all = vec![("uniform staircase", Some((staircase.seconds, runs(&staircase.scenario, number))))];
        for (name, plan) in asked.plans(&base, budget) {
            match plan {
                Ok(scenario) => {
                    let seconds = scenario.sessions.iter().map(|session| session.duration).sum();
                    all.push((name, Some((seconds, runs(&scenario, number)))));
                }
                Err(why) => {
                    eprintln!("{budget} s, {name}: {why}");
                    all.push((name, None));
                }
            }
        }
        println!("\n{budget} s, staircase of {} speeds; RMS error in per cent, {number} runs\n", staircase.speeds);
        println!("| joint | experiment | length | found | {} |\n|{}", QUANTITIES.join(" | "), "---|".repeat(10));
        for (k, joint) in JOINTS.iter().enumerate() {
            for (name, runs) in &all {
                let Some((seconds, runs)) = runs else { continue };
                let found = runs[k].iter().flatten().count();
                let cells: Vec<String> = (0..6).map(|quantity| format!("{:.2}", rms(&runs[k], quantity))).collect();
                println!("| {joint} | {name} | {seconds:.0} s | {found} | {} |", cells.join(" | ").replace("NaN", "–"));
            }
        }
        println!("\nError of the staircase per error of the plan\n");
        println!("| joint | experiment | {} |\n|{}", QUANTITIES.join(" | "), "---|".repeat(8));
        for (k, joint) in JOINTS.iter().enumerate() {
            let Some((_, first)) = &all[0].1 else { continue };
            for (name, runs) in &all[1..] {
                let Some((_, runs)) = runs else { continue };
                let cells: Vec<String> = (0..6).map(|quantity| ratio(&first[k], &runs[k], quantity)).collect();
                println!("| {joint} | {name} | {} |", cells.join(" | "));
            }
        }
    }
    Ok(())
}

/// The table of single reversals: the staircase and the plans that ask for the gap.
fn single_reversals(asked: &Asked) -> Result<(), String> {
    let base = uniform::scenario_01()?;
    for &budget in &asked.budgets {
        println!("\n{budget} s, {} runs, in counts\n", asked.number);
        reversals::head();
        reversals::rows("uniform staircase", &uniform::staircase(budget)?.scenario, asked.number, JOINTS);
        for (name, plan) in asked.plans(&base, budget).into_iter().filter(|(name, _)| name.contains("backlash")) {
            reversals::rows(name, &plan?, asked.number, JOINTS);
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let mut words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let singles = words.first().is_some_and(|word| word == "reversals");
    if words.first().is_some_and(|word| word == "table" || word == "reversals") {
        words.remove(0);
    }
    let (mut number, mut budgets, mut question) = (Some(4), Some(vec![240.0]), None);
    for pair in words.chunks(2) {
        match pair {
            [flag, value] if flag == "--runs" => number = value.parse().ok().filter(|number| *number > 0),
            [flag, value] if flag == "--budgets" => {
                budgets = value.split(',').map(|one| one.parse().ok().filter(|one| *one > 0.0)).collect();
            }
            [flag, value] if flag == "--question" && QUESTIONS.iter().any(|(_, one, _)| one.contains(value)) => {
                question = Some(value.clone());
            }
            _ => number = None,
        }
    }
    let (Some(number), Some(budgets)) = (number, budgets) else {
        eprintln!("error: expected [table|reversals] [--runs N] [--budgets SECONDS,…], all > 0 [--question QUESTION]");
        return ExitCode::from(2);
    };
    let asked = Asked { number, budgets, question };
    match if singles { single_reversals(&asked) } else { table(&asked) } {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::from(2)
        }
    }
}

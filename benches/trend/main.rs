//! How often a trend is named that is there, and how often one that is not: the tables of `docs/trend.md`.
//!
//! `cargo bench --bench trend -- [--repeats N] [--weeks N] [--simulated N]`
//!
//! 1. `--repeats` runs of scenario 01 on one machine show the errors of a result and the standard errors stated.
//! 2. `--weeks` weeks of each kind are **drawn**: each result takes all its errors from one of these runs, so with their covariance and
//!    their outliers, about values that drift.
//! 3. Eight times as many weeks without drift are drawn of parameters whose scatter is not that stated, of some or of all.
//! 4. `--simulated` weeks with drift and as many without are **simulated**, run by run.

#[path = "../../tests/support/weeks.rs"]
mod weeks;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lostmotion::identify::trend::{History, Repeat, Trend, trends};
use lostmotion::report::results::{histories, symbol};
use rand::{Rng, RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use weeks::{Drift, simulated};

/// First seeds: of the repeats, of the drawn weeks, of the simulated weeks.
const SEEDS: [u64; 3] = [7001, 1, 8001];
/// Probability that a week without drift is called a change.
const LEVEL: f64 = 0.01;
/// Results in a week.
const RESULTS: [usize; 2] = [7, 14];
/// Drift of a week: 10 % of friction, 20 % of the gap.
const FRICTION: f64 = 0.1;
const GAP: f64 = 0.2;

/// Share by which a parameter grows over a week; the parameters that drift.
type Drifting = fn(&History) -> f64;
const KINDS: [(&str, Drifting); 6] = [
    ("no drift", |_| 0.0),
    ("gap of joint1 + 20 %", |one| if is(one, "joint1", "backlash") { GAP } else { 0.0 }),
    ("gap of joint2 + 20 %", |one| if is(one, "joint2", "backlash") { GAP } else { 0.0 }),
    ("F_C of both + 10 %", |one| if is(one, "", "coulomb") { FRICTION } else { 0.0 }),
    ("F_V of both + 10 %", |one| if is(one, "", "viscous") { FRICTION } else { 0.0 }),
    ("friction of both + 10 %, gaps + 20 %", all),
];

fn is(one: &History, joint: &str, parameter: &str) -> bool {
    one.joint.starts_with(joint) && one.parameter.contains(parameter)
}

/// Drift of everything: the Stribeck velocity stays.
fn all(one: &History) -> f64 {
    match one.parameter.as_str() {
        gap if gap.starts_with("backlash") => GAP,
        speed if speed.ends_with("stribeck_velocity") => 0.0,
        _ => FRICTION,
    }
}

/// What repeats on one machine show.
struct Repeats {
    histories: Vec<History>,
    runs: usize,
    /// Median of every parameter.
    middle: Vec<f64>,
}

impl Repeats {
    fn of(histories: Vec<History>, runs: usize) -> Self {
        let middle = histories.iter().map(|one| median(one.repeats.iter().map(|one| one.value).collect())).collect();
        Self { histories, runs, middle }
    }

    /// A week of `results`, evenly distributed, with this drift. Each has all errors and standard errors of one of the repeats.
    fn week(&self, results: usize, drifting: Drifting, rng: &mut impl Rng) -> Vec<History> {
        let mut week: Vec<History> =
            self.histories.iter().map(|one| History { repeats: Vec::new(), ..one.clone() }).collect();
        for k in 0..results {
            let run = rng.random_range(0..self.runs);
            for (i, one) in week.iter_mut().enumerate() {
                let Some(drawn) = self.histories[i].repeats.iter().find(|one| one.time == run as f64) else { continue };
                let part = k as f64 / (results - 1) as f64;
                let value = drawn.value + self.middle[i] * part * drifting(&self.histories[i]);
                one.repeats.push(Repeat { time: k as f64, value, ..*drawn });
            }
        }
        week
    }

    /// Table of the scatter of repeats beside the standard errors stated.
    fn print(&self) {
        println!("{} repeats on one machine", self.runs);
        let heads = "| joint | parameter | found | scatter, robust % | farthest % | standard error stated % |";
        println!("\n{heads}\n|---|---|---|---|---|---|");
        for (one, middle) in self.histories.iter().zip(&self.middle) {
            let percent = |size: f64| 100.0 * size / middle.abs();
            let distances: Vec<f64> = one.repeats.iter().map(|one| (one.value - middle).abs()).collect();
            let farthest = distances.iter().copied().fold(0.0, f64::max);
            let scatter = 1.4826 * median(distances);
            let stated = median(one.repeats.iter().map(|one| one.std_error).collect());
            let figures = [scatter, farthest, stated].map(|size| format!("{:.2}", percent(size))).join(" | ");
            println!("| {} | {} | {} | {figures} |", one.joint, symbol(&one.parameter), one.repeats.len());
        }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Outcome of weeks of one kind.
#[derive(Default)]
struct Outcome {
    weeks: u32,
    /// Weeks in which each drifting parameter was named.
    found: BTreeMap<String, u32>,
    /// Weeks in which every drifting parameter was named.
    every: u32,
    /// Weeks in which a parameter that does not drift was named.
    wrong: u32,
}

impl Outcome {
    fn count(&mut self, trends: &[Trend], drifting: Drifting) {
        self.weeks += 1;
        let (mut every, mut wrong) = (true, false);
        for trend in trends {
            let drifts = drifting(&trend.history) != 0.0;
            if drifts {
                let name = format!("{} {}", trend.history.joint, symbol(&trend.history.parameter));
                *self.found.entry(name).or_default() += u32::from(trend.changed);
            }
            every &= trend.changed || !drifts;
            wrong |= trend.changed && !drifts;
        }
        self.every += u32::from(every);
        self.wrong += u32::from(wrong);
    }

    fn print(&self, name: &str, results: usize) {
        let percent = |count: u32| 100.0 * f64::from(count) / f64::from(self.weeks);
        let worst = self.found.iter().min_by_key(|(_, count)| **count);
        let worst = worst.map_or_else(|| "–".to_owned(), |(name, count)| format!("{:.1} % ({name})", percent(*count)));
        let every = if self.found.is_empty() { "–".to_owned() } else { format!("{:.1} %", percent(self.every)) };
        let wrong = format!("{} of {} ({:.2} %)", self.wrong, self.weeks, percent(self.wrong));
        println!("| {name} | {results} | {worst} | {every} | {wrong} |");
    }
}

const HEAD: &str = "\n| week | results | least found | all found | others named |\n|---|---|---|---|---|";

fn drawn(repeats: &Repeats, weeks: u32) {
    println!("\nDrawn weeks\n{HEAD}");
    for (name, drifting) in KINDS {
        for results in RESULTS {
            let mut rng = ChaCha8Rng::seed_from_u64(SEEDS[1]);
            let mut outcome = Outcome::default();
            for _ in 0..weeks {
                outcome.count(&trends(&repeats.week(results, drifting, &mut rng), "result", LEVEL), drifting);
            }
            outcome.print(name, results);
        }
    }
}

/// Numbers of parameters, and how many of them scatter three times as much as stated.
const MIXED: [[usize; 2]; 6] = [[2, 1], [4, 1], [9, 1], [18, 1], [18, 6], [18, 18]];

/// Weeks without drift of parameters of which some scatter three times as much as stated.
fn mixed(weeks: u32) {
    println!(
        "\nDrawn weeks without drift\n\n| parameters | scatter three times as stated | results | any named |\n|---|---|---|---|"
    );
    for ([parameters, wide], results) in MIXED.into_iter().flat_map(|kind| RESULTS.map(|results| (kind, results))) {
        let mut rng = ChaCha8Rng::seed_from_u64(SEEDS[1]);
        let mut named = 0;
        for _ in 0..weeks {
            let mut history = |k: usize| {
                let std_error = if k < wide { 1.0 / 3.0 } else { 1.0 };
                let mut repeat =
                    |time: usize| Repeat { time: time as f64, value: StandardNormal.sample(&mut rng), std_error };
                let repeats = (0..results).map(&mut repeat).collect();
                History { joint: String::new(), parameter: String::new(), unit: String::new(), repeats }
            };
            let week: Vec<History> = (0..parameters).map(&mut history).collect();
            named += u32::from(trends(&week, "result", LEVEL).iter().any(|trend| trend.changed));
        }
        println!(
            "| {parameters} | {wide} | {results} | {named} of {weeks} ({:.2} %) |",
            100.0 * f64::from(named) / f64::from(weeks)
        );
    }
}

/// The histories in these files.
fn read(files: &[PathBuf]) -> Result<Vec<History>, String> {
    let times: Vec<f64> = (0..files.len()).map(|k| k as f64).collect();
    Ok(histories(files, &times).map_err(|why| why.to_string())?.1)
}

fn run_by_run(weeks: u64, folder: &Path) -> Result<(), String> {
    println!("\nSimulated weeks\n{HEAD}");
    let most = RESULTS[1];
    for (kind, (name, drifting)) in [(0, KINDS[0]), (1, KINDS[5])] {
        let drift = if kind == 0 { Drift { friction: 0.0, gap: 0.0 } } else { Drift { friction: FRICTION, gap: GAP } };
        let mut outcomes = RESULTS.map(|_| Outcome::default());
        for week in 0..weeks {
            let seed = SEEDS[2] + most as u64 * (weeks * kind + week);
            let files = simulated(drift, most as u64, seed, &folder.join(format!("{kind}_{week}")));
            for (outcome, results) in outcomes.iter_mut().zip(RESULTS) {
                // The first and the last run, and those evenly between them.
                let at = |k: usize| (k * (most - 1)) as f64 / (results - 1) as f64;
                let chosen: Vec<PathBuf> = (0..results).map(|k| files[at(k).round() as usize].clone()).collect();
                outcome.count(&trends(&read(&chosen)?, "result", LEVEL), drifting);
            }
        }
        outcomes.iter().zip(RESULTS).for_each(|(outcome, results)| outcome.print(name, results));
    }
    Ok(())
}

/// Numbers of repeats, of drawn weeks and of simulated weeks.
fn asked() -> Result<[u64; 3], String> {
    let mut asked = [100, 500, 6];
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    while let Some(word) = words.next() {
        let at = ["--repeats", "--weeks", "--simulated"].iter().position(|one| *one == word);
        let at = at.ok_or_else(|| format!("{word}: expected --repeats, --weeks or --simulated"))?;
        let value = words.next().and_then(|text| text.parse().ok());
        asked[at] = value.ok_or_else(|| format!("{word}: expected a whole number"))?;
    }
    Ok(asked)
}

fn run() -> Result<(), String> {
    let [repeats, weeks, week_by_week] = asked()?;
    let folder = tempfile::tempdir().map_err(|why| why.to_string())?;
    let still = Drift { friction: 0.0, gap: 0.0 };
    let files = simulated(still, repeats, SEEDS[0], &folder.path().join("repeats"));
    let repeats = Repeats::of(read(&files)?, files.len());
    repeats.print();
    let weeks = u32::try_from(weeks).map_err(|why| why.to_string())?;
    drawn(&repeats, weeks);
    mixed(weeks.saturating_mul(8));
    run_by_run(week_by_week, folder.path())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::from(2)
        }
    }
}

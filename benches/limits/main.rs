//! How far the identification reaches: errors of friction and gap against sensors, gears and gaps, the tables of `docs/limits.md`.
//!
//! `cargo bench --bench limits -- [--seeds N | --draw]`; `--draw` draws the table that the page has as the pictures in `docs/figures`.
//!
//! Seeds from 7001 of the staircase of scenario 01, one property of the machine at a time changed on both joints.

mod bound;
mod picture;
mod settings;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lostmotion::identify::{JointIdentification, Options, Quantity, identify};
use lostmotion::plant::Engine;
use lostmotion::scenario::{Scenario, Truth, simulate};
use rayon::prelude::*;
use settings::{JOINTS, Setting};

/// First seed: those of this bench.
const SEEDS: u64 = 7001;
/// Coefficients of a direction.
const COEFFICIENTS: usize = 4;

/// An estimate beside the truth.
#[derive(Clone, Copy)]
struct Error {
    /// [%]
    percent: f64,
    /// Whether the 95 % interval holds the truth.
    held: bool,
}

impl Error {
    fn of(found: &Quantity) -> Option<Self> {
        let [low, high] = found.interval;
        let truth = found.truth?;
        let percent = found.error_percent.unwrap_or(100.0 * found.value);
        Some(Self { percent, held: (low..=high).contains(&truth) })
    }
}

/// One joint of one run.
struct Joint {
    /// RMS error of the curve [%], both directions.
    curve: [f64; 2],
    /// `F_C`, `F_S`, `v_S`, `F_V` of both directions.
    friction: [[Option<Error>; 2]; COEFFICIENTS],
    gap: Option<Error>,
    /// Bound of the standard error of the same coefficients [%], positive direction.
    bound: Option<[f64; COEFFICIENTS]>,
}

impl Joint {
    fn of(scenario: &Scenario, index: usize, found: &JointIdentification) -> Self {
        let laws = found.friction.exponential.each();
        let friction = [0, 1, 2, 3].map(|k| {
            laws.map(|law| Error::of([&law.coulomb, &law.breakaway, &law.stribeck_velocity, &law.viscous][k]))
        });
        Self {
            curve: laws.map(|law| law.curve_error_percent.unwrap_or(f64::NAN)),
            friction,
            gap: found.backlash.as_ref().and_then(|gap| Error::of(&gap.best.mean)),
            bound: bound::of(scenario, index, &found.points),
        }
    }
}

fn scenario_01() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/01_identify_scara/scenario.toml")
}

/// Ways for which the steps of scenario 01 settle, as they stand in its file.
const SETTLING: [(&str, f64); 2] = [("settling_way_deg = 2.0 ", 2.0), ("settling_way_deg = 2.6\n", 2.6)];

/// Scenario 01 with one property changed.
fn changed(setting: &Setting) -> Result<Scenario, String> {
    let mut text = std::fs::read_to_string(scenario_01()).map_err(|why| why.to_string())?;
    for (written, degrees) in SETTLING {
        text = text.replace(written, &format!("settling_way_deg = {}\n", setting.settling * degrees));
    }
    let mut scenario = Scenario::from_text(&text, &scenario_01(), &setting.set).map_err(|why| why.to_string())?;
    scenario.options.engine = Engine::Reduced;
    Ok(scenario)
}

/// Both joints in every run; `None` for a joint that was not identified.
fn runs(setting: &Setting, seeds: u64) -> Result<Vec<[Option<Joint>; 2]>, String> {
    let scenario = changed(setting)?;
    let of_seed = |seed: u64| {
        let found = simulate(&scenario, seed, &|_, _| {})
            .and_then(|run| identify(&scenario.model, &run.measured(), &Options::default()));
        let Ok(mut found) = found else { return [None, None] };
        let truth: &Truth = &scenario.truth;
        truth.compare(&mut found);
        [0, 1].map(|index| found.joint(JOINTS[index]).map(|joint| Joint::of(&scenario, index, joint)))
    };
    Ok((SEEDS..SEEDS + seeds).into_par_iter().map(of_seed).collect())
}

/// Two significant digits.
fn figure(value: f64) -> String {
    match value.abs() {
        size if !size.is_finite() => "–".to_owned(),
        size if size >= 9.95 => format!("{value:.0}"),
        size if size >= 0.995 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = values.collect();
    (all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64).sqrt()
}

fn row(setting: &Setting, name: &str, joints: &[&Joint], seeds: u64) {
    let of = |k: usize| joints.iter().flat_map(move |joint| joint.friction[k].into_iter().flatten());
    let errors: Vec<String> = (0..COEFFICIENTS).map(|k| figure(rms(of(k).map(|one| one.percent)))).collect();
    let held = (0..COEFFICIENTS).flat_map(of).filter(|one| one.held).count();
    let all = (0..COEFFICIENTS).flat_map(of).count();
    let times = |k: usize| {
        let own = rms(joints.iter().filter_map(|joint| Some(joint.friction[k][0]?.percent)));
        figure(own / rms(joints.iter().filter_map(|joint| Some(joint.bound?[k]))))
    };
    let times: Vec<String> = (0..COEFFICIENTS).map(times).collect();
    let gaps: Vec<Error> = joints.iter().filter_map(|joint| joint.gap).collect();
    let mean = gaps.iter().map(|gap| gap.percent).sum::<f64>() / gaps.len() as f64;
    let spread = rms(gaps.iter().map(|gap| gap.percent - mean));
    let inside = gaps.iter().filter(|gap| gap.held).count();
    println!(
        "| {} | {name} | {} of {seeds} | {} | {} | {held} of {all} | {} | {} of {seeds} | {} ± {} | {inside} of {} |",
        setting.name,
        joints.len(),
        figure(rms(joints.iter().flat_map(|joint| joint.curve))),
        errors.join(" / "),
        times.join(" / "),
        gaps.len(),
        figure(mean),
        figure(spread),
        gaps.len(),
    );
}

fn table(seeds: u64) -> Result<(), String> {
    println!(
        "| setting | joint | identified | curve [%] | F_C / F_S / v_S / F_V [%] | in 95 % interval | times the bound | gap found | gap [%] | in 95 % interval |"
    );
    println!("|{}", "---|".repeat(10));
    for setting in settings::all() {
        let found = runs(&setting, seeds)?;
        for (index, name) in JOINTS.iter().enumerate() {
            let joints: Vec<&Joint> = found.iter().filter_map(|run| run[index].as_ref()).collect();
            row(&setting, name, &joints, seeds);
        }
    }
    Ok(())
}

/// Writes the table of the page as pictures.
fn pictures() -> Result<(), String> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let page = std::fs::read_to_string(docs.join("limits.md")).map_err(|why| why.to_string())?;
    let rows = picture::rows(&page);
    let write =
        |name: &str, svg: String| std::fs::write(docs.join("figures").join(name), svg).map_err(|why| why.to_string());
    write("limits_errors.svg", picture::of_errors(&rows))?;
    write("limits_bound.svg", picture::of_bounds(&rows))
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let seeds = match &words[..] {
        [] => Some(8),
        [flag] if flag == "--draw" => None,
        [flag, count] if flag == "--seeds" && count.parse::<u64>().is_ok_and(|count| count > 0) => count.parse().ok(),
        _ => {
            eprintln!("error: expected --draw or [--seeds N], N > 0");
            return ExitCode::from(2);
        }
    };
    match seeds.map_or_else(pictures, table) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::from(2)
        }
    }
}

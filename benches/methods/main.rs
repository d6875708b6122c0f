//! Other methods of the literature beside the program's own on the same machine: the table of `docs/methods.md`.
//!
//! `cargo bench --bench methods -- [--seeds N]`
//!
//! Ten seeds (7001 to 7010) of the scenarios that hold the methods' own experiments beside the staircase, at three resolutions of the
//! encoders. Runs follow each other, so that computing times are those of one core, but for what a method divides among cores itself.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use lostmotion::gearhead::Friction;
use lostmotion::identify::{Identification, JointIdentification, Method, Options, Quantity, backlash, identify};
use lostmotion::plant::Engine;
use lostmotion::scenario::{Scenario, simulate};
use lostmotion::timeseries::{Channel, TimeSeries};

/// First seed: those of this bench.
const SEEDS: u64 = 7001;
/// Counts of an encoder a turn: 500 pulses counted once and in quadrature, and an encoder ten times as fine.
const COUNTS: [u32; 3] = [500, 2000, 20_000];
/// Scenarios, the method whose experiment they hold, and the assignments that change the encoders.
const EXPERIMENTS: [(&str, Method, &[&str]); 3] = [
    ("16_gap_by_switching", Method::SwitchingLeastSquares, &["joint1", "joint2"]),
    ("17_gap_by_limit_cycle", Method::LimitCycle, &["joint1", "joint2"]),
    ("18_lugre_presliding", Method::Lugre, &["joint1"]),
];

/// One estimate of one run.
struct Row {
    name: &'static str,
    joint: String,
    quantity: &'static str,
    /// [%] `None` where the method gives nothing.
    error: Option<f64>,
    /// [s] of the experiment.
    duration: f64,
    /// [ms] of computing.
    computing: f64,
}

/// The program's own gap of a joint, computed once more to take its time.
fn ours(scenario: &Scenario, found: &JointIdentification, data: &[TimeSeries]) -> Row {
    let joint = scenario.model.robot.joint_index(&found.joint).unwrap_or(0);
    let friction = Friction { law: found.friction.preferred_law(), link_share: 0.0 };
    let sessions: Vec<&TimeSeries> = data.iter().collect();
    let start = Instant::now();
    let again = backlash::identify(&scenario.model, joint, &sessions, &friction);
    let computing = 1e3 * start.elapsed().as_secs_f64();
    let moves = |session: &&TimeSeries| {
        let reference = session.joint(&found.joint).and_then(|one| one.get(Channel::ReferenceVelocity));
        reference.is_some_and(|v| v.iter().any(|v| *v != 0.0))
    };
    let error = again.ok().and(found.backlash.as_ref()).and_then(|gap| gap.best.mean.error_percent);
    let duration = data.iter().filter(moves).map(length).sum();
    Row { name: "ours", joint: found.joint.clone(), quantity: "gap", error, duration, computing }
}

/// [s] Length of a session.
fn length(session: &TimeSeries) -> f64 {
    session.time.last().unwrap_or(&0.0) - session.time.first().unwrap_or(&0.0)
}

/// The estimates of a method on a joint.
fn theirs(scenario: &Scenario, method: Method, found: &JointIdentification, data: &[TimeSeries]) -> Vec<Row> {
    let joint = scenario.model.robot.joint_index(&found.joint).unwrap_or(0);
    let start = Instant::now();
    let Some(once_more) = method.estimate(&scenario.model, joint, data, &found.friction) else { return Vec::new() };
    let computing = 1e3 * start.elapsed().as_secs_f64();
    let compared = found.methods.iter().find(|one| one.method == method.name());
    let rows = method.estimates().iter().map(|quantity| {
        let of = |(name, one): (&str, &Quantity)| (name == *quantity).then_some(one.error_percent).flatten();
        let error = compared.and_then(|one| one.quantities().find_map(of));
        let duration = once_more.duration;
        Row { name: method.name(), joint: found.joint.clone(), quantity, error, duration, computing }
    });
    rows.collect()
}

/// All estimates of the seeds at a resolution.
fn rows(experiment: &(&str, Method, &[&str]), counts: u32, seeds: u64) -> Result<Vec<Row>, String> {
    let (name, method, joints) = *experiment;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name).join("scenario.toml");
    let set: Vec<String> =
        joints.iter().map(|joint| format!("model.joints.{joint}.encoder.counts_per_turn={counts}")).collect();
    let mut scenario = Scenario::load(&path, &set).map_err(|why| why.to_string())?;
    scenario.options.engine = Engine::Reduced;
    let mut all = Vec::new();
    for seed in SEEDS..SEEDS + seeds {
        let data = simulate(&scenario, seed, &|_, _| {}).map_err(|why| why.to_string())?.measured();
        let mut found = identify(&scenario.model, &data, &Options::default())
            .unwrap_or(Identification { joints: Vec::new(), left_out: Vec::new() });
        scenario.truth.compare(&mut found);
        for joint in &found.joints {
            all.push(ours(&scenario, joint, &data));
            all.extend(theirs(&scenario, method, joint, &data));
        }
    }
    Ok(all)
}

/// One line of the table: all rows of a method, a joint and a quantity.
fn line(rows: &[&Row], counts: u32, seeds: u64) {
    let Some(first) = rows.first() else { return };
    let errors: Vec<f64> = rows.iter().filter_map(|row| row.error).collect();
    let n = errors.len() as f64;
    let mean = |of: &dyn Fn(&Row) -> f64| rows.iter().map(|row| of(row)).sum::<f64>() / rows.len() as f64;
    let bias = errors.iter().sum::<f64>() / n;
    let spread = (errors.iter().map(|error| (error - bias).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let figure = |value: f64| if value.is_finite() && n > 1.0 { format!("{value:+.1}") } else { "–".to_owned() };
    println!(
        "| {} | {} | {} | {counts} | {} of {seeds} | {} | {} | {:.0} | {:.0} |",
        first.name.replace('_', " "),
        first.joint,
        first.quantity,
        errors.len(),
        figure(bias),
        figure(spread).trim_start_matches('+'),
        mean(&|row| row.duration),
        mean(&|row| row.computing),
    );
}

fn table(seeds: u64) -> Result<(), String> {
    for experiment in &EXPERIMENTS {
        println!("\n{}\n", experiment.0);
        println!(
            "| method | joint | quantity | counts a turn | found | bias [%] | spread [%] | experiment [s] | computing [ms] |"
        );
        println!("|{}", "---|".repeat(9));
        for counts in COUNTS {
            let rows = rows(experiment, counts, seeds)?;
            for joint in experiment.2 {
                for name in ["ours", experiment.1.name()] {
                    for quantity in experiment.1.estimates() {
                        let own = |row: &&Row| row.name == name && row.joint == *joint && row.quantity == *quantity;
                        line(&rows.iter().filter(own).collect::<Vec<_>>(), counts, seeds);
                    }
                }
            }
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let seeds = match &words[..] {
        [] => Some(10),
        [flag, count] if flag == "--seeds" => count.parse().ok().filter(|count| *count > 1),
        _ => None,
    };
    let Some(seeds) = seeds else {
        eprintln!("error: expected [--seeds N], N > 1");
        return ExitCode::from(2);
    };
    match table(seeds) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::from(2)
        }
    }
}

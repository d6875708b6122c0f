//! What the filter's score can decide: machines with a hidden effect, a blind start from the regression, all nuisances free, and every rival fitted.
//!
//! `cargo bench --bench gate -- [--effects NAME,...|none] [--rivals NAME,...] [--machines N] [--strengths 1,0.5] [--rough 0] [--bristles RAD]
//!  [--seeds FIRST] [--practice FOLDER,...] [--judge all|NAME,...]`
//!
//! `--rough F`: nominal values off by `F` deviations of the default accuracy (masses 10 %). `--bristles`: the machine's friction yields by this angle before it
//! slips, which no hypothesis contains. `--practice`: sets of a foreign simulator, in folders. `--judge`: what the stage of a diagnosis says, with these
//! effects beside what the regression named.

#[path = "../../tests/support/drawn/arm.rs"]
mod arm;
mod case;
#[path = "../../tests/support/drawn/drawn.rs"]
mod drawn;
#[path = "../../tests/support/drawn/hidden.rs"]
mod hidden;
mod judged;
mod lines;
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
mod table;

use std::path::Path;

use case::{Case, Given};
use drawn::Drawn;
use hidden::Order;
use judged::Judged;
use lostmotion::dataset;
use lostmotion::diagnose::judge::starts::EFFECTS;
use lostmotion::gearhead::FrictionLaw;
use lostmotion::robot::{EffectEntry, Model};

/// First seed of the machines: they belong to this bench.
const SEEDS: u64 = 800_000;

/// What is asked.
struct Asked {
    effects: Vec<String>,
    rivals: Vec<String>,
    machines: u64,
    strengths: Vec<f64>,
    rough: f64,
    bristles: f64,
    seeds: u64,
    practice: Vec<String>,
    judge: Vec<String>,
}

fn asked() -> Result<Asked, String> {
    let list = |text: &str| text.split(',').map(str::to_owned).collect::<Vec<_>>();
    let rivals: Vec<String> = EFFECTS.map(str::to_owned).into();
    let effects = [&["none".to_owned()], &rivals[..7]].concat();
    let (strengths, practice) = (vec![1.0, 0.5], Vec::new());
    let (rough, bristles) = (0.0, 0.0);
    let mut asked =
        Asked { effects, rivals, machines: 1, strengths, rough, bristles, seeds: SEEDS, practice, judge: Vec::new() };
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    while let Some(word) = words.next() {
        let value = words.next().ok_or_else(|| format!("{word} needs a value"))?;
        let number = |text: &str| text.parse::<f64>().map_err(|_| format!("{word} needs a number, not {text}"));
        match word.as_str() {
            "--effects" => asked.effects = list(&value),
            "--rivals" => asked.rivals = list(&value),
            "--machines" => asked.machines = number(&value)? as u64,
            "--strengths" => {
                asked.strengths = list(&value).iter().map(|text| number(text)).collect::<Result<_, _>>()?
            }
            "--rough" => asked.rough = number(&value)?,
            "--bristles" => asked.bristles = number(&value)?,
            "--seeds" => asked.seeds = number(&value)? as u64,
            "--judge" => asked.judge = list(&value),
            "--practice" => asked.practice = list(&value),
            _ => return Err(format!("unknown option {word}")),
        }
    }
    if let Some(unknown) = asked.rivals.iter().find(|name| !EFFECTS.contains(&name.as_str())) {
        return Err(format!("{unknown} is none of {EFFECTS:?}"));
    }
    Ok(asked)
}

/// Draws a machine and records it.
fn draw(asked: &Asked, effect: &str, strength: f64, seed: u64) -> Given {
    let order = if effect == "none" { Order::nothing(seed) } else { Order::one(effect, strength, seed) };
    let mut drawn = Drawn::new(&order);
    let hidden = drawn.entries.iter().map(described).collect();
    if asked.bristles > 0.0 {
        let truth = drawn.truth();
        drawn.entries.extend(truth.joints.iter().filter_map(|joint| bristles(joint, asked.bristles)));
    }
    let nominal = match asked.rough > 0.0 {
        true => rough::off(&drawn.nominal, seed, asked.rough),
        false => drawn.nominal.clone(),
    };
    let name = format!("{} ×{strength}", order.name());
    Given { name, hidden, nominal, truth: Some(drawn.truth()), sessions: drawn.sessions().collect() }
}

fn described(entry: &EffectEntry) -> String {
    let values: Vec<String> = entry.parameters.iter().map(|(name, value)| format!("{name} {value:.4}")).collect();
    format!("{} {}: {}", entry.effect, entry.joint.as_deref().unwrap_or("machine"), values.join(", "))
}

/// Bristles that yield by an angle [rad] before they slip, damped at the limit.
fn bristles(joint: &lostmotion::robot::JointModel, angle: f64) -> Option<EffectEntry> {
    let friction = joint.friction?;
    let FrictionLaw::Exponential([side, _]) = friction.law else { return None };
    let stiffness = (1.0 - friction.link_share) * side.coulomb / angle;
    let damping = (stiffness * joint.reflected_inertia()).sqrt();
    let parameters = [("stiffness".to_owned(), stiffness), ("damping".to_owned(), damping)].into();
    Some(EffectEntry { effect: "presliding".to_owned(), joint: Some(joint.name.clone()), parameters })
}

/// Reads a set of a foreign simulator.
fn read(folder: &str) -> Result<Given, Box<dyn std::error::Error>> {
    let folder = Path::new(folder);
    let nominal = Model::load(&folder.join("model.toml"))?;
    let truth: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(folder.join("truth.json"))?)?;
    let effects = truth["effects"].as_object().ok_or("effects in truth.json")?;
    let hidden = effects.keys().filter(|name| *name != "none").cloned().collect();
    let names = ["staircase.csv", "fast_1.csv", "fast_2.csv", "fast_3.csv"];
    let read = |name: &str| dataset::load_for(&folder.join(name), &nominal).map(|session| session.series);
    let sessions = names.into_iter().map(read).collect::<Result<_, _>>()?;
    let name = folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    Ok(Given { name, hidden, nominal, truth: None, sessions })
}

/// The stage of a diagnosis, or all rivals, on a machine.
fn judge(cases: &mut Vec<Case>, stages: &mut Vec<Judged>, asked: &Asked, given: Given) {
    let name = given.name.clone();
    let result = if asked.judge.is_empty() {
        Case::new(given, &asked.rivals).map(|case| {
            println!("{}", table::lines(&case));
            cases.push(case);
        })
    } else {
        Judged::new(given, &asked.judge).map(|judged| {
            println!("{}", judged.lines());
            stages.push(judged);
        })
    };
    if let Err(error) = result {
        println!("{name}: no result: {error}");
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked = asked()?;
    let (mut cases, mut stages) = (Vec::new(), Vec::new());
    for folder in &asked.practice {
        judge(&mut cases, &mut stages, &asked, read(folder)?);
    }
    let drawn = asked.practice.is_empty();
    for (number, effect) in asked.effects.iter().enumerate().filter(|_| drawn) {
        for (which, strength) in asked.strengths.iter().enumerate() {
            for machine in 0..asked.machines {
                // A clean machine has no strength: each is one more machine.
                let index = if effect == "none" { machine + which as u64 * asked.machines } else { machine };
                let seed = asked.seeds + 100 * number as u64 + index;
                judge(&mut cases, &mut stages, &asked, draw(&asked, effect, *strength, seed));
            }
        }
    }
    if asked.judge.is_empty() {
        println!("\n{}", table::table(&cases));
    }
    Ok(())
}

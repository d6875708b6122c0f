//! The process that knows what it hides: writes a set of data in one folder and the truth in another.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use lostmotion::dataset::write_csv;
use lostmotion::robot::EffectEntry;
use lostmotion::units::JointKind;
use serde_json::json;

use super::drawn::Drawn;
use super::hidden::Order;

/// Variables that tell the generating process what to do: folder, effects (`none`, `cogging`, `cogging+payload`), strength, seed.
const FOLDER: &str = "HIDDEN_EFFECTS_FOLDER";
const EFFECTS: &str = "HIDDEN_EFFECTS_NAMES";
const STRENGTH: &str = "HIDDEN_EFFECTS_STRENGTH";
const SEED: &str = "HIDDEN_EFFECTS_SEED";

/// A set that the program may see.
#[derive(Debug, Clone)]
pub struct Set {
    /// Nominal model.
    pub model: PathBuf,
    /// Staircase and two fast runs.
    pub data: Vec<PathBuf>,
    /// The third fast run.
    pub hold_out: PathBuf,
    /// What was hidden: not for the program.
    pub truth: PathBuf,
}

impl Set {
    /// The set of this name below a folder.
    pub fn at(folder: &Path, name: &str) -> Self {
        let data = folder.join(name);
        Self {
            model: data.join("model.toml"),
            data: ["staircase", "fast_1", "fast_2"].map(|name| data.join(name).with_extension("csv")).into(),
            hold_out: data.join("fast_3.csv"),
            truth: folder.join("truth").join(format!("{name}.json")),
        }
    }
}

/// Lets a process of its own make a set: this binary again, with arguments that lead it to [`as_told`].
pub fn in_own_process(arguments: &[&str], folder: &Path, order: &Order) -> Set {
    let effects = if order.effects.is_empty() { "none".to_owned() } else { order.effects.join("+") };
    let output = Command::new(std::env::current_exe().expect("this binary"))
        .args(arguments)
        .env(FOLDER, folder)
        .env(EFFECTS, effects)
        .env(STRENGTH, order.strength.to_string())
        .env(SEED, order.seed.to_string())
        .output()
        .expect("the generating process starts");
    let set = Set::at(folder, &order.name());
    assert!(
        output.status.success() && set.truth.is_file(),
        "the generating process of {} failed:\n{}\n{}",
        order.name(),
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    set
}

/// What the generating process does, where the variables are set.
pub fn as_told() {
    let Some(folder) = std::env::var_os(FOLDER) else { return };
    let [effects, strength, seed] = [EFFECTS, STRENGTH, SEED].map(|name| std::env::var(name).expect("a variable"));
    let effects = effects.split('+').filter(|name| *name != "none").map(str::to_owned).collect();
    let (strength, seed) = (strength.parse().expect("a number"), seed.parse().expect("a number"));
    write_set(Path::new(&folder), &Order { effects, strength, seed });
}

fn write_set(folder: &Path, order: &Order) {
    let drawn = Drawn::new(order);
    let machine = &drawn.machine;
    let set = Set::at(folder, &order.name());
    let data = set.model.parent().expect("a folder");
    fs::create_dir_all(data).expect("a folder for data");
    fs::create_dir_all(folder.join("truth")).expect("a folder for the truth");
    fs::write(data.join("robot.urdf"), machine.urdf()).expect("the robot");
    fs::write(&set.model, machine.nominal()).expect("the nominal model");

    let kinds = [JointKind::Revolute; 2];
    for series in drawn.sessions() {
        write_csv(&data.join(&series.name).with_extension("csv"), &series, &kinds).expect("a recording");
    }
    let entry =
        |entry: &EffectEntry| json!({ "effect": entry.effect, "joint": entry.joint, "parameters": entry.parameters });
    let content = json!({
        "seed": order.seed,
        "effects": order.effects,
        "strength": order.strength,
        "entries": drawn.entries.iter().map(entry).collect::<Vec<_>>(),
        "model": machine.truth(&drawn.entries),
    });
    fs::write(&set.truth, format!("{content:#}\n")).expect("the truth");
}

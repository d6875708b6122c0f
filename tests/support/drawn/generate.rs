//! The process that knows what it hides: writes a set of data in one folder and the truth in another.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use lostmotion::dataset::write_csv;
use lostmotion::robot::{EffectEntry, JointModel};
use lostmotion::units::JointKind;
use serde_json::json;

use super::drawn::{Drawn, FIELD_SESSIONS, SESSIONS};
use super::hidden::{Arm, Field, Order};

/// Variables that tell the generating process what to do: folder, effects (`none`, `cogging`, `cogging+payload`), strength, seed, and for a
/// set of the field its arm and the errors of its model.
const FOLDER: &str = "HIDDEN_EFFECTS_FOLDER";
const EFFECTS: &str = "HIDDEN_EFFECTS_NAMES";
const STRENGTH: &str = "HIDDEN_EFFECTS_STRENGTH";
const SEED: &str = "HIDDEN_EFFECTS_SEED";
const ARM: &str = "HIDDEN_EFFECTS_ARM";
const ROUGH: &str = "HIDDEN_EFFECTS_ROUGH";

/// A set that the program may see.
#[derive(Debug, Clone)]
pub struct Set {
    /// Nominal model.
    pub model: PathBuf,
    /// Staircase and two runs.
    pub data: Vec<PathBuf>,
    /// The third run.
    pub hold_out: PathBuf,
    /// What was hidden: not for the program.
    pub truth: PathBuf,
}

impl Set {
    /// The set of this name below a folder.
    pub fn at(folder: &Path, name: &str) -> Self {
        let data = folder.join(name);
        let of_field = name.contains("_rough_");
        let sessions = if of_field { FIELD_SESSIONS } else { SESSIONS };
        let [files @ .., hold_out] = sessions.map(|name| data.join(name).with_extension("csv"));
        Self {
            model: data.join("model.toml"),
            data: files.into(),
            hold_out,
            truth: folder.join("truth").join(format!("{name}.json")),
        }
    }
}

/// Lets a process of its own make a set: this binary again, with arguments that lead it to [`as_told`].
pub fn in_own_process(arguments: &[&str], folder: &Path, order: &Order) -> Set {
    let effects = if order.effects.is_empty() { "none".to_owned() } else { order.effects.join("+") };
    let of_field = order.field.map(|field| [(ARM, field.arm.name().to_owned()), (ROUGH, field.rough.to_string())]);
    let output = Command::new(std::env::current_exe().expect("this binary"))
        .args(arguments)
        .envs(of_field.into_iter().flatten())
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
    let arm = std::env::var(ARM).ok().and_then(|name| Arm::ALL.into_iter().find(|arm| arm.name() == name));
    let rough = || std::env::var(ROUGH).expect("a variable").parse().expect("a number");
    let field = arm.map(|arm| Field { arm, rough: rough() });
    write_set(Path::new(&folder), &Order { field, effects, strength, seed });
}

fn write_set(folder: &Path, order: &Order) {
    let drawn = Drawn::new(order);
    let set = Set::at(folder, &order.name());
    let data = set.model.parent().expect("a folder");
    fs::create_dir_all(data).expect("a folder for data");
    fs::create_dir_all(folder.join("truth")).expect("a folder for the truth");
    drawn.nominal.save(&set.model).expect("the nominal model and the robot");

    let kinds = vec![JointKind::Revolute; drawn.nominal.joints.len()];
    for series in drawn.sessions() {
        write_csv(&data.join(&series.name).with_extension("csv"), &series, &kinds).expect("a recording");
    }
    let entry =
        |entry: &EffectEntry| json!({ "effect": entry.effect, "joint": entry.joint, "parameters": entry.parameters });
    let gap = |joint: &JointModel| (joint.name.clone(), json!(joint.backlash));
    let gaps: serde_json::Map<_, _> = drawn.machine.joints.iter().map(gap).collect();
    let content = json!({
        "seed": order.seed,
        "effects": order.effects,
        "strength": order.strength,
        "sampling": drawn.sampling.map(|sampling| sampling.line()),
        "gaps": gaps,
        "entries": drawn.entries.iter().map(entry).collect::<Vec<_>>(),
        "model": drawn.truth().to_toml(&drawn.nominal.urdf),
    });
    fs::write(&set.truth, format!("{content:#}\n")).expect("the truth");
}

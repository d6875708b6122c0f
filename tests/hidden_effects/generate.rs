//! The process that knows what it hides: writes a set of data in one folder and the truth in another.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use lostmotion::dataset::write_csv;
use lostmotion::robot::Model;
use lostmotion::units::JointKind;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use super::hidden::Hidden;
use super::machine::Machine;
use super::motion;
use super::record::record;

/// Variables that tell the generating process what to do: folder, seed, whether to hide something.
const FOLDER: &str = "HIDDEN_EFFECTS_FOLDER";
const SEED: &str = "HIDDEN_EFFECTS_SEED";
const HIDE: &str = "HIDDEN_EFFECTS_HIDE";

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
    fn at(folder: &Path, seed: u64) -> Self {
        let data = folder.join("data").join(format!("set_{seed}"));
        Self {
            model: data.join("model.toml"),
            data: ["staircase", "fast_1", "fast_2"].map(|name| data.join(name).with_extension("csv")).into(),
            hold_out: data.join("fast_3.csv"),
            truth: folder.join("truth").join(format!("set_{seed}.json")),
        }
    }
}

/// Lets a process of its own make a set: this binary again, with nothing but its test [`super::generate_one`].
pub fn in_own_process(folder: &Path, seed: u64, hide: bool) -> Set {
    let output = Command::new(std::env::current_exe().expect("this binary"))
        .args(["--exact", "generate_one", "--ignored", "--test-threads=1"])
        .env(FOLDER, folder)
        .env(SEED, seed.to_string())
        .env(HIDE, if hide { "1" } else { "0" })
        .output()
        .expect("the generating process starts");
    let set = Set::at(folder, seed);
    assert!(
        output.status.success() && set.truth.is_file(),
        "the generating process of seed {seed} failed:\n{}\n{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    set
}

/// What the generating process does, where the variables are set.
pub fn as_told() {
    let (Some(folder), Ok(seed), Ok(hide)) = (std::env::var_os(FOLDER), std::env::var(SEED), std::env::var(HIDE))
    else {
        return;
    };
    write_set(Path::new(&folder), seed.parse().expect("a number"), hide == "1");
}

fn write_set(folder: &Path, seed: u64, hide: bool) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut machine = Machine::draw(&mut rng);
    let hidden = if hide { Hidden::draw(&mut rng, &mut machine) } else { Hidden::nothing(&mut rng, &mut machine) };

    let set = Set::at(folder, seed);
    let data = set.model.parent().expect("a folder");
    fs::create_dir_all(data).expect("a folder for data");
    fs::create_dir_all(folder.join("truth")).expect("a folder for the truth");
    fs::write(data.join("robot.urdf"), machine.urdf()).expect("the robot");
    fs::write(&set.model, machine.nominal()).expect("the nominal model");

    let truth = machine.truth(&hidden.entries);
    let model = Model::from_texts(&truth, &machine.urdf(), Path::new("truth.toml")).expect("a good model");
    let start = [rng.random_range(-1.2..1.2), rng.random_range(-1.2..1.2)];
    let kinds = [JointKind::Revolute; 2];
    for (index, name) in ["staircase", "fast_1", "fast_2", "fast_3"].into_iter().enumerate() {
        let motion = if index == 0 { motion::staircase(start) } else { motion::fast(&mut rng) };
        let series = record(name, &model, &motion, 4 * seed + index as u64);
        write_csv(&data.join(name).with_extension("csv"), &series, &kinds).expect("a recording");
    }
    let entry = |entry: &lostmotion::robot::EffectEntry| json!({ "effect": entry.effect, "joint": entry.joint, "parameters": entry.parameters });
    let content = json!({
        "seed": seed,
        "effect": hidden.effect,
        "strength": hidden.strength,
        "entries": hidden.entries.iter().map(entry).collect::<Vec<_>>(),
        "model": truth,
    });
    fs::write(&set.truth, format!("{content:#}\n")).expect("the truth");
}

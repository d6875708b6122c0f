//! Sound recordings: simulated machines, and recorded ones where `LOSTMOTION_DATA` is set.

use std::path::{Path, PathBuf};

use lostmotion::dataset;
use lostmotion::robot::Model;
use lostmotion::scenario::{Procedure, Recorded, Scenario, simulate};
use lostmotion::timeseries::TimeSeries;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::hidden::{self, Order};
use super::machine::Machine;
use super::six_joints::RANGES;
use super::{motion, record};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A machine with its nominal model and what was recorded of it.
pub struct Set {
    pub name: String,
    pub model: Model,
    pub sessions: Vec<TimeSeries>,
}

fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}

/// A planar arm of the blind generator with an effect in it, on one fast run.
pub fn planar(order: &Order) -> Set {
    planar_for(order, f64::INFINITY)
}

/// The same for so many seconds of the run at most.
pub fn planar_for(order: &Order, seconds: f64) -> Set {
    let mut machine = Machine::draw(&mut stream(order.seed, 0));
    let entries = hidden::draw(&mut stream(order.seed, 1), order, &mut machine);
    let model = |text: &str| Model::from_texts(text, &machine.urdf(), Path::new("model.toml")).expect("a good model");
    let mut moves = motion::fast(&mut stream(order.seed, 2));
    moves.velocity.iter_mut().for_each(|velocity| velocity.truncate((seconds / motion::INTERVAL) as usize));
    let session = record::record("fast", &model(&machine.truth(&entries)), &moves, order.seed);
    let name = format!("{} of strength {}", order.name(), order.strength);
    Set { name, model: model(&machine.nominal()), sessions: vec![session] }
}

/// A joint of a run: middle and half of its range [rad], speed [rad/s], acceleration [rad/s²], inertia that its controller is tuned for [kg·m²].
type Range = [f64; 5];

/// A robot of the catalogue under gravity, all joints moving, friction and gaps unknown to its nominal model. `hidden`: effects of the
/// truth as TOML, or nothing.
fn moving(robot: &str, ranges: &[Range], duration: f64, hidden: &str, seed: u64) -> Set {
    let mut text = format!(
        "schema = \"lostmotion/scenario/1\"\nname = \"{robot}\"\nquestion = \"\"\nrobot = \"{ROOT}/robots/{robot}/model.toml\"\n\
         sensors = \"model\"\ncontrol_period = 0.001\nprocedure = \"none\"\n[[session]]\nname = \"fast\"\nkind = \"fast\"\n\
         rest = 1.0\nduration = {duration:?}\nlongest_rest = 0.2\nseed = {seed}\n"
    );
    for (index, [middle, ..]) in ranges.iter().enumerate() {
        text += &format!("start.joint{} = {middle:?}\n", index + 1);
    }
    for (index, [middle, half, speed, acceleration, _]) in ranges.iter().enumerate() {
        text += &format!(
            "[session.joints.joint{}]\nlowest = {:?}\nhighest = {:?}\nspeed = {speed:?}\nacceleration = {acceleration:?}\n",
            index + 1,
            middle - half,
            middle + half
        );
    }
    text += "\n[controller]\nlaw = \"pi\"\nvelocity = \"sensor\"\n";
    for (index, [.., inertia]) in ranges.iter().enumerate() {
        text += &format!(
            "[controller.joints.joint{}]\nproportional = {:?}\nintegral = {:?}\n",
            index + 1,
            30.0 * inertia,
            300.0 * inertia
        );
    }
    let assignments: Vec<String> =
        (!hidden.is_empty()).then(|| format!("model.effects={hidden}")).into_iter().collect();
    let scenario = Scenario::from_text(&text, Path::new("scenario.toml"), &assignments).expect("a good scenario");
    let sessions = simulate(&scenario, seed, &|_, _| {}).expect("a run").measured();
    let mut model = scenario.model;
    model.joints.iter_mut().for_each(|joint| (joint.friction, joint.backlash) = (None, None));
    Set { name: format!("{robot}_{seed} {hidden}"), model, sessions }
}

/// The six-axis arm of the catalogue.
pub fn six_axis(hidden: &str, seed: u64) -> Set {
    moving("sixaxis", &RANGES, 16.0, hidden, seed)
}

/// The chain of twelve joints of the catalogue.
pub fn chain(seed: u64) -> Set {
    moving("chain12", &[[0.0, 0.3, 0.4, 1.0, 3.0]; 12], 8.0, "", seed)
}

/// The scenarios of the project that identify or diagnose what they simulate, as they stand.
pub fn scenarios() -> Vec<Set> {
    let of_folder = |folder: PathBuf| {
        let file = folder.join("scenario.toml");
        if !matches!(Recorded::load(&file, &[]), Ok(None)) {
            return None;
        }
        let scenario = Scenario::load(&file, &[]).expect("a scenario");
        let sessions = || simulate(&scenario, scenario.seed, &|_, _| {}).expect("a run").measured();
        (scenario.procedure != Procedure::None).then(|| Set {
            name: scenario.name.clone(),
            sessions: sessions(),
            model: scenario.model.clone(),
        })
    };
    folders().into_par_iter().filter_map(of_folder).collect()
}

/// The scenarios of the project that diagnose recordings.
pub fn recorded_scenarios() -> Vec<Set> {
    let of_folder = |folder: PathBuf| {
        let scenario = Recorded::load(&folder.join("scenario.toml"), &[]).expect("a scenario and its recordings")?;
        let files: Vec<PathBuf> = scenario.data.iter().chain(&scenario.hold_out).cloned().collect();
        Some(recorded(&scenario.name, &scenario.robot, &files))
    };
    folders().into_iter().filter_map(of_folder).collect()
}

fn folders() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(Path::new(ROOT).join("scenarios")).expect("scenarios");
    let folders = entries.map(|entry| entry.expect("an entry").path());
    folders.filter(|folder| folder.join("scenario.toml").is_file()).collect()
}

/// The folder of recordings, or what is missing of it.
pub fn data() -> Result<PathBuf, String> {
    let data = std::env::var_os("LOSTMOTION_DATA").map(PathBuf::from).ok_or("LOSTMOTION_DATA")?;
    let missing =
        ["practice", "arms", "emps", "kuka_kr300"].iter().map(|name| data.join(name)).find(|one| !one.is_dir());
    missing.map_or(Ok(data), |folder| Err(folder.display().to_string()))
}

/// A recorded set.
pub fn recorded(name: &str, model: &Path, files: &[PathBuf]) -> Set {
    let model = Model::load(model).expect("a model");
    let joints = dataset::joints_of(&model);
    let load = |file: &PathBuf| dataset::load(file, &joints).expect("a recording").series;
    let sessions = files.iter().map(load).collect();
    Set { name: name.to_owned(), model, sessions }
}

fn in_folder(folder: &Path, model: &str, files: &[&str]) -> Set {
    let name = format!("{} {model}", folder.file_name().unwrap_or_default().to_string_lossy());
    recorded(
        &name,
        &folder.join(model),
        &files.iter().map(|file| folder.join(file).with_extension("csv")).collect::<Vec<_>>(),
    )
}

/// A robot of the catalogue with its recordings.
fn of_catalogue(robot: &str, datasets: &[&str]) -> Set {
    let folder = Path::new(ROOT).join("robots").join(robot);
    let files: Vec<PathBuf> =
        datasets.iter().map(|name| folder.join("datasets").join(name).with_extension("toml")).collect();
    recorded(robot, &folder.join("model.toml"), &files)
}

/// Recordings in which mistakes are planted: each machine once.
pub fn some_recorded(data: &Path) -> Vec<Set> {
    vec![
        in_folder(&data.join("practice/none"), "model.toml", &["fast_1"]),
        in_folder(&data.join("arms/six_axis_none"), "model_rough_15.toml", &["fast_1"]),
        in_folder(&data.join("arms/ur10e"), "model.toml", &["reference_3"]),
        of_catalogue("emps", &["train"]),
    ]
}

/// Every sound recording at hand.
pub fn all_recorded(data: &Path) -> Vec<Set> {
    let arms = data.join("arms");
    let mut sets =
        vec![of_catalogue("emps", &["train", "pulses"]), of_catalogue("kr300", &["trajectory_a", "trajectory_b"])];
    for name in ["none", "base_tilt", "load_dependent_friction"] {
        let files = ["staircase", "fast_1", "fast_2", "fast_3"];
        sets.push(in_folder(&data.join("practice").join(name), "model.toml", &files));
        sets.push(in_folder(&data.join("practice").join(name), "model.toml", &files[..1]));
    }
    for name in ["six_axis_none", "six_axis_payload"] {
        for model in ["model.toml", "model_rough_05.toml", "model_rough_15.toml"] {
            sets.push(in_folder(&arms.join(name), model, &["fast_1", "fast_2", "fast_3"]));
        }
        sets.push(in_folder(&arms.join(name), "model.toml", &["slow"]));
    }
    for name in ["reference_1", "reference_2", "reference_3", "now_1", "now_2", "now_3"] {
        sets.push(in_folder(&arms.join("ur10e"), "model.toml", &[name]));
    }
    sets.push(in_folder(&arms.join("tx40"), "model.toml", &["session_1"]));
    let pendulum: Vec<String> = ["kp100", "kp200", "kp400", "kp800"]
        .into_iter()
        .flat_map(|gain| {
            ["lift_and_drop", "sin_sin", "sin_time_square", "up_and_down"].map(|run| format!("{gain}_{run}"))
        })
        .collect();
    sets.push(in_folder(
        &arms.join("bam_xl330"),
        "model.toml",
        &pendulum.iter().map(String::as_str).collect::<Vec<_>>(),
    ));
    for run in &pendulum {
        sets.push(in_folder(&arms.join("bam_xl330"), "model.toml", &[run]));
    }
    sets
}

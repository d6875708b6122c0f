//! Effects planted in recordings of machines that the project does not simulate: `cargo bench --bench planted -- [ARM ...]`.
//!
//! The currents of a recording get what an effect of the catalogue would exert (`tests/support/added.rs`), with an amplitude of 0.4 of a joint's
//! Coulomb friction. The motion, the sensors and the errors of the model are the machine's own. What is named beside the planted effect and
//! not without it is a false name. `LOSTMOTION_DATA` names the folder of recordings; a path with `./` is one of the project.

#[path = "../../tests/support/added.rs"]
mod added;
#[path = "../blind/share.rs"]
mod share;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use added::{Moved, added};
use lostmotion::dataset;
use lostmotion::diagnose::{Diagnosis, FoundEffect, Measured, Options, diagnose};
use lostmotion::robot::Model;
use lostmotion::timeseries::TimeSeries;
use lostmotion::toml_input::Document;
use share::Share;

/// Amplitude of an effect, in Coulomb friction of its joint.
const STRENGTH: f64 = 0.4;

/// Effects that are planted.
const PLANTED: [&str; 10] = [
    "cogging",
    "cable_spring",
    "external_contact",
    "current_offset",
    "viscous_asymmetry",
    "position_dependent_friction",
    "quadratic_drag",
    "thermal_friction_drift",
    "torque_ripple",
    "sensor_delay",
];

/// A machine, its recordings, and the joints on which effects are planted, each with its Coulomb friction [N·m or N].
struct Arm {
    name: &'static str,
    model: &'static str,
    /// What the model file lacks, as assignments.
    assignments: &'static [&'static str],
    train: &'static [&'static str],
    held_out: &'static [&'static str],
    joints: &'static [(&'static str, f64)],
}

/// Friction as diagnoses of the recordings as they are give it, of the pendulum as its source does.
const ARMS: [Arm; 5] = [
    Arm {
        name: "pendulum",
        model: "arms/bam_xl330/model.toml",
        assignments: &[],
        train: &[
            "arms/bam_xl330/kp100_lift_and_drop.csv",
            "arms/bam_xl330/kp100_sin_sin.csv",
            "arms/bam_xl330/kp100_sin_time_square.csv",
            "arms/bam_xl330/kp100_up_and_down.csv",
            "arms/bam_xl330/kp200_lift_and_drop.csv",
            "arms/bam_xl330/kp200_sin_sin.csv",
            "arms/bam_xl330/kp200_sin_time_square.csv",
            "arms/bam_xl330/kp200_up_and_down.csv",
            "arms/bam_xl330/kp400_lift_and_drop.csv",
            "arms/bam_xl330/kp400_sin_sin.csv",
            "arms/bam_xl330/kp400_sin_time_square.csv",
            "arms/bam_xl330/kp400_up_and_down.csv",
        ],
        held_out: &[
            "arms/bam_xl330/kp800_lift_and_drop.csv",
            "arms/bam_xl330/kp800_sin_sin.csv",
            "arms/bam_xl330/kp800_sin_time_square.csv",
            "arms/bam_xl330/kp800_up_and_down.csv",
        ],
        joints: &[("joint1", 0.15)],
    },
    Arm {
        name: "six_axis",
        model: "arms/six_axis_none/model_rough_15.toml",
        assignments: &[],
        train: &["arms/six_axis_none/slow.csv", "arms/six_axis_none/fast_1.csv", "arms/six_axis_none/fast_2.csv"],
        held_out: &["arms/six_axis_none/fast_3.csv"],
        joints: &[("joint2", 7.3), ("joint5", 0.78)],
    },
    Arm {
        name: "ur10e",
        model: "arms/ur10e/model.toml",
        assignments: &[],
        train: &["arms/ur10e/reference_1.csv", "arms/ur10e/reference_2.csv", "arms/ur10e/reference_3.csv"],
        held_out: &[],
        joints: &[("shoulder_lift_joint", 9.0), ("wrist_2_joint", 3.0)],
    },
    Arm {
        name: "tx40",
        model: "arms/tx40/model.toml",
        assignments: &["coupling.joint_6 = { joint_5 = 1.0, joint_6 = 1.0 }"],
        train: &["arms/tx40/session_1.csv"],
        held_out: &[],
        joints: &[("joint_2", 12.1), ("joint_4", 4.1)],
    },
    Arm {
        name: "emps",
        model: "./robots/emps/model.toml",
        assignments: &[],
        train: &["./robots/emps/datasets/train.toml"],
        held_out: &["./robots/emps/datasets/pulses.toml"],
        joints: &[("carriage", 21.8)],
    },
];

/// What a diagnosis says of one planted effect.
struct Answer {
    /// Whether it is named, on its joint.
    named: bool,
    /// Whether its interval holds the truth; `None` where it is not named or has no truth.
    size: Option<bool>,
    /// Names that the recording alone does not get.
    false_names: usize,
}

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|one| !one.starts_with("--")).collect();
    let Some(folder) = std::env::var_os("LOSTMOTION_DATA").map(PathBuf::from) else {
        println!("LOSTMOTION_DATA is not set: no recordings");
        return;
    };
    println!(
        "| recording | effects named | sizes in their 95 % intervals | names that are not there |\n|---|---|---|---|"
    );
    for arm in ARMS.iter().filter(|arm| asked.is_empty() || asked.iter().any(|one| one == arm.name)) {
        let answers = arm.answers(&folder);
        let named = Share::of(answers.iter().map(|answer| answer.named));
        let sizes = Share::of(answers.iter().filter_map(|answer| answer.size));
        eprintln!("{}: {} named, {} sizes", arm.name, named.short(), sizes.short());
        let clean = Share::of(answers.iter().map(|answer| answer.false_names > 0));
        println!("| {} | {} | {} | {} |", arm.name, named.text(), sizes.text(), clean.text());
    }
}

impl Arm {
    fn answers(&self, folder: &Path) -> Vec<Answer> {
        let path = |name: &str| match name.strip_prefix("./") {
            Some(own) => Path::new(env!("CARGO_MANIFEST_DIR")).join(own),
            None => folder.join(name),
        };
        let mut file = Document::read(&path(self.model)).expect("a model file");
        self.assignments.iter().for_each(|assignment| file.set(assignment).expect("an assignment"));
        let model = Model::from_changed(&file).expect("the nominal model");
        let read = |name: &&str| dataset::load_for(&path(name), &model).expect("a recording");
        let [train, held_out] = [self.train, self.held_out].map(|names| names.iter().map(read).collect::<Vec<_>>());
        let all: Vec<_> = train.iter().chain(&held_out).collect();
        let model = dataset::meet(&model, &all).expect("a model for these recordings");
        let [train, held_out] =
            [train, held_out].map(|read| read.into_iter().map(|one| one.series).collect::<Vec<TimeSeries>>());
        let sound: BTreeSet<_> = diagnosed(&model, &train, &held_out).effects.iter().map(name).collect();
        eprintln!("{}: {sound:?}", self.name);
        let all: Vec<TimeSeries> = [&train[..], &held_out].concat();
        let mut answers = Vec::new();
        for (joint, coulomb) in self.joints {
            let index = model.joints.iter().position(|one| one.name == *joint).expect("a joint of the model");
            // A delay is one of the whole recorder: the second joint would be the same data again.
            let is_first = *joint == self.joints[0].0;
            for effect in PLANTED.into_iter().filter(|effect| is_first || *effect != "sensor_delay") {
                let planted = added(effect, STRENGTH * coulomb, Moved::new(&all, index), &model, index);
                let to = |sessions: &[TimeSeries]| -> Vec<TimeSeries> {
                    sessions.iter().map(|session| planted.to(session, &model, index)).collect()
                };
                let found = diagnosed(&model, &to(&train), &to(&held_out));
                let value = |one: &FoundEffect| -> Option<(Measured, f64)> {
                    let (name, truth) = planted.truth?;
                    Some((one.parameters.get(name)?.clone(), truth))
                };
                // Within a factor of two: the machine may have the same effect in another size.
                let alike = |one: &FoundEffect| {
                    value(one).is_none_or(|(measured, truth)| (0.5..2.0).contains(&(measured.value / truth)))
                };
                let is_it = |one: &&FoundEffect| {
                    one.effect == effect && one.joints.iter().any(|other| other == joint) && alike(one)
                };
                let own = found.effects.iter().find(is_it);
                let within = |one: &FoundEffect| {
                    value(one).map(|(measured, truth)| (measured.value - truth).abs() <= 1.96 * measured.std_error)
                };
                let is_new = |one: &&FoundEffect| !sound.contains(&name(one)) && own.is_none_or(|own| own != *one);
                let new: Vec<_> = found.effects.iter().filter(is_new).map(name).collect();
                let said: Vec<_> = found.effects.iter().filter_map(value).map(|(measured, _)| measured.value).collect();
                eprintln!(
                    "{} {joint} {effect} {:?}: named {}, {said:?}; new {new:?}",
                    self.name,
                    planted.truth,
                    own.is_some()
                );
                answers.push(Answer { named: own.is_some(), size: own.and_then(within), false_names: new.len() });
            }
        }
        answers
    }
}

fn diagnosed(model: &Model, train: &[TimeSeries], held_out: &[TimeSeries]) -> Diagnosis {
    let options = Options { backlash: false, ..Options::default() };
    diagnose(model, train, held_out, &options, &mut |_, _| {}).expect("a diagnosis")
}

/// An effect and its first joint.
fn name(one: &FoundEffect) -> (String, String) {
    (one.effect.clone(), one.joints[0].clone())
}

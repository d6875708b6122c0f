//! Whether the data of a set could tell what was hidden from everything else: by the information of the model, before any diagnosis.

use std::path::Path;

use lostmotion::dataset;
use lostmotion::diagnose::Options;
use lostmotion::diagnose::separability::{Separability, of_recording};
use lostmotion::robot::Model;
use lostmotion::timeseries::TimeSeries;

use super::generate::Set;
use super::verdict::Hidden;

/// For each hidden effect beside the others; `None` where a diagnosis does not tell it by torque against motion.
pub fn separabilities(set: &Set, effects: &[String], hidden: &[Hidden]) -> Vec<Option<Separability>> {
    let model = Model::load(&set.model).expect("the nominal model");
    let read = |file: &Path| dataset::load(file, &dataset::joints_of(&model)).expect("a recording").series;
    let train: Vec<TimeSeries> = set.data.iter().map(|file| read(file)).collect();
    let joints = |effect: &str| -> Vec<usize> {
        let of = hidden.iter().filter(|entry| entry.effect == effect).filter_map(|entry| entry.joint.as_ref());
        of.filter_map(|name| model.joints.iter().position(|joint| joint.name == *name)).collect()
    };
    let of = |effect: &String| {
        let others = effects.iter().filter(|other| *other != effect);
        let present: Vec<(&str, Vec<usize>)> =
            std::iter::once(effect).chain(others).map(|name| (name.as_str(), joints(name))).collect();
        // A recording that cannot be diagnosed does not tell anything.
        of_recording(&model, &train, &present, &Options::default()).unwrap_or_default()
    };
    effects.iter().map(of).collect()
}

/// One line for the log.
pub fn line(name: &str, effects: &[String], separabilities: &[Option<Separability>]) -> String {
    let one = |(effect, found): (&String, &Option<Separability>)| match found {
        None => format!("{effect}: not told by torque against motion"),
        Some(found) => {
            let closest = found.rivals.iter().take(4).map(|rival| format!("{} {:.1}", rival.effect, rival.nats));
            let closest: Vec<String> = closest.collect();
            format!("{effect}: shows {:.1} nats, of which are lost with {}", found.visible, closest.join(", "))
        }
    };
    let all: Vec<String> = effects.iter().zip(separabilities).map(one).collect();
    format!("{name}: {}", all.join("; "))
}

//! The program's answer to a set, beside what was hidden.

use std::path::Path;

use lostmotion::dataset;
use lostmotion::diagnose::{self, Diagnosis, Options};
use lostmotion::robot::Model;
use lostmotion::timeseries::TimeSeries;
use rayon::prelude::*;

use super::generate::{self, Set};

/// One set: what was hidden, what was named.
#[derive(Debug)]
pub struct Verdict {
    pub seed: u64,
    /// The hidden effect and its joints; `None`: nothing was hidden.
    pub hidden: Option<(String, Vec<String>)>,
    /// The effects named, strongest first, each with its joints and probability.
    pub named: Vec<(String, Vec<String>, f64)>,
    /// [s] that the diagnosis took.
    pub seconds: f64,
}

impl Verdict {
    /// Whether the hidden effect and no other was named; where nothing was hidden, that nothing was named.
    pub fn is_right(&self) -> bool {
        match &self.hidden {
            Some((effect, _)) => !self.named.is_empty() && self.named.iter().all(|named| named.0 == *effect),
            None => self.named.is_empty(),
        }
    }

    /// One line for the log.
    pub fn line(&self) -> String {
        let joints = |joints: &[String]| joints.join("+");
        let hidden =
            self.hidden.as_ref().map_or("nothing".to_owned(), |(effect, on)| format!("{effect} {}", joints(on)));
        let named: Vec<String> =
            self.named.iter().map(|(effect, on, p)| format!("{effect} {} ({p:.2})", joints(on))).collect();
        let mark = if self.is_right() { "ok   " } else { "WRONG" };
        let named = if named.is_empty() { "nothing".to_owned() } else { named.join(", ") };
        format!("{mark} seed {}: hidden {hidden}; named {named}; {:.1} s", self.seed, self.seconds)
    }
}

/// Makes the sets of these seeds in processes of their own, diagnoses them side by side, and prints a line on each.
pub fn verdicts(seeds: impl IntoIterator<Item = u64>, hide: bool) -> Vec<Verdict> {
    let seeds: Vec<u64> = seeds.into_iter().collect();
    let verdicts: Vec<Verdict> = seeds.par_iter().map(|&seed| verdict(seed, hide)).collect();
    for verdict in &verdicts {
        println!("{}", verdict.line());
    }
    verdicts
}

fn verdict(seed: u64, hide: bool) -> Verdict {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let set = generate::in_own_process(folder.path(), seed, hide);
    let start = std::time::Instant::now();
    let diagnosis = diagnosed(&set);
    let seconds = start.elapsed().as_secs_f64();
    let named = diagnosis.effects.iter().map(|found| (found.effect.clone(), found.joints.clone(), found.probability));
    Verdict { seed, hidden: hidden(&set.truth), named: named.collect(), seconds }
}

/// What the program says; it is given nothing but the nominal model and the data.
fn diagnosed(set: &Set) -> Diagnosis {
    let model = Model::load(&set.model).expect("the nominal model");
    let read = |file: &Path| dataset::load(file, &dataset::joints_of(&model)).expect("a recording").series;
    let train: Vec<TimeSeries> = set.data.iter().map(|file| read(file)).collect();
    let hold_out = [read(&set.hold_out)];
    diagnose::diagnose(&model, &train, &hold_out, &Options::default(), &mut |_, _| {}).expect("a diagnosis")
}

/// The hidden effect and its joints.
fn hidden(truth: &Path) -> Option<(String, Vec<String>)> {
    let text = std::fs::read_to_string(truth).expect("the truth");
    let truth: serde_json::Value = serde_json::from_str(&text).expect("the truth is JSON");
    let effect = truth["effect"].as_str()?.to_owned();
    let entries = truth["entries"].as_array().expect("entries");
    let joints = entries.iter().filter_map(|entry| entry["joint"].as_str().map(str::to_owned)).collect();
    Some((effect, joints))
}

//! Time of a whole identification: friction of joints 1 and 2 of the SCARA from 216 s of the paper's staircase.

use std::path::Path;

use lostmotion::identify::{Options, identify};
use lostmotion::plant::Engine;
use lostmotion::scenario::{Scenario, simulate};

fn main() {
    divan::main();
}

#[divan::bench(sample_count = 5)]
fn friction_of_two_joints(bencher: divan::Bencher) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/01_identify_scara/scenario.toml");
    let mut scenario = Scenario::load(&path, &[]).unwrap();
    scenario.options.engine = Engine::Reduced;
    let data = simulate(&scenario, scenario.seed, &|_, _| {}).unwrap().measured();
    let options = Options { backlash: false, ..Options::default() };
    bencher.bench_local(|| identify(&scenario.model, &data, &options).unwrap());
}

//! Weeks of repeated measurements: the staircase of scenario 01 on a machine whose friction and gap grow from run to run.

use std::fs;
use std::path::{Path, PathBuf};

use lostmotion::identify::{Options, identify};
use lostmotion::plant::Engine;
use lostmotion::report::identification::report;
use lostmotion::robot::Model;
use lostmotion::scenario::{Scenario, simulate};
use rayon::prelude::*;

/// Joints that the staircase moves, with Coulomb, breakaway and viscous friction [positive, negative] and gap of `robots/scara`.
type Machine = (&'static str, [[f64; 2]; 3], f64);
const JOINTS: [Machine; 2] = [
    ("joint1", [[0.2718, 0.2847], [0.4645, 0.4493], [0.607335, 0.41253]], 0.00820305),
    ("joint2", [[0.1334, 0.1623], [0.3013, 0.3141], [1.78763, 2.05692]], 0.00610865),
];

/// Shares by which a machine changes until the last run of a week.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Of Coulomb, breakaway and viscous friction.
    pub friction: f64,
    /// Of the gap.
    pub gap: f64,
}

/// The scenario on the machine with a share `part` of the drift.
fn drifted(drift: Drift, part: f64) -> Scenario {
    let friction = 1.0 + part * drift.friction;
    let gap = 1.0 + part * drift.gap;
    let set: Vec<String> = JOINTS
        .iter()
        .flat_map(|(joint, laws, backlash)| {
            let of = ["coulomb", "breakaway", "viscous"].into_iter().zip(laws);
            let law = of.map(move |(key, [positive, negative])| {
                let (positive, negative) = (positive * friction, negative * friction);
                format!("model.joints.{joint}.friction.{key}=[{positive}, {negative}]")
            });
            law.chain([format!("model.joints.{joint}.backlash={}", backlash * gap)])
        })
        .collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/01_identify_scara/scenario.toml");
    let mut scenario = Scenario::load(&path, &set).expect("a scenario of the repository");
    scenario.options.engine = Engine::Reduced;
    scenario
}

/// Runs of a week, evenly distributed over it, with consecutive seeds; each identified with the model that does not drift, its
/// `report.json` in a folder of its own below `folder`. Returns the files in the order of time.
pub fn simulated(drift: Drift, runs: u64, first_seed: u64, folder: &Path) -> Vec<PathBuf> {
    let nominal: Model = drifted(drift, 0.0).model;
    (0..runs)
        .into_par_iter()
        .map(|run| {
            let scenario = drifted(drift, run as f64 / (runs - 1).max(1) as f64);
            let data = simulate(&scenario, first_seed + run, &|_, _| {}).expect("a run").measured();
            let found = identify(&nominal, &data, &Options::default()).expect("friction");
            let file = folder.join(format!("{run:03}")).join("report.json");
            fs::create_dir_all(file.parent().expect("a folder")).expect("a new folder");
            fs::write(&file, report("scara", &found, None, &nominal, Vec::new()).json.to_string()).expect("a new file");
            file
        })
        .collect()
}

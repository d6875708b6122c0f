//! The scenarios of the catalogue that are about recordings.

use std::path::Path;

use lostmotion::diagnose::{Options, diagnose};
use lostmotion::robot::Model;
use lostmotion::scenario::Recorded;

use super::load;

/// A scenario names what it is to name, within its bounds.
pub fn meets_its_expectations(file: &Path) {
    let scenario = Recorded::load(file, &[]).unwrap_or_else(|error| panic!("{error}")).expect("it has data");
    let model = Model::load(&scenario.robot).unwrap();
    let options = Options { backlash: false, ..Default::default() };
    let (data, hold_out) = (load(&model, &scenario.data), load(&model, &scenario.hold_out));
    let found = diagnose(&model, &data, &hold_out, &options, &mut |_, _| {}).unwrap();
    let unmet: Vec<String> = scenario.check(&found).iter().map(ToString::to_string).collect();
    assert!(unmet.is_empty(), "{unmet:#?}");
}

/// No scenario with recordings is left out.
pub fn all_are_listed(listed: &[&str]) {
    let folders = std::fs::read_dir(super::root("scenarios")).unwrap().map(|entry| entry.unwrap().path());
    let on_recordings = |folder: &std::path::PathBuf| {
        std::fs::read_to_string(folder.join("scenario.toml")).is_ok_and(|text| text.contains("\ndata = "))
    };
    let mut found: Vec<String> = (folders.filter(on_recordings))
        .map(|folder| folder.file_name().unwrap().to_str().unwrap().to_owned())
        .collect();
    found.sort();
    assert_eq!(found, listed);
}

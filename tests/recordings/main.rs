//! Checks on recordings that are not part of the project. Where `LOSTMOTION_DATA` does not name their folder, or one of them is not in it,
//! its checks are reported as ignored, never as passed. The scenarios on recordings are carried out by `tests/readme`.

#[path = "../support/added.rs"]
mod added;
mod emps;
mod kr300;
mod planted;
mod practice;
mod ur10e;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use libtest_mimic::{Arguments, Trial};
use lostmotion::dataset;
use lostmotion::robot::Model;
use lostmotion::timeseries::TimeSeries;

const EMPS: [&str; 2] = ["emps/DATA_EMPS.mat", "emps/DATA_EMPS_PULSES.mat"];
const KR300: [&str; 2] = ["kuka_kr300/trajectory_A.csv", "kuka_kr300/trajectory_B.csv"];

const UR10E: [&str; 6] = [
    "arms/ur10e/reference_1.csv",
    "arms/ur10e/reference_2.csv",
    "arms/ur10e/reference_3.csv",
    "arms/ur10e/now_1.csv",
    "arms/ur10e/now_2.csv",
    "arms/ur10e/now_3.csv",
];

/// A check by name, the recordings that it needs, what it does.
type Check = (&'static str, &'static [&'static str], fn());

/// Checks that take minutes: `.ci/long` carries them out.
const LONG: [Check; 2] = [
    ("recover_load_of_the_ur10e_on_all_pairs", &UR10E, ur10e::carries_the_load),
    ("property_the_wrists_of_the_ur10e_have_one_actuator", &UR10E, ur10e::wrists_have_one_actuator),
];

const CHECKS: [Check; 11] = [
    (
        "property_friction_of_the_ur10e_grows_with_load",
        &["arms/ur10e/reference_2.csv"],
        ur10e::friction_grows_with_load,
    ),
    ("published_emps_recordings_read_as_they_were_published", &EMPS, emps::read_as_published),
    (
        "published_the_emps_axis_has_asymmetric_friction_and_a_line_at_one_motor_turn",
        &EMPS,
        emps::has_asymmetric_friction_and_a_line_at_one_motor_turn,
    ),
    (
        "published_emps_replays_at_least_as_well_as_the_published_closed_loop_simulation",
        &EMPS,
        emps::replays_at_least_as_well_as_published,
    ),
    ("published_every_reading_of_emps_has_a_score", &EMPS, emps::is_scored_reading_by_reading),
    (
        "published_emps_in_open_loop_errs_as_much_as_the_published_simulation",
        &EMPS,
        emps::errs_in_open_loop_as_much_as_published,
    ),
    ("published_the_kr300_has_a_delay_and_no_gap", &KR300, kr300::has_a_delay_and_no_gap),
    (
        "property_nothing_is_named_on_the_clean_practice_set",
        &["practice/none/fast_3.csv"],
        practice::clean_is_left_alone,
    ),
    (
        "property_a_ripple_of_less_than_a_turn_is_no_contact",
        &["arms/bam_xl330/kp100_sin_sin.csv"],
        planted::ripple_is_no_contact,
    ),
    ("recover_late_currents_of_a_noisy_arm", &["arms/six_axis_none/slow.csv"], planted::late_currents_show_in_noise),
    ("recover_gap_of_foreign_recordings", &["practice/none/staircase.csv"], practice::gap_of_foreign_recordings),
];

fn main() -> ExitCode {
    let short = CHECKS.iter().map(|&(name, needs, check)| trial(name, needs, check));
    let long = LONG.iter().map(|&(name, needs, check)| trial(name, needs, check).with_ignored_flag(true));
    let trials = short.chain(long).collect();
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}

/// A check that is ignored where one of its recordings is missing; `--include-ignored` makes it fail there.
fn trial(name: &str, needs: &[&str], check: impl FnOnce() + Send + 'static) -> Trial {
    let missing = recordings().map_or(Some("LOSTMOTION_DATA".to_owned()), |folder| {
        needs.iter().map(|file| folder.join(file)).find(|file| !file.is_file()).map(|file| file.display().to_string())
    });
    if let Some(missing) = &missing {
        eprintln!("ignored for want of {missing}: {name}");
    }
    let ignored = missing.is_some();
    Trial::test(name, move || {
        check();
        Ok(())
    })
    .with_ignored_flag(ignored)
}

/// The folder of recordings.
fn recordings() -> Option<PathBuf> {
    std::env::var_os("LOSTMOTION_DATA").map(PathBuf::from)
}

/// A file of the project.
fn root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn load(model: &Model, files: &[PathBuf]) -> Vec<TimeSeries> {
    let joints = dataset::joints_of(model);
    files.iter().map(|file| dataset::load(file, &joints).expect("a recording").series).collect()
}

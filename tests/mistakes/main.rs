//! Mistakes in data and model are named as such, and never where there are none.
//!
//! Mistakes are planted in sound recordings, joint by joint; the sound ones are the negative control. A check on recordings that are missing is
//! reported as ignored, never as passed. The bench `mistakes` does the same at length.

#[path = "../support/drawn/hidden.rs"]
mod hidden;
#[path = "../support/drawn/machine.rs"]
#[allow(dead_code)]
mod machine;
#[path = "../support/drawn/motion.rs"]
mod motion;
#[path = "../support/drawn/record.rs"]
mod record;
#[path = "../support/six_joints.rs"]
#[allow(dead_code)]
mod six_joints;
#[path = "../support/drawn/strengths.rs"]
#[allow(dead_code)]
mod strengths;

mod binary;
mod judged;
#[allow(dead_code)]
mod machines;
mod planted;

use std::process::ExitCode;

use hidden::Order;
use judged::{mostly_told, sound, suspected, table};
use libtest_mimic::{Arguments, Trial};
use lostmotion::diagnose::{Options, diagnose};
use machines::Set;

/// Seed of the machines here: none of the tuning.
const SEED: u64 = 30_500;

fn arms_under_gravity_are_sound() {
    let hidden = ["", "[{effect=\"base_tilt\",tilt=0.1,azimuth=0.7}]", "[{effect=\"payload\",mass=3.0,x=0.0}]"];
    let mut sets: Vec<Set> = (0..).zip(hidden).map(|(k, hidden)| machines::six_axis(hidden, 7 + k)).collect();
    sets.push(machines::chain(7));
    sound(&sets);
}

/// The demonstration among them: on a floor that is not level, gaps that the slow motor crosses at 2 rad/s² look like links that follow it.
fn a_tilted_base_is_no_mistake_in_units() {
    let sets = machines::scenarios();
    assert!(sets.iter().any(|set| set.name == "02_name_the_cause"), "the demonstration is missing");
    sound(&sets);
}

/// A position that is read between two samples moves by parts of counts.
fn a_delay_is_no_gear_ratio() {
    sound(
        &[(0.5, 31_191), (1.0, 31_192), (0.5, 32_191)]
            .map(|(strength, seed)| machines::planar(&Order::one("sensor_delay", strength, seed))),
    );
}

/// The last centre of mass may be 2 cm off and is 6 cm off: most of the weight that the model expects at the wrist is missing.
fn a_centre_of_mass_beside_the_axis_is_no_mistake() {
    let mut sets = [11, 12].map(|seed| machines::six_axis("", seed));
    for model in sets.iter_mut().map(|set| &mut set.model) {
        model.accuracy.centres = 0.02;
        model.robot.bodies.last_mut().expect("a body").inertia.com.y += 0.06;
    }
    sound(&sets);
}

/// A low-pass rounds the velocity, which a clock that is late does not: it is the effect `velocity_lag`, and no mistake.
fn a_filtered_velocity_is_no_mistake() {
    let mut sets = [machines::planar(&Order::nothing(SEED + 41)), machines::six_axis("", 9)];
    for session in sets.iter_mut().flat_map(|set| &mut set.sessions) {
        planted::low_pass_velocities(session, 0.2);
    }
    sound(&sets);
}

/// A file that is held out may have a mistake of its own. It is told, and nothing is fitted.
fn a_mistake_in_a_held_out_session_ends_a_diagnosis() {
    let set = machines::six_axis("", 8);
    let (_, turned) = planted::plant("current turned", &set.model, &set.sessions, 1).expect("a mistake");
    let found = diagnose(&set.model, &set.sessions, &turned, &Options::default(), &mut |_, _| {}).expect("a diagnosis");
    let told: Vec<&str> = found.mistakes.iter().map(|one| one.mistake).collect();
    assert!(told == ["sign_of_current"] && found.effects.is_empty() && found.series.is_empty(), "{told:?}");
}

/// Without a held-out session the end of each is held out, and takes no part in the search: here all its currents are turned.
fn the_held_out_end_of_a_session_is_not_searched() {
    let set = machines::planar(&Order::nothing(SEED + 42));
    let (_, turned) = planted::plant("all currents turned", &set.model, &set.sessions, 0).expect("a mistake");
    let options = Options { backlash: false, ..Options::default() };
    let spliced = planted::with_end_of(&set.sessions[0], &turned[0], 1.0 - options.held_out_share);
    let end = spliced.part((0.7 * spliced.time.len() as f64) as usize..spliced.time.len());
    assert!(!suspected(&set.model, &[end]).is_empty(), "a search would tell it");
    let found = diagnose(&set.model, &[spliced], &[], &options, &mut |_, _| {}).expect("a diagnosis");
    // The finished diagnosis may still tell that the end does not fit.
    assert!(found.mistakes.iter().all(|one| one.mistake == "baseline_error"), "{:?}", found.mistakes);
}

fn recordings_are_sound() {
    sound(&machines::all_recorded(&machines::data().expect("recordings")));
    sound(&machines::recorded_scenarios());
}

fn planted_in_a_planar_arm() {
    mostly_told(table(&[machines::planar(&Order::one("base_tilt", 1.0, SEED + 30))]));
}

/// Inertia of any size is no sign, unit or exchange.
fn planted_beside_unknown_rotors() {
    let mut set = machines::planar(&Order::nothing(SEED + 43));
    set.model.joints.iter_mut().for_each(|joint| joint.rotor_inertia = None);
    mostly_told(table(&[set]));
}

const CHECKS: [(&str, fn()); 13] = [
    ("property_a_filtered_velocity_is_no_mistake", a_filtered_velocity_is_no_mistake),
    ("property_a_mistake_in_a_held_out_session_ends_a_diagnosis", a_mistake_in_a_held_out_session_ends_a_diagnosis),
    ("property_the_held_out_end_of_a_session_is_not_searched", the_held_out_end_of_a_session_is_not_searched),
    ("property_no_mistake_is_suspected_in_arms_under_gravity", arms_under_gravity_are_sound),
    ("regress_a_tilted_base_is_no_mistake_in_units", a_tilted_base_is_no_mistake_in_units),
    ("regress_a_delay_is_no_gear_ratio", a_delay_is_no_gear_ratio),
    ("regress_a_centre_of_mass_beside_the_axis_is_no_mistake", a_centre_of_mass_beside_the_axis_is_no_mistake),
    ("recover_mistakes_planted_in_a_planar_arm", planted_in_a_planar_arm),
    ("recover_mistakes_planted_beside_unknown_rotors", planted_beside_unknown_rotors),
    (
        "regress_a_turned_current_ends_a_diagnosis_with_3_and_no_effect",
        binary::a_turned_current_ends_a_diagnosis_with_3_and_no_effect,
    ),
    (
        "regress_a_dead_current_is_said_and_ends_a_diagnosis_with_3",
        binary::a_dead_current_is_said_and_ends_a_diagnosis_with_3,
    ),
    ("regress_a_replay_that_fails_leaves_the_diagnosis", binary::a_replay_that_fails_leaves_the_diagnosis),
    (
        "regress_a_replay_warns_of_a_turned_current_and_ends_with_3",
        binary::a_replay_warns_of_a_turned_current_and_ends_with_3,
    ),
];

/// The one on recordings.
const RECORDED: (&str, fn()) = ("property_no_mistake_is_suspected_in_sound_recordings", recordings_are_sound);

fn main() -> ExitCode {
    let missing = machines::data().err();
    let trial = |(name, check): (&'static str, fn())| {
        Trial::test(name, move || {
            check();
            Ok(())
        })
    };
    let mut trials: Vec<Trial> = CHECKS.into_iter().map(trial).collect();
    if let Some(missing) = &missing {
        eprintln!("ignored for want of {missing}: {}", RECORDED.0);
    }
    trials.push(trial(RECORDED).with_ignored_flag(missing.is_some()));
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}

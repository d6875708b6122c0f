//! Mistakes in data and model are named as such, and never where there are none.
//!
//! Mistakes are planted in sound recordings, simulated and recorded, joint by joint; the sound ones are the negative control. Checks on recordings
//! that are missing are reported as ignored, never as passed.

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
mod machines;
mod planted;

use std::process::ExitCode;

use hidden::Order;
use libtest_mimic::{Arguments, Trial};
use lostmotion::diagnose::mistakes::{self, Mistake};
use lostmotion::diagnose::{Options, diagnose};
use lostmotion::robot::Model;
use lostmotion::timeseries::TimeSeries;
use machines::Set;
use planted::{MISTAKES, Planted};
use rayon::prelude::*;
use strengths::EFFECTS;

/// Seed of the machines here: none of the tuning.
const SEED: u64 = 30_500;

fn suspected(model: &Model, sessions: &[TimeSeries]) -> Vec<Mistake> {
    mistakes::suspected(model, &sessions.iter().collect::<Vec<_>>())
}

/// What became of a planted mistake.
#[derive(Debug, PartialEq)]
enum Told {
    Right,
    Silent,
    Wrong(String),
}

/// Whether what is told is what was planted: by name or as one of the alternatives that it states, on that joint.
fn told(planted: &Planted, joint: &str, found: &[Mistake]) -> Told {
    let Some(first) = found.first() else { return Told::Silent };
    let names = std::iter::once(&first.mistake).chain(&first.alternatives);
    let named = names.into_iter().any(|name| planted.told.contains(name));
    let place = !planted.of_joint
        || first.joints.iter().any(|one| one == joint)
        || first.evidence.contains(&format!("on {joint}"));
    if named && place { Told::Right } else { Told::Wrong(format!("{found:?}")) }
}

/// Plants every mistake in every joint of the sets; prints the table; returns right, silent and wrong.
fn table(sets: &[Set]) -> [usize; 3] {
    let mut sums = [0; 3];
    for one in &MISTAKES {
        let places: Vec<(&Set, usize)> = sets
            .iter()
            .flat_map(|set| (0..if one.of_joint { set.model.joints.len() } else { 1 }).map(move |joint| (set, joint)))
            .collect();
        let judge = |(set, joint): &(&Set, usize)| {
            let (model, sessions) = planted::plant(one.name, &set.model, &set.sessions, *joint)?;
            Some((set.name.clone(), *joint, told(one, &set.model.joints[*joint].name, &suspected(&model, &sessions))))
        };
        let results: Vec<_> = places.par_iter().filter_map(judge).collect();
        let count = |which: fn(&Told) -> bool| results.iter().filter(|(.., told)| which(told)).count();
        let counts = [
            count(|told| *told == Told::Right),
            count(|told| *told == Told::Silent),
            count(|told| matches!(told, Told::Wrong(_))),
        ];
        println!("{:<34} right {:>2}, silent {:>2}, wrong {:>2}", one.name, counts[0], counts[1], counts[2]);
        for (set, joint, told) in &results {
            if *told != Told::Right {
                println!("      {set} joint {joint}: {told:?}");
            }
        }
        (0..3).for_each(|k| sums[k] += counts[k]);
    }
    println!("right {}, silent {}, wrong {}", sums[0], sums[1], sums[2]);
    sums
}

fn sound(sets: &[Set]) {
    let found: Vec<String> = sets
        .par_iter()
        .filter_map(|set| {
            let found = suspected(&set.model, &set.sessions);
            (!found.is_empty()).then(|| format!("{}: {found:?}", set.name))
        })
        .collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
    println!("{} sound recordings, nothing suspected", sets.len());
}

/// Strengths of an effect: 1 is clearly visible, see `strengths`.
const STRENGTHS: [f64; 3] = [0.5, 1.0, 2.0];
/// [s] Both halves of the fast run, the second in part: a coupling slips after 8 to 32 s.
const SECONDS: f64 = 28.0;
/// A gap that changes along the way by more than its width is none.
const WIDEST_CHANGE_OF_A_GAP: f64 = 1.8;

fn every_effect_at_every_strength_is_sound() {
    let of = |(k, effect): (u64, &&str)| -> Vec<Order> {
        let most = if *effect == "position_dependent_backlash" { WIDEST_CHANGE_OF_A_GAP } else { f64::INFINITY };
        (0..)
            .zip(STRENGTHS)
            .map(|(i, strength)| Order::one(effect, strength.min(most), SEED + 500 + 10 * k + i))
            .collect()
    };
    let mut orders: Vec<Order> = (0..).zip(&EFFECTS).flat_map(of).collect();
    orders.push(Order::nothing(SEED + 20));
    sound(&orders.par_iter().map(|order| machines::planar_for(order, SECONDS)).collect::<Vec<_>>());
}

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

/// Share of the planted mistakes that are told at least: a turned axis of a joint whose torque couples with no other changes nothing in the data,
/// and a scale or a lag cannot be seen where neither inertia nor weight is.
const TOLD: f64 = 0.9;
/// Share that may be told as something else.
const WRONG: f64 = 0.02;

fn mostly_told([right, silent, wrong]: [usize; 3]) {
    let all = (right + silent + wrong) as f64;
    assert!(right as f64 >= TOLD * all && wrong as f64 <= WRONG * all, "{right} right, {silent} silent, {wrong} wrong");
}

fn planted_in_simulated_machines() {
    mostly_told(table(&[machines::planar(&Order::one("base_tilt", 1.0, SEED + 30)), machines::six_axis("", 8)]));
}

fn planted_in_recordings() {
    mostly_told(table(&machines::some_recorded(&machines::data().expect("recordings"))));
}

const CHECKS: [(&str, fn()); 12] = [
    ("property_a_filtered_velocity_is_no_mistake", a_filtered_velocity_is_no_mistake),
    ("property_a_mistake_in_a_held_out_session_ends_a_diagnosis", a_mistake_in_a_held_out_session_ends_a_diagnosis),
    ("property_the_held_out_end_of_a_session_is_not_searched", the_held_out_end_of_a_session_is_not_searched),
    ("property_no_mistake_is_suspected_for_any_effect_at_any_strength", every_effect_at_every_strength_is_sound),
    ("property_no_mistake_is_suspected_in_arms_under_gravity", arms_under_gravity_are_sound),
    ("regress_a_tilted_base_is_no_mistake_in_units", a_tilted_base_is_no_mistake_in_units),
    ("regress_a_delay_is_no_gear_ratio", a_delay_is_no_gear_ratio),
    ("recover_mistakes_planted_in_simulated_machines", planted_in_simulated_machines),
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

/// Those on recordings.
const RECORDED: [(&str, fn()); 2] = [
    ("property_no_mistake_is_suspected_in_sound_recordings", recordings_are_sound),
    ("recover_mistakes_planted_in_recordings", planted_in_recordings),
];

fn main() -> ExitCode {
    let missing = machines::data().err();
    let trial = |(name, check): (&'static str, fn())| {
        Trial::test(name, move || {
            check();
            Ok(())
        })
    };
    let mut trials: Vec<Trial> = CHECKS.into_iter().map(trial).collect();
    for one in RECORDED {
        if let Some(missing) = &missing {
            eprintln!("ignored for want of {missing}: {}", one.0);
        }
        trials.push(trial(one).with_ignored_flag(missing.is_some()));
    }
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}

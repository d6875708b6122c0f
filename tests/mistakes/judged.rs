//! Mistakes planted in sets of recordings, and what is told of them.

use lostmotion::diagnose::mistakes::{self, Mistake};
use lostmotion::robot::Model;
use lostmotion::timeseries::TimeSeries;
use rayon::prelude::*;

use super::machines::Set;
use super::planted::{self, MISTAKES, Planted};

pub fn suspected(model: &Model, sessions: &[TimeSeries]) -> Vec<Mistake> {
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
pub fn table(sets: &[Set]) -> [usize; 3] {
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

pub fn sound(sets: &[Set]) {
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

/// Share of the planted mistakes that are told at least: a turned axis of a joint whose torque couples with no other changes nothing in the data,
/// and a scale or a lag cannot be seen where neither inertia nor weight is.
const TOLD: f64 = 0.9;
/// Share that may be told as something else.
const WRONG: f64 = 0.02;

pub fn mostly_told([right, silent, wrong]: [usize; 3]) {
    let all = (right + silent + wrong) as f64;
    assert!(right as f64 >= TOLD * all && wrong as f64 <= WRONG * all, "{right} right, {silent} silent, {wrong} wrong");
}

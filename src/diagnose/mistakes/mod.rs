//! Mistakes in the data or in the model file that are likelier than physics, told before anything is fitted.
//!
//! ```text
//!   sessions ─ time_base ─ dead ─ kinematics ─ encoder ─┬─▶ mistakes
//!      rows ─▶ balance ─▶ search ─ limits ─ overload ───┘
//! ```
//! The first instrument that finds something ends the search: what follows would see its consequences.
//!
//! | module | compares | right | mistaken |
//! |---|---|---|---|
//! | `time_base` | sample interval, velocity | below 0.1 s, `Δq = ∫ v dt` on all joints | one factor on all joints |
//! | `dead` | a channel with the others of its joint | moves as they do | constant |
//! | `kinematics` | `Δq` with `∫ v dt` | 1, no lag | −1, π/180, π/30, gear ratio; late |
//! | `encoder` | steps of the position with a count | 1 | gear ratio, 180/π |
//! | `balance`, `search` | torque with inertia, weight and friction | leaves some percent of the squares | a single change of data or model halves the RMS that is left, to that of sound data |
//! | `limits` | position with the joint's range | inside | several times its range |
//! | `overload` | torque with the limits of the drive | below | ten times that or more |
//! | `remaining` | error of the finished diagnosis with the torque | below half | above |

mod balance;
mod change;
mod dead;
mod encoder;
mod kinematics;
mod limits;
mod meaning;
mod overload;
pub(super) mod remaining;
mod rows;
mod search;
mod time_base;
mod velocity;
mod words;

use crate::diagnose::options::Options;
pub use crate::diagnose::result::Mistake;
use crate::diagnose::result::{Diagnosis, Method, Parts};
use crate::robot::{Masses, Model};
use crate::timeseries::TimeSeries;

/// Mistakes that are likelier than physics; empty where data and model are what they say they are, as far as the data show.
pub fn suspected(model: &Model, sessions: &[&TimeSeries]) -> Vec<Mistake> {
    if model.joints.is_empty() {
        return Vec::new();
    }
    if let Some(mistake) = time_base::found(model, sessions) {
        return vec![mistake];
    }
    let dead = words::dead(model, &dead::found(model, sessions));
    if !dead.is_empty() {
        return dead;
    }
    let velocities = velocity::found(model, sessions);
    if !velocities.is_empty() {
        return merged(velocities);
    }
    let counts = words::counts(model, sessions);
    if !counts.is_empty() {
        return merged(counts);
    }
    let rows = rows::rows(model, sessions);
    let outside = limits::outside(model, sessions);
    let overloads = overload::found(model, &rows);
    let timed = velocity::confirms_time(model, sessions);
    let found = match model.masses {
        // The balance of a guess knows no scale.
        Masses::Estimated if !limits::unconfirmed(model, &rows, &outside).is_empty() => Vec::new(),
        _ => search::found(model, &rows, timed, &search::Limits { outside: &outside, overloads: &overloads }),
    };
    if found.is_empty() {
        let impossible = overloads.iter().filter(|one| one.times() > overload::IMPOSSIBLE);
        let from_current = rows.iter().all(|session| session.from_current);
        let torques = impossible.map(|one| words::overload(model, from_current, one));
        let limits = limits::unconfirmed(model, &rows, &outside).into_iter().map(|one| words::limits(model, one));
        return merged(limits.chain(torques).collect());
    }
    merged(found.iter().map(|one| words::balance(model, &rows, one)).collect())
}

/// Mistakes as warnings, one sentence or two each.
pub fn warnings(mistakes: &[Mistake]) -> Vec<String> {
    mistakes.iter().map(Mistake::sentence).collect()
}

/// The diagnosis that ends with a suspicion: nothing is fitted, and the model stays as it was given.
pub fn diagnosis(model: &Model, mistakes: Vec<Mistake>, compared: bool, options: &Options) -> Diagnosis {
    let none = || "not used: a mistake is suspected, and nothing was fitted".to_owned();
    let method = Method { filter: none(), half_width: [0.0; 2], zones: none(), baseline: none(), held_out: none() };
    let parts = Parts::new(model, method, &options.catalogue);
    Parts { mistakes, changes: compared.then(Vec::new), ..parts }.assembled()
}

/// Mistakes of one name and remedy as one.
fn merged(mistakes: Vec<Mistake>) -> Vec<Mistake> {
    let mut merged: Vec<Mistake> = Vec::new();
    for mistake in mistakes {
        match merged.iter_mut().find(|one| one.mistake == mistake.mistake && one.remedy == mistake.remedy) {
            Some(one) => {
                one.joints.extend(mistake.joints);
                one.evidence += &format!(" {}", mistake.evidence);
            }
            None => merged.push(mistake),
        }
    }
    merged
}

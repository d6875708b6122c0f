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
mod overload;
pub(super) mod remaining;
mod rows;
mod search;
mod time_base;
mod velocity;
mod words;

use std::collections::BTreeMap;

use serde::Serialize;

use super::Options;
use super::result::{Diagnosis, Method, Verdict};
use crate::robot::{Masses, Model};
use crate::timeseries::TimeSeries;

/// A mistake in the data or in the model file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mistake {
    /// Its name: `sign_of_current`, `gear_ratio` and so on.
    pub mistake: &'static str,
    /// Joints that it concerns.
    pub joints: Vec<String>,
    /// By what the channel or the number of the model file has to be multiplied, where it is a factor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub factor: Option<f64>,
    /// What was measured.
    pub evidence: String,
    /// What to change, in which file.
    pub remedy: String,
    /// Other mistakes that these data cannot tell from it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<&'static str>,
}

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
        Masses::Estimated if !limits::found(model, &rows, &outside).is_empty() => Vec::new(),
        _ => search::found(model, &rows, timed, &search::Limits { outside: &outside, overloads: &overloads }),
    };
    if found.is_empty() {
        let impossible = overloads.iter().filter(|one| one.times() > overload::IMPOSSIBLE);
        let from_current = rows.iter().all(|session| session.from_current);
        let torques = impossible.map(|one| words::overload(model, from_current, one));
        return merged(limits::found(model, &rows, &outside).into_iter().chain(torques).collect());
    }
    merged(found.iter().map(|one| words::balance(model, &rows, one)).collect())
}

/// Mistakes as warnings, one sentence or two each.
pub fn warnings(mistakes: &[Mistake]) -> Vec<String> {
    mistakes.iter().map(Mistake::sentence).collect()
}

impl Mistake {
    /// The mistake, what was measured and what to change.
    pub fn sentence(&self) -> String {
        let or: Vec<String> = self.alternatives.iter().map(|other| format!(" or {other}")).collect();
        format!(
            "{}{} suspected on {}. {} Remedy: {}.",
            self.mistake,
            or.concat(),
            self.joints.join(", "),
            self.evidence,
            self.remedy
        )
    }
}

/// The diagnosis that ends with a suspicion: nothing is fitted, and the model stays as it was given.
pub fn diagnosis(model: &Model, mistakes: Vec<Mistake>, compared: bool, options: &Options) -> Diagnosis {
    let none = || "not used: a mistake is suspected, and nothing was fitted".to_owned();
    Diagnosis {
        schema: Diagnosis::SCHEMA,
        versions: BTreeMap::from([
            ("lostmotion", env!("CARGO_PKG_VERSION")),
            ("rapier3d", crate::plant::RAPIER_VERSION),
        ]),
        verdict: Verdict::MistakeSuspected,
        mistakes,
        effects: Vec::new(),
        changes: compared.then(Vec::new),
        fit: Vec::new(),
        replay: Vec::new(),
        baseline: BTreeMap::new(),
        two_encoders: Vec::new(),
        unexplained: Vec::new(),
        withdrawn: Vec::new(),
        candidates: Vec::new(),
        method: Method { filter: none(), half_width: [0.0; 2], zones: none(), baseline: none(), held_out: none() },
        shares: Vec::new(),
        maps: Vec::new(),
        order_spectrum: Vec::new(),
        frequency_spectrum: Vec::new(),
        extended_model: model.clone(),
        baseline_model: model.clone(),
        catalogue: options.catalogue.clone(),
        series: Vec::new(),
    }
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

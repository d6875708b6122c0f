//! Recordings and rows → mistakes in the data or in the model file that are likelier than physics, reported before anything is fitted.
//!
//! ```text
//!   sessions ─ time_base ─ dead ─ kinematics ─ encoder ────────────┬─▶ mistakes
//!      rows ─▶ balance ─▶ search ─ lag ─ size ─ limits ─ overload ─┘
//! ```
//! The first check that finds a mistake ends the search, because later checks would see its consequences.
//!
//! | module | compares | right | mistaken |
//! |---|---|---|---|
//! | `time_base` | sample interval, velocity | below 0.1 s, `Δq = ∫ v dt` on all joints | one common factor on all joints |
//! | `dead` | a channel with the others of its joint | moves as they do | constant, or noise |
//! | `kinematics` | `Δq` with `∫ v dt` | 1, no lag | −1, π/180, π/30, gear ratio; late |
//! | `encoder` | steps of the position with a count | 1 | gear ratio, 180/π |
//! | `balance`, `search` | torque with inertia, weight, friction | leaves a few percent of the squares | one change halves the RMS residual |
//! | `lag` | torque with the motion some time earlier or later | fits best at the same time | fits best 0.15 to 0.5 s off |
//! | `size` | torque with inertia and weight, whatever the friction | of the model's size | several times larger or smaller |
//! | `limits` | position with the joint's range | inside | several times its range |
//! | `overload` | torque with the limits of the drive | below | ten times that or more |
//! | `remaining` | the finished diagnosis with what is possible | error below half of the torque, torque constants within a factor of two | above |
//!
//! Before all of them, `guessed` replaces torque constants that the model file calls guesses, by the `factors` that the balance of all joints gives and by what
//! they say of a scale. `rows` makes the rows of the balance, `change` has the changes that the search tries, `velocity` and `meaning` interpret the ratio of position and velocity, and `words` and `corrections` write name, evidence and
//! remedy of a mistake.

mod balance;
mod change;
mod corrections;
mod dead;
mod encoder;
mod factors;
pub(super) mod guessed;
mod kinematics;
mod lag;
mod limits;
mod meaning;
mod overload;
pub(super) mod remaining;
mod rows;
mod search;
mod size;
mod time_base;
mod velocity;
mod words;

use std::borrow::Cow;

use change::Culprit;

use crate::diagnose::options::Options;
pub use crate::diagnose::result::Mistake;
use crate::diagnose::result::{Diagnosis, Method, Parts};
use crate::diagnose::rows::division::Division;
use crate::robot::{Masses, Model};
use crate::timeseries::{Channel, JointSeries, TimeSeries};

/// Mistakes in the recordings of a diagnosis, which end it before anything is fitted.
///
/// The search reads the training data alone, as the fit does: a column, a unit or a sign is the same to the end of a file. Sessions that are held
/// out whole are files of their own; if the training data are right, they are checked too, by themselves. What is found there only tells that
/// the file cannot judge a model. It does not reach the fit, whose data and model are what they are without it. The scale of a guessed torque
/// constant is no such mistake.
pub fn suspected_by_part(model: &Model, sessions: &[&TimeSeries], division: Division) -> Vec<Mistake> {
    let beside_guesses = |sessions: &[&TimeSeries]| {
        let mut found = suspected(model, sessions);
        found.retain(|mistake| !guessed::is_of_guess(model, sessions, mistake));
        found
    };
    let training = training_parts(sessions, division);
    let found = beside_guesses(&training.iter().map(AsRef::as_ref).collect::<Vec<_>>());
    if found.is_empty() { beside_guesses(&sessions[division.trained()..]) } else { found }
}

/// The training data: whole sessions, or what is not held out of them.
fn training_parts<'s>(sessions: &[&'s TimeSeries], division: Division) -> Vec<Cow<'s, TimeSeries>> {
    let trained = &sessions[..division.trained()];
    let parts = |(number, session): (usize, &&'s TimeSeries)| {
        let parts = division.training(number, session).into_iter().filter(|part| !part.is_empty());
        parts.map(|part| Cow::Owned(session.part(part))).collect::<Vec<_>>()
    };
    match division.by_session() {
        true => trained.iter().map(|session| Cow::Borrowed(*session)).collect(),
        false => trained.iter().enumerate().flat_map(parts).collect(),
    }
}

/// Mistakes that are likelier than physics; empty where the data contradict neither the stated units and signs nor the model.
pub fn suspected(model: &Model, sessions: &[&TimeSeries]) -> Vec<Mistake> {
    if model.joints.is_empty() || sessions.is_empty() {
        return Vec::new();
    }
    // Nothing is known of a pause: its two sides are checked like two sessions.
    let parts: Vec<Cow<TimeSeries>> = sessions.iter().flat_map(|session| session.uninterrupted()).collect();
    let sessions: &[&TimeSeries] = &parts.iter().map(AsRef::as_ref).collect::<Vec<_>>();
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
        // With estimated masses the balance does not determine a scale.
        Masses::Estimated if !limits::unconfirmed(model, &rows, &outside).is_empty() => Vec::new(),
        _ => culprits(model, &rows, timed, &search::Limits { outside: &outside, overloads: &overloads }),
    };
    if found.is_empty() {
        let impossible = overloads.iter().filter(|one| one.times() > overload::IMPOSSIBLE);
        let from_current = rows.iter().all(|session| session.from_current);
        let torques = impossible.map(|one| words::overload(model, from_current, one));
        let limits = limits::unconfirmed(model, &rows, &outside).into_iter().map(|one| words::limits(model, one));
        return merged(limits.chain(torques).collect());
    }
    merged(found.iter().map(|one| corrections::balance(model, &rows, one)).collect())
}

/// All changes that the torque balance demands, the strongest first; each is searched with those before it applied.
fn culprits(model: &Model, rows: &[rows::Rows], timed: bool, limits: &search::Limits<'_>) -> Vec<Culprit> {
    let (mut model, mut rows) = (model.clone(), rows.to_vec());
    let mut found: Vec<Culprit> = Vec::new();
    while found.len() <= model.joints.len() {
        let best = search::best(&model, &rows, timed, limits);
        let best = best.or_else(|| lag::best(&model, &rows)).or_else(|| size::best(&model, &rows));
        let Some(best) = best.filter(|best| found.iter().all(|one| one.change != best.change)) else { break };
        (model, rows) = best.change.undone(&model, &rows);
        found.push(best);
    }
    found
}

/// Recordings without the dead channels, and a mistake for each of these channels. This is a check of every recording, held-out ones included: it
/// decides which joints have a torque to be judged by, and nothing else. A joint without a torque is left out of a diagnosis, and a
/// velocity is only compared with the position. A dead position is kept: nothing is known of the arm's posture without it. All channels are
/// kept if otherwise no joint would have a torque.
pub fn without_dead_channels<'s>(
    model: &Model,
    sessions: &[&'s TimeSeries],
) -> (Vec<Cow<'s, TimeSeries>>, Vec<Mistake>) {
    let mut kept: Vec<Cow<TimeSeries>> = sessions.iter().map(|session| Cow::Borrowed(*session)).collect();
    let mut removed = dead::found(model, sessions);
    removed.retain(|dead| dead.channel != Channel::Position);
    for dead in &removed {
        for session in kept.iter_mut().filter(|session| session.name == dead.session) {
            let joints = session.to_mut().joints.iter_mut();
            joints.filter(|joint| joint.name == model.joints[dead.joint].name).for_each(|joint| {
                joint.channels.remove(&dead.channel);
            });
        }
    }
    let has_torque = |name: &str| {
        let torque = [Channel::Current, Channel::Torque, Channel::LinkTorque];
        let of_joint = |joint: &JointSeries| torque.iter().any(|channel| joint.get(*channel).is_some());
        kept.iter().all(|session| session.joint(name).is_some_and(of_joint))
    };
    if !removed.is_empty() && !model.joints.iter().any(|joint| has_torque(&joint.name)) {
        return (sessions.iter().map(|session| Cow::Borrowed(*session)).collect(), Vec::new());
    }
    (kept, words::dead(model, &removed))
}

/// Mistakes as warnings of one or two sentences each.
pub fn warnings(mistakes: &[Mistake]) -> Vec<String> {
    mistakes.iter().map(Mistake::sentence).collect()
}

/// The diagnosis that ends with a suspected mistake: nothing is fitted, and the model stays unchanged.
pub fn diagnosis(model: &Model, mistakes: Vec<Mistake>, compared: bool, options: &Options) -> Diagnosis {
    let none = || "not used: a mistake is suspected, and nothing was fitted".to_owned();
    let method = Method {
        filter: none(),
        half_width: [0.0; 2],
        zones: none(),
        baseline: none(),
        held_out: none(),
        left_out: Vec::new(),
        listed_effects: Vec::new(),
    };
    let parts = Parts::new(model, method, &options.catalogue);
    Parts { mistakes, changes: compared.then(Vec::new), ..parts }.assembled()
}

/// Merges mistakes of the same name and remedy.
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

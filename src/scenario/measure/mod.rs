//! Plans the experiment that measures friction and gaps best within a given time: the shortest experiment for a given accuracy.
//!
//! ```text
//!   one joint after the other:   sweeps through speeds, slowest first      friction     `sweep`
//!                                strokes with gentle reversals             gap          `strokes`
//! ```
//! What an experiment tells is its Fisher information (`information`); the plan has the smallest expected variance that was found. Every joint has
//! the same time. If both quantities are asked for, the time is divided such that the mean of `ln var` over the coefficients of friction and
//! `ln var` of the gap have the smallest sum: a per cent gained in friction counts as a per cent gained in the gap. If the gap alone is asked
//! for, the sweeps are as short as an identification allows, because its estimate of the gap needs the friction of the same joint.
//!
//! Friction that the model does not have is guessed, as for a [first experiment](super::first_experiment()), with a wide range of `v_S`; that guess
//! decides how gentle a reversal is.

mod course;
mod information;
mod posture;
mod question;
mod regulation;
mod strokes;
mod sweep;
mod text;
mod uniform;

use std::path::Path;

use serde::Serialize;

pub use question::Measurands;

use super::Scenario;
use super::reach::{Reach, reaches};
use super::rehearsal::{check_effort, references, with_friction};
use crate::error::{Error, Place, Result};
use crate::robot::Model;
use course::{Course, Setup};
use posture::{Posture, postures};

/// [s] Longest experiment that is planned: ten hours.
const LONGEST: f64 = 36_000.0;

/// Expected relative errors of a joint, one standard deviation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExpectedErrors {
    /// [1] Of `F_C`, `F_S`, `v_S`, `F_V`: root mean square of both directions.
    pub friction: [f64; 4],
    /// [rad or m] Of the gap; `None` where no reversal is planned for it, or the encoder is exact.
    pub gap: Option<f64>,
}

/// What is planned for a joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlannedJoint {
    /// Its name.
    pub joint: String,
    /// Whether its friction is that of the model; otherwise it is a guess.
    pub friction_known: bool,
    /// [rad/s or m/s] Speeds of a sweep.
    pub speeds: Vec<f64>,
    /// [s] For which each is constant.
    pub durations: Vec<f64>,
    /// Sweeps in each direction.
    pub sweeps: usize,
    /// Reversals for the gap.
    pub reversals: usize,
    /// [rad or m] Posture in which its sweeps begin, one position per joint of the model.
    pub posture: Vec<f64>,
    /// [s] Of all its recordings.
    pub seconds: f64,
    /// What it is expected to measure.
    pub expected: ExpectedErrors,
    /// The same for the paper's uniform staircase of the same length; `None` where the time is too short for one.
    pub uniform: Option<ExpectedErrors>,
}

/// A planned measurement as files.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measurement {
    /// The joints, in the order in which they are moved.
    pub joints: Vec<PlannedJoint>,
    /// [s] Of all recordings.
    pub seconds: f64,
    /// The scenario file; the model is `model.toml` beside it.
    #[serde(skip)]
    pub scenario: String,
    /// Name and content of a CSV file of references per recording.
    #[serde(skip)]
    pub references: Vec<(String, String)>,
}

/// Plans the measurement of a machine within `seconds`.
///
/// # Errors
/// The time is too short (the error gives the shortest), a joint has no room, or every posture leaves the limits of a joint or lets links
/// collide.
pub fn measurement(model: &Model, asked: &Measurands, seconds: f64) -> Result<Measurement> {
    let refused = |expected: String| {
        Error::input("command line".as_ref(), Place::File, "budget", format!("{seconds} s"), expected)
    };
    if !(seconds > 0.0 && seconds <= LONGEST) {
        return Err(refused(format!("a number > 0 and ≤ {LONGEST} [s]")));
    }
    let reaches = reaches(model);
    let machine = with_friction(model, &reaches);
    let setups: Vec<Setup> = (0..model.joints.len()).map(|index| Setup::of(model, &machine, &reaches, index)).collect();
    if let Some(stuck) = asked.joints.iter().find(|&&index| !setups[index].has_room()) {
        let key = format!("joint {}: limits lower and upper", model.joints[*stuck].name);
        return Err(Error::input(&model.urdf, Place::File, key, "", "room for six speeds in one direction"));
    }
    let number = asked.joints.len() as f64;
    let mut parts = Vec::new();
    for &index in &asked.joints {
        let Some(course) = setups[index].best(asked, seconds / number) else {
            let shortest = asked.joints.iter().map(|&index| setups[index].shortest(asked)).fold(0.0, f64::max);
            let least = (shortest * number).ceil();
            return Err(refused(format!("at least {least} s for {} of {number} joints", asked.words())));
        };
        let posture = allowed(model, &reaches, &setups, (index, &course))?;
        parts.push((index, course, posture));
    }
    let scenario = text::scenario(model, &reaches, &setups, &parts, asked.words());
    let read = Scenario::of_model(&scenario, Path::new("scenario.toml"), model)?;
    read.check_motion()?;
    let references = read.sessions.iter().map(|one| (format!("{}.csv", one.name), references(model, one))).collect();
    let joints = parts.into_iter().map(|(index, course, posture)| setups[index].planned(model, &course, posture));
    Ok(Measurement {
        joints: joints.collect(),
        seconds: read.sessions.iter().map(|session| session.duration).sum(),
        scenario,
        references,
    })
}

/// The best posture in which the recordings of a joint keep all limits and links keep apart.
fn allowed(model: &Model, reaches: &[Reach], setups: &[Setup], (index, course): (usize, &Course)) -> Result<Posture> {
    let setup = &setups[index];
    let ways = [course.sweep.way(&setup.bounds), setup.strokes.way()];
    let mut refused = None;
    for posture in postures(model, reaches, index, ways, setup.possible.smallest_coulomb()) {
        let part = [(index, course.clone(), posture.clone())];
        let read =
            Scenario::of_model(&text::scenario(model, reaches, setups, &part, ""), Path::new("scenario.toml"), model)?;
        let efforts = || read.sessions.iter().try_for_each(|session| check_effort(model, session));
        match read.check_motion().and_then(|()| efforts()) {
            Ok(()) => return Ok(posture),
            Err(error) => refused = Some(error),
        }
    }
    let none = || Error::input(&model.urdf, Place::File, "", "", "joints that have room to move");
    Err(refused.unwrap_or_else(none))
}

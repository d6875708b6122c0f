//! Friction and backlash from motor-side time series, after L. Márton and B. Lantos (2009).

/// The gap, equation 15 and better estimators.
pub mod backlash;
/// Other methods of the literature on the same data.
pub mod methods;
/// Measurement points, equation 11.
pub mod points;
/// The paper's own estimators, as published.
pub mod published;
/// What an identification returns.
pub mod result;
/// The trend of parameters over repeated identifications.
pub mod trend;

mod balance;
mod fit;
mod law;
mod least_squares;
mod motion;
mod quantity;
mod rigid_body;
mod signals;
mod signs;
pub(crate) mod statistics;
mod summary;
mod windows;

pub(crate) use motion::{EDGE, SMALL_MODEL_ERROR};

pub use backlash::BacklashIdentification;
pub use methods::{Method, MethodEstimate};
pub use points::Point;
pub use published::{PublishedEstimates, PublishedFriction};
pub use quantity::Quantity;
pub use result::{
    ExponentialEstimate, FrictionIdentification, Identification, JointIdentification, LawKind, LinesEstimate,
    NotIdentified, PerDirection,
};

use std::borrow::Cow;

use balance::{Balance, Balanced};
use fit::Observation;
use motion::Track;
use published::AveragePoint;
use rayon::prelude::*;
use rigid_body::RigidBody;
use statistics::median;
use summary::Laws;

use crate::error::{Error, Result};
use crate::gearhead::{Direction, Friction, FrictionLaw, Lines};
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries, pauses};

/// Channels that an identification reads; all others may be dropped.
pub const CHANNELS: [Channel; 7] = [
    Channel::Position,
    Channel::Velocity,
    Channel::Current,
    Channel::Torque,
    Channel::ReferencePosition,
    Channel::ReferenceVelocity,
    Channel::CommandCurrent,
];

/// What can be chosen about an identification; the defaults suit the paper's staircase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// [s] Shortest steady window that makes a measurement point, > 0.
    pub shortest_window: f64,
    /// [s] Part at the start of each constant-velocity stretch that is left out as transient, ≥ 0.
    pub settling_time: f64,
    /// Whether the gap is measured too.
    pub backlash: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { shortest_window: 0.3, settling_time: 0.6, backlash: true }
    }
}

/// Points that a joint needs in each direction: a law has four coefficients, and one point must be left to judge it.
const FEWEST_POINTS: usize = 5;

/// Identifies friction and gap of every joint of the model that the data move at constant velocities.
///
/// # Errors
/// The data hold too few steady windows of every joint.
pub fn identify(model: &Model, data: &[TimeSeries], options: &Options) -> Result<Identification> {
    let (mut joints, mut left_out) = (Vec::new(), Vec::new());
    let mut first_error = None;
    // One joint's serial parts run beside another joint's.
    let all: Vec<_> =
        (0..model.joints.len()).into_par_iter().map(|joint| identify_joint(model, joint, data, options)).collect();
    for (joint, found) in all.into_iter().enumerate() {
        match found {
            Ok(found) => joints.push(found),
            Err(error) => {
                if moves_steadily(model, joint, data, options) {
                    left_out.push(NotIdentified { joint: model.joints[joint].name.clone(), reason: error.to_string() });
                }
                first_error = first_error.or(Some(error));
            }
        }
    }
    match first_error {
        Some(error) if joints.is_empty() => Err(error),
        _ => Ok(Identification { joints, left_out }),
    }
}

/// Whether any session moves a joint at constant velocity, as an experiment on it does.
fn moves_steadily(model: &Model, joint: usize, data: &[TimeSeries], options: &Options) -> bool {
    let sessions = signals::of_sessions(model, joint, data).unwrap_or_default();
    sessions.iter().any(|(_, signals)| !windows::find(signals, options).is_empty())
}

/// Identifies friction and gap of the joint of this index.
///
/// # Errors
/// The data hold too few steady windows of this joint.
pub fn identify_joint(
    model: &Model,
    joint: usize,
    data: &[TimeSeries],
    options: &Options,
) -> Result<JointIdentification> {
    let mut notes = Vec::new();
    let parts: Vec<TimeSeries>;
    let paused = data.iter().any(|session| !pauses(&session.time).is_empty());
    let data = if paused {
        parts = data.iter().flat_map(TimeSeries::uninterrupted).map(Cow::into_owned).collect();
        &parts
    } else {
        data
    };
    let (mut points, tracks) = measurement_points(model, joint, data, options, &mut notes)?;
    let balance = Balance::new(&points, tracks);
    let laws = balanced(&model.joints[joint].name, &balance, &mut points, &mut notes)?;
    let (friction, centrifugal) = summary::friction(model.joints[joint].kind, &points, &laws);
    let backlash = if options.backlash {
        let sessions: Vec<&TimeSeries> = data.iter().collect();
        let link_share = model.joints[joint].friction.map_or(0.0, |friction| friction.link_share);
        match backlash::identify(model, joint, &sessions, &Friction { law: friction.preferred_law(), link_share }) {
            Ok(found) => Some(found),
            Err(error) => {
                notes.push(error.to_string());
                None
            }
        }
    } else {
        None
    };
    let published = published_estimates(model, joint, data, options)?;
    let other = |method: &Method| method.estimate(model, joint, data, &friction);
    let methods = if options.backlash { Method::ALL.iter().filter_map(other).collect() } else { Vec::new() };
    let (joint, kind) = (model.joints[joint].name.clone(), model.joints[joint].kind);
    Ok(JointIdentification { joint, kind, friction, centrifugal, backlash, published, methods, points, notes })
}

/// The measurement points of a joint in all sessions.
fn measurement_points(
    model: &Model,
    joint: usize,
    data: &[TimeSeries],
    options: &Options,
    notes: &mut Vec<String>,
) -> Result<(Vec<Point>, Vec<Track>)> {
    let (mut points, mut tracks) = (Vec::new(), Vec::new());
    for (session, mut signals) in signals::of_sessions(model, joint, data)? {
        let rigid = RigidBody::new(model, joint, &data[session]);
        let doubtful = if signals.rectified {
            let gravity = rigid.gravity_along(0..signals.position.len());
            let certain = signs::recover(&mut signals, &gravity);
            notes.push(format!(
                "{}: the sign of the current was not measured; it follows from motion and gravity",
                data[session].name
            ));
            certain.iter().map(|certain| !certain).collect()
        } else {
            Vec::new()
        };
        for window in windows::find(&signals, options) {
            if doubtful.iter().skip(window.start).take(window.end - window.start).any(|doubt| *doubt) {
                continue;
            }
            points.push(Point::of(session, &signals, &rigid, window));
            tracks.push(Track::of(&signals, &rigid, window));
        }
    }
    let forward = points.iter().filter(|point| point.velocity > 0.0).count();
    if forward.min(points.len() - forward) < FEWEST_POINTS {
        return Err(too_few(model, joint, &points));
    }
    Ok((points, tracks))
}

/// The paper's own estimates, from the windows and sessions that give the measurement points.
fn published_estimates(
    model: &Model,
    joint: usize,
    data: &[TimeSeries],
    options: &Options,
) -> Result<PublishedEstimates> {
    let (mut points, mut moving) = (Vec::new(), Vec::new());
    for (session, signals) in signals::of_sessions(model, joint, data)? {
        let rigid = RigidBody::new(model, joint, &data[session]);
        let windows = windows::find(&signals, options);
        points.extend(windows.iter().map(|window| AveragePoint::of(&signals, &rigid, *window)));
        if options.backlash && !windows.is_empty() {
            moving.push(signals);
        }
    }
    Ok(published::estimates(model.joints[joint].kind, &points, moving))
}

/// Fits both laws to the balance, and the preferred one also with `C_ii` free. If `C_ii` differs from zero, it stays in the law.
///
/// # Errors
/// One of the laws fits neither the balance nor the averages of the windows.
fn balanced(joint: &str, balance: &Balance, points: &mut [Point], notes: &mut Vec<String>) -> Result<Laws> {
    let averages: Vec<Observation> = points.iter().map(Observation::of).collect();
    let misfit = |found: &Option<Balanced>| found.as_ref().map_or(f64::INFINITY, |found| found.misfit);
    let law_of = |kind: LawKind| law::of(kind, &fit::to(kind, &averages, false)?.fit.parameters);
    let refined = |kind: LawKind, guesses: &[Option<FrictionLaw>]| {
        let found = guesses.iter().flatten().map(|guess| balance.refine(kind, guess));
        found.min_by(|a, b| misfit(a).total_cmp(&misfit(b))).flatten()
    };
    // No single start is always good: averages of windows with a transient show no fall with speed, flat friction has no stick-slip,
    // and the low line depends on a few slow windows. So the start that ends best counts.
    let guesses = [Some(flat(points)), law_of(LawKind::Exponential), law_of(LawKind::TwoLines)];
    let mut exponential = refined(LawKind::Exponential, &guesses);
    let curved = exponential.as_ref().and_then(|found| law::of(LawKind::Exponential, &found.law.fit.parameters));
    let mut lines = refined(LawKind::TwoLines, &[curved, guesses[0], guesses[1], guesses[2]]);
    let preferred = if misfit(&lines) < misfit(&exponential) { LawKind::TwoLines } else { LawKind::Exponential };
    let best = if preferred == LawKind::TwoLines { &mut lines } else { &mut exponential };
    let mut with_centrifugal = None;
    if let Some(found) = best {
        with_centrifugal = balance.with_centrifugal(found);
        if let Some(law) = with_centrifugal.as_ref().filter(|law| summary::centrifugal_is_real(law))
            && let Some(under) = balance.under(law.clone())
        {
            notes.push("C_ii differs from zero: it is kept in the friction law's fit".to_owned());
            *found = under;
        }
        found.correct(points);
    }
    let mut law = |kind: LawKind, found: Option<Balanced>| match found {
        Some(found) => Ok(found.law),
        None => {
            notes.push(format!(
                "{kind:?}: no torque balance over the motion was found; the averages of steady windows are used"
            ));
            fit::to(kind, &averages, false)
                .ok_or_else(|| Error::NoFrictionLaw { joint: joint.to_owned(), windows: averages.len() })
        }
    };
    let lines = law(LawKind::TwoLines, lines)?;
    let exponential = law(LawKind::Exponential, exponential)?;
    let best = if preferred == LawKind::TwoLines { &lines } else { &exponential };
    let with_centrifugal = with_centrifugal.unwrap_or_else(|| best.clone());
    Ok(Laws { lines, exponential, preferred, with_centrifugal })
}

/// Friction that is the same at all speeds: the median of each direction's points. No more is known before the motion is reconstructed.
fn flat(points: &[Point]) -> FrictionLaw {
    FrictionLaw::TwoLines([Direction::Positive, Direction::Negative].map(|direction| {
        let side = points.iter().filter(|point| point.direction() == direction);
        let level = median(side.map(|point| (direction.sign() * point.friction).max(0.0)).collect());
        Lines { a1: level, b1: 0.0, a2: level, b2: 0.0 }
    }))
}

/// The error of a joint that was not moved at enough velocities.
fn too_few(model: &Model, joint: usize, points: &[Point]) -> Error {
    let forward = points.iter().filter(|point| point.velocity > 0.0).count();
    Error::TooLittleData {
        quantity: "friction",
        joint: model.joints[joint].name.clone(),
        found: forward.min(points.len() - forward),
        unit: "steady windows per direction",
        needed: FEWEST_POINTS,
        advice: "move the joint at several constant velocities in both directions, as the staircase does; `diagnose` takes other motions too",
    }
}

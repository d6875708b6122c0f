//! Meaning of the ratio of position and velocity: a unit, a sign, an angle of the motor, a time base, or a late channel.

use super::balance;
use super::change::Change;
use super::kinematics;
use super::kinematics::{FAR, LATE, LATE_VELOCITY, Ratio};
use super::meaning::{Meaning, SAME, meaning};
use super::{rows, words};
use crate::diagnose::result::Mistake;
use crate::drive::Sensing;
use crate::robot::Model;
use crate::timeseries::{Channel, TimeSeries};

/// [1] Factor of the time base above which it is a mistake: clocks and nominal sample rates differ by far less.
const STRETCHED: f64 = 1.03;
/// [1] Correlation above which a ratio is known well enough for that: both differ by less than a tenth of their size.
const CLEAR: f64 = 0.995;
/// [1] Relative difference up to which the ratios of all joints are one factor: a ratio with the correlation [`CLEAR`] over two hundred stretches has
/// a standard error of 0.7 %.
const EXACTLY: f64 = 0.01;
/// A late channel explains at least this share of what remains without the lag.
const BETTER: f64 = 0.5;

/// [1] A delay leaves less than this share of what a low-pass leaves, if the channel is late as a whole. Both leave the noise, and the share that two
/// hundred stretches give is known within a tenth.
const SHAPED: f64 = 0.8;

/// The velocity to compare with: the measured one, or the reference, which a controlled joint follows.
pub fn of(model: &Model, joint: usize, sessions: &[&TimeSeries]) -> Option<(Channel, Ratio)> {
    [Channel::Velocity, Channel::ReferenceVelocity]
        .into_iter()
        .find_map(|channel| Some((channel, kinematics::ratio(model, joint, sessions, channel)?)))
}

/// Whether a velocity channel agrees with the position on some joint, so that the time base is right.
pub fn confirms_time(model: &Model, sessions: &[&TimeSeries]) -> bool {
    (0..model.joints.len()).any(|joint| of(model, joint, sessions).is_some_and(|(_, ratio)| ratio.agrees()))
}

/// All mistakes between position and velocity.
pub fn found(model: &Model, sessions: &[&TimeSeries]) -> Vec<Mistake> {
    let ratios: Vec<Option<(Channel, Ratio)>> =
        (0..model.joints.len()).map(|joint| of(model, joint, sessions)).collect();
    let wrong: Vec<(usize, Channel, Ratio)> = ratios
        .iter()
        .enumerate()
        .filter_map(|(joint, found)| found.map(|(channel, ratio)| (joint, channel, ratio)))
        .filter(|(.., ratio)| ratio.at_lag < 0.0 || ratio.ratio.abs().ln().abs() > FAR.ln())
        .collect();
    if wrong.is_empty() {
        let late = late(model, sessions, &ratios);
        return if late.is_empty() { stretched(model, &ratios) } else { late };
    }
    if let Some(factor) = of_time(model, sessions, &ratios) {
        return vec![words::time_base(model, &wrong, factor)];
    }
    wrong.iter().map(|one| of_joint(model, sessions, *one)).collect()
}

/// The factor of the time base, where all joints have the same one and it is not a unit of their channels.
fn of_time(model: &Model, sessions: &[&TimeSeries], ratios: &[Option<(Channel, Ratio)>]) -> Option<f64> {
    let all: Vec<(usize, f64)> =
        ratios.iter().enumerate().filter_map(|(joint, found)| Some((joint, found.as_ref()?.1.ratio))).collect();
    let first = all.first()?.1;
    let alike = first > 0.0 && all.iter().all(|(_, ratio)| *ratio > 0.0 && (ratio / first).ln().abs() < SAME);
    let named = all.iter().all(|(joint, ratio)| meaning(model, *joint, *ratio) != Meaning::Unknown);
    // With one joint and one velocity, the reference velocity decides whether the factor is one of the velocity channel.
    let reference = |joint: usize| kinematics::ratio(model, joint, sessions, Channel::ReferenceVelocity);
    let by_reference = all.iter().all(|(joint, ratio)| {
        reference(*joint).is_none_or(|other| other.ratio > 0.0 && (other.ratio / ratio).ln().abs() < 2.0 * SAME)
    });
    (alike && !named && by_reference).then_some(first)
}

/// A time base that is off by less than a factor of [`FAR`]: the measured velocities of several joints say the same. A filter or a delay leaves
/// the change of position over whole moves as it is.
fn stretched(model: &Model, ratios: &[Option<(Channel, Ratio)>]) -> Vec<Mistake> {
    let clear: Vec<(usize, Channel, Ratio)> = ratios
        .iter()
        .enumerate()
        .filter_map(|(joint, found)| found.map(|(channel, ratio)| (joint, channel, ratio)))
        .filter(|(_, channel, ratio)| *channel == Channel::Velocity && ratio.at_lag > CLEAR)
        .collect();
    let [(.., first), _, ..] = clear.as_slice() else { return Vec::new() };
    let factor = first.ratio;
    let alike = clear.iter().all(|(.., ratio)| (ratio.ratio / factor).ln().abs() < EXACTLY);
    if alike && factor.ln().abs() > STRETCHED.ln() { vec![words::time_base(model, &clear, factor)] } else { Vec::new() }
}

/// The mistake of one joint whose velocity and position differ.
fn of_joint(model: &Model, sessions: &[&TimeSeries], (joint, channel, ratio): (usize, Channel, Ratio)) -> Mistake {
    let meaning = meaning(model, joint, ratio.ratio);
    let turned = meaning == Meaning::Sign && {
        let rows = rows::rows(model, sessions);
        let moves = |session: usize, joint: usize, row: usize| rows[session].joints[joint].moves[row];
        let left = |model: &Model, rows: &[rows::Rows]| {
            balance::balances(model, rows, &moves)[joint].map_or(1.0, |one| one.left)
        };
        let (other, undone) = Change::MotionSign(joint).undone(model, &rows);
        left(&other, &undone) < left(model, &rows)
    };
    words::velocity(model, joint, channel, &ratio, meaning, turned)
}

/// Channels that are late.
fn late(model: &Model, sessions: &[&TimeSeries], ratios: &[Option<(Channel, Ratio)>]) -> Vec<Mistake> {
    let of_joint = |(joint, found): (usize, &Option<(Channel, Ratio)>)| {
        let (channel, ratio) = (*found)?;
        let left = |correlation: f64| 1.0 - correlation * correlation;
        let clear = channel == Channel::Velocity && left(ratio.at_lag) < BETTER * left(ratio.correlation);
        // A current without a sign gets that of the velocity: if the velocity is late, the sign is wrong around reversals.
        let signs = model.joints[joint].current_sensor.is_some_and(|sensor| sensor.sensing == Sensing::Absolute);
        let may_be_filtered = ratio.lag > 0.0 && ratio.lag < LATE_VELOCITY && !signs;
        let filtered = || {
            let low_passed = kinematics::behind_low_pass(model, joint, sessions, channel);
            left(ratio.at_lag) > SHAPED * left(low_passed)
        };
        (clear && ratio.lag.abs() >= LATE && !(may_be_filtered && filtered()))
            .then(|| words::late_velocity(model, joint, &ratio))
    };
    ratios.iter().enumerate().filter_map(of_joint).collect()
}

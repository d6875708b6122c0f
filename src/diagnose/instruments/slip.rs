//! A coupling that slips: rotor and link are displaced against each other, at the same time since the start of several sessions.
//!
//! ```text
//!   D(t) = 2T²/(h₊ + h₋) ((θ(t+h₊) − θ(t))/h₊ − (θ(t) − θ(t−h₋))/h₋)        h₊, h₋: the times of samples nearest to T
//!   by the motor alone 0 … τ T²/J, rotor alone;   e: excess of D beyond this range, minus two counts · T²/(h₊ h₋)
//!   during a slip all else is slow:   J Δθ + I Δq = 0,   Δq − Δθ = δ ± b   ⇒   Δθ = −(δ ± b) I/(I + J)
//! ```
//! The lighter rotor takes most of the slip. Where in its gap `b` the link is, and whether it bounces to the other flank, is unknown, so
//! that sessions differ. Flanks that meet at a reversal move the rotor abruptly too, but less, and only where the joint reverses.
//! A throw that shows in one session only may be a knock from outside and is not named. Throws are sought in the training sessions; the gain is
//! the reduction of the largest throw of the held-out sessions without the slip. If no separate session is held out, nothing confirms the
//! slip, and it is reported as unexplained.
//! Sign: a positive `δ` puts the link ahead of the rotor, which is thrown back.
//! `D` is the second difference `θ(t+T) − 2θ(t) + θ(t−T)` where samples lie at even times; elsewhere it contains no velocity either.
//! Left out: slips that take longer than `T`; places where samples are missing on either side.
//! Reference: M. Nordin, P.-O. Gutman (2002), Controlling mechanical systems with backlash, a survey, for rotor and link as two masses.

use std::ops::Range;

use rayon::prelude::*;

use super::claims::{Sighting, claimed};
use super::{FittedRows, Instrument, Measurement};
use crate::diagnose::evidence::probability::calibrated;
use crate::diagnose::result::EffectGain;
use crate::diagnose::rows::inertia::typical_inertia;
use crate::diagnose::rows::observe::motor_torque;
use crate::diagnose::rows::sampling::Sampling;
use crate::effects::Phenomenon;
use crate::error::Result;
use crate::replay::Gain;
use crate::robot::{Masses, Model};
use crate::timeseries::{Channel, Estimate, TimeSeries};

/// `T` [s].
const STEP: f64 = 8e-3;
/// Possible error of `D` in encoder counts where `h₊ = h₋ = T`: three readings of half a count each.
const BLUR: f64 = 2.0;
/// [steps] Largest difference of `h₊` and `h₋` from `T`: the nearest sample is half a step off, or one step where steps are twice as long.
const ASTRAY: f64 = 0.9;
/// Counts above this error that a throw needs.
const LEAST: f64 = 3.0;
/// Least ratio to any other throw of its session. Flanks that meet at reversals of clean machines (tuning seeds 1000 to 1005)
/// reach 1.2 mrad, slips of half a gap 3.3 (tuning seed 2900).
const STANDS_OUT: f64 = 3.0;
/// [s] Largest distance between throws of one slip.
const TOGETHER: f64 = 0.03;
/// [s] Time before and after a throw that belongs to it: rotor and controller oscillate.
const AROUND: [f64; 2] = [0.05, 0.5];
/// Least number of sessions that show it.
const FEWEST: usize = 2;
/// [s] Time before a throw from which its motion is extrapolated.
const BEFORE: [f64; 2] = [0.08, 0.03];
/// Part of the distance of a throw at which its time is taken.
const QUARTER: f64 = 0.25;
/// [s] Time from the start of a slip to that point, and its error (tuning seeds 2800 to 2803, 2900, 2901: 6 to 10 ms).
const ONSET: [f64; 2] = [0.007, 0.004];
/// Part of a slip by which a rotor that rebounds from a flank may be thrown too far (tuning seeds 2801, 2803: half of it).
const REBOUND: f64 = 0.3;

/// A step of a link against its rotor: its coupling slips once.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Step {
    /// Index of the joint.
    pub joint: usize,
    /// `δ` [rad or m].
    pub jump: Estimate,
    /// [s] Time since the start of the session.
    pub time: Estimate,
    /// Probability that throws in this many sessions do not coincide by chance.
    pub probability: f64,
    /// Probability that throws in this many sessions coincide by chance.
    pub chance: f64,
    /// Number of sessions that show it.
    pub sessions: usize,
}

/// A throw: an abrupt displacement of a rotor.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Throw {
    session: usize,
    joint: usize,
    /// [s] Time since the start of the session.
    time: f64,
    /// `e` [rad or m].
    excess: f64,
}

/// The instrument for slips of a link against its rotor.
pub struct Slip;

impl Instrument<FittedRows<'_>> for Slip {
    fn measure(&self, scene: &FittedRows) -> Result<Measurement> {
        let FittedRows { problem, sessions, division, .. } = *scene;
        let model = problem.motion.model;
        if model.masses == Masses::Estimated {
            return Ok(Measurement::default());
        }
        let with_rotor = typical_inertia(model).into_iter().zip(&model.joints);
        let link: Vec<f64> = with_rotor.map(|(inertia, joint)| inertia - joint.reflected_inertia()).collect();
        let (trained, held_out) = sessions.split_at(division.trained());
        let parts: Vec<Vec<Range<usize>>> =
            trained.iter().enumerate().map(|(number, session)| division.training(number, session)).collect();
        let sighting = |one: Step| Sighting {
            phenomenon: Phenomenon::Step { jump: one.jump, time: one.time },
            joints: vec![one.joint],
            probability: one.probability,
            evidence_nats: -one.chance.max(1e-300).ln(),
            gain: gain(model, &one, held_out).map(|gain| EffectGain::of(gain, "throws of the rotor")),
            words: in_words(model, &one),
        };
        let sightings = steps(model, trained, &parts, &link).into_iter().map(sighting).collect();
        Ok(Measurement { findings: claimed(model, &problem.catalogue, sightings), ..Measurement::default() })
    }
}

/// Description of a slip that no held-out data can confirm.
fn in_words(model: &Model, one: &Step) -> String {
    let joint = &model.joints[one.joint];
    let (unit, Step { jump, time, sessions, .. }) = (joint.kind.position_unit(), one);
    format!(
        "link and rotor are displaced against each other by {:.2e} ± {:.1e} {unit} at {:.2} s in {sessions} sessions; hold out a further session to confirm it",
        jump.value, jump.std_error, time.value
    )
}

/// Gain in the largest throw of the held-out sessions without the slip; `None` where no session is held out.
///
/// Both throws are known to one count of the encoder, which gives the ends of the interval.
fn gain(model: &Model, one: &Step, held_out: &[&TimeSeries]) -> Option<Gain> {
    let count = model.joints[one.joint].encoder_step();
    let largest = |session: &&TimeSeries, of_step: bool| {
        let whole = 0..session.len();
        let throws = of_place(model, one.joint, 0, std::slice::from_ref(session), std::slice::from_ref(&whole));
        let picked = throws.into_iter().filter(|throw| belongs(throw, one.time.value) == of_step);
        picked.map(|throw| throw.excess).fold(0.0, f64::max)
    };
    let percent = |with: f64, without: f64| 100.0 * (1.0 - without.max(0.0) / with.max(without).max(1e-300));
    let of_session = |session: &&TimeSeries| {
        let (step, rest) = (largest(session, true), largest(session, false));
        let with = step.max(rest);
        let interval_percent = [percent(with - count, rest + count), percent(with + count, rest - count)];
        Gain { gain_percent: percent(with, rest), interval_percent, shown: interval_percent[0] > 0.0 }
    };
    // Every session has to show the slip: the smallest gain counts.
    held_out.iter().map(of_session).min_by(|a, b| a.gain_percent.total_cmp(&b.gain_percent))
}

/// Slips, the strongest of each joint first. `link` is the inertia that each joint moves, without its rotor.
/// `parts`: samples of each session that are searched.
fn steps(model: &Model, sessions: &[&TimeSeries], parts: &[Vec<Range<usize>>], link: &[f64]) -> Vec<Step> {
    let places: Vec<(usize, usize)> =
        (0..sessions.len()).flat_map(|session| (0..model.joints.len()).map(move |joint| (session, joint))).collect();
    let mut throws: Vec<Throw> = places
        .par_iter()
        .flat_map_iter(|(session, joint)| of_place(model, *joint, *session, sessions, &parts[*session]))
        .collect();
    let mut found = Vec::new();
    // A slip shakes other joints too: take it where it is largest, then ignore it on all joints.
    while let Some((joint, members)) = strongest(model, &throws) {
        found.extend(measured(model, sessions, link, joint, &members));
        throws.retain(|throw| !belongs(throw, members[0].time));
    }
    found
}

fn belongs(throw: &Throw, time: f64) -> bool {
    throw.time > time - AROUND[0] && throw.time < time + AROUND[1]
}

/// Largest separate throws of one joint in parts of one session.
fn of_place(
    model: &Model,
    joint: usize,
    session: usize,
    sessions: &[&TimeSeries],
    parts: &[Range<usize>],
) -> Vec<Throw> {
    let recorded = sessions[session];
    let rotor = model.joints[joint].reflected_inertia();
    let blur = BLUR * model.joints[joint].encoder_step();
    let dt = recorded.sample_interval();
    let Some(series) = recorded.joint(&model.joints[joint].name) else { return Vec::new() };
    let position = series.get(Channel::Position);
    let torque = motor_torque(model, joint, series, series.get(Channel::Velocity));
    let (Some(q), Some((torque, _))) = (position, torque) else { return Vec::new() };
    let lag = (STEP / dt).round();
    if !(1.0..q.len() as f64 / 4.0).contains(&lag) || rotor <= 0.0 || blur <= 0.0 {
        return Vec::new();
    }
    let lag = lag as usize;
    let sampling = Sampling::new(&recorded.time, dt);
    let long = parts.iter().flat_map(|part| sampling.within(part)).filter(|piece| piece.len() >= 4 * lag);
    let bends = Bends { time: &recorded.time, q, torque: &torque, dt, step: lag as f64 * dt, rotor, blur };
    let place = |(k, excess)| Throw { session, joint, time: recorded.time[k] - recorded.time[0], excess };
    separate(long.flat_map(|part| bends.of(part)).map(place))
}

/// Displacements of a rotor, sample by sample.
struct Bends<'s> {
    time: &'s [f64],
    q: &'s [f64],
    torque: &'s [f64],
    /// [s] Median step.
    dt: f64,
    /// `T` [s].
    step: f64,
    rotor: f64,
    blur: f64,
}

impl Bends<'_> {
    /// Samples of an uninterrupted part whose `e` is positive, with `e` [rad or m].
    fn of(&self, part: Range<usize>) -> Vec<(usize, f64)> {
        let Self { time, torque, dt, step, .. } = *self;
        let mut found = Vec::new();
        let (mut before, mut after, mut sum) = (part.start, part.start, torque[part.start]);
        let fits = |h: f64| (h - step).abs() < ASTRAY * dt;
        for k in part.clone() {
            while time[before] < time[k] - step - 0.5 * dt {
                sum -= torque[before];
                before += 1;
            }
            while after + 1 < part.end && time[after] < time[k] + step - 0.5 * dt {
                after += 1;
                sum += torque[after];
            }
            let h = [time[after] - time[k], time[k] - time[before]];
            if h.into_iter().all(fits) {
                let excess = self.excess([before, k, after], h, sum / (after - before + 1) as f64);
                if excess > 0.0 {
                    found.push((k, excess));
                }
            }
        }
        found
    }

    /// `e` from three samples, `[h₊, h₋]` apart, and the mean torque between them.
    fn excess(&self, [before, k, after]: [usize; 3], [ahead, behind]: [f64; 2], torque: f64) -> f64 {
        let (q, square) = (self.q, self.step * self.step);
        let driven = torque / self.rotor * square;
        let slopes = (q[after] - q[k]) / ahead - (q[k] - q[before]) / behind;
        let bent = 2.0 * square / (ahead + behind) * slopes;
        (bent - driven.max(0.0)).max(driven.min(0.0) - bent) - self.blur * square / (ahead * behind)
    }
}

/// The largest throws that are apart from each other.
fn separate(all: impl Iterator<Item = Throw>) -> Vec<Throw> {
    let mut throws: Vec<Throw> = Vec::new();
    for throw in all {
        match throws.last_mut() {
            Some(last) if throw.time < last.time + 2.0 * TOGETHER => {
                if throw.excess > last.excess {
                    *last = throw;
                }
            }
            _ => throws.push(throw),
        }
    }
    throws
}

/// The largest throws that coincide in several sessions, where each exceeds the others of its session; the largest first.
fn strongest(model: &Model, throws: &[Throw]) -> Option<(usize, Vec<Throw>)> {
    let stands_out = |throw: &&Throw| {
        let others = throws.iter().filter(|other| other.session == throw.session && other.joint == throw.joint);
        let others = others.filter(|other| !belongs(other, throw.time) && !belongs(throw, other.time));
        let most = others.map(|other| other.excess).fold(0.0, f64::max);
        throw.excess > (STANDS_OUT * most).max(LEAST * model.joints[throw.joint].encoder_step())
    };
    let good: Vec<&Throw> = throws.iter().filter(stands_out).collect();
    let meeting = |seed: &&Throw| {
        let mut members: Vec<Throw> = Vec::new();
        let near = |throw: &&Throw| throw.joint == seed.joint && (throw.time - seed.time).abs() < TOGETHER;
        for throw in good.iter().copied().filter(near) {
            match members.iter_mut().find(|member| member.session == throw.session) {
                Some(member) if member.excess < throw.excess => *member = *throw,
                Some(_) => {}
                None => members.push(*throw),
            }
        }
        members.sort_by(|a, b| b.excess.total_cmp(&a.excess));
        members
    };
    let total = |members: &Vec<Throw>| members.iter().map(|throw| throw.excess).sum::<f64>();
    let all = good.iter().map(meeting).filter(|members| members.len() >= FEWEST);
    let best = all.max_by(|a, b| total(a).total_cmp(&total(b)))?;
    Some((best[0].joint, best))
}

/// Size and time of a slip; `None` where the throws disagree about its direction.
fn measured(model: &Model, sessions: &[&TimeSeries], link: &[f64], joint: usize, members: &[Throw]) -> Option<Step> {
    let rotor = model.joints[joint].reflected_inertia();
    let begin = members.iter().map(|throw| throw.time).fold(f64::INFINITY, f64::min);
    let seen: Vec<(usize, [f64; 2])> = (0..sessions.len())
        .filter_map(|session| Some((session, thrown(model, joint, sessions[session], begin)?)))
        .collect();
    let shown = |session: usize| members.iter().any(|throw| throw.session == session);
    let mut onsets: Vec<f64> =
        seen.iter().filter(|(session, _)| shown(*session)).map(|(_, [onset, _])| *onset).collect();
    onsets.sort_by(f64::total_cmp);
    let onset = *onsets.get(onsets.len() / 2)?;
    let sizes = seen.iter().map(|(_, [_, by])| -by * (link[joint] + rotor) / link[joint]);
    let (low, high) = sizes.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), by| (low.min(by), high.max(by)));
    let value = 0.5 * (low + high);
    let of_members = seen.iter().filter(|(session, _)| shown(*session)).map(|(_, [_, by])| *by);
    let agreed = of_members.clone().all(|by| by * value < 0.0);
    let count = model.joints[joint].encoder_step();
    // A throw of any session may coincide with that of another by chance within this part of its length.
    let duration = |session: &&TimeSeries| match (session.time.first(), session.time.last()) {
        (Some(first), Some(last)) => last - first,
        _ => 0.0,
    };
    let length = sessions.iter().map(duration).fold(f64::INFINITY, f64::min);
    let chance = (2.0 * TOGETHER / length.max(1.0)).powi(members.len() as i32 - 1) * sessions.len() as f64;
    agreed.then_some(Step {
        joint,
        jump: Estimate { value, std_error: (0.5 * (high - low)).hypot(REBOUND * value).max(count) },
        time: Estimate { value: (onset - ONSET[0]).max(0.0), std_error: ONSET[1] },
        probability: calibrated(chance),
        chance,
        sessions: members.len(),
    })
}

/// Time at which a rotor leaves its path near a given time, and the distance that it moves [s, rad or m].
fn thrown(model: &Model, joint: usize, session: &TimeSeries, near: f64) -> Option<[f64; 2]> {
    let q = session.joint(&model.joints[joint].name)?.get(Channel::Position)?;
    let start = *session.time.first()?;
    let at = |t: f64| session.time.partition_point(|time| time - start < t);
    let [a, b] = [at(near - BEFORE[0]), at(near - BEFORE[1])];
    let (first, last) = (b, at(near + BEFORE[1]).min(q.len()));
    if b <= a || last <= first || near > session.time.last()? - start - BEFORE[1] {
        return None;
    }
    let speed = (q[b] - q[a]) / (session.time[b] - session.time[a]);
    let away = |k: usize| q[k] - q[b] - speed * (session.time[k] - session.time[b]);
    let most = (first..last).map(away).max_by(|x, y| x.abs().total_cmp(&y.abs()))?;
    let onset = (first..last).find(|k| away(*k) / most > QUARTER)?;
    Some([session.time[onset] - start, most])
}

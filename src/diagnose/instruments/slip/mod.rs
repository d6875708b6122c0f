//! A coupling that slips: rotor and link are displaced against each other, at the same time since the start of several sessions.
//!
//! ```text
//!   during a slip all else is slow:   J Δθ + I Δq = 0,   Δq − Δθ = δ ± b   ⇒   Δθ = −(δ ± b) I/(I + J)
//! ```
//! The lighter rotor takes most of the slip. Where in its gap `b` the link is, and whether it bounces to the other flank, is unknown, so
//! that sessions differ: on one flank a slip smaller than the gap throws nothing. Flanks that meet at a reversal move the rotor abruptly too; they are
//! ordinary, and tell how large [throws] are in any window of a session.
//!
//! The largest throw of one session sets a time. Every session says which share `p` of its windows has as large a throw as it has then. `n` sessions
//! coincide by chance with Fisher's `P(χ²(2n) > 2 Σ E)`, `E = −ln p`, times the number of windows and joints that were searched. A throw that shows in
//! one session only may be a knock from outside: no `E` counts beyond what it takes to find a window, and what the next session says of it.
//! Sessions that move alike at that time, or begin or end a rest together, have their reversals together and do not count twice. Nor do sessions that
//! end then, as arms are stopped where a programme ends.
//!
//! The gain is that of the throw at this time in the held-out sessions, compared with ordinary windows. Where they show none, the link may have been on
//! the other flank: the gain is then that of the training sessions which did not set the time. If no separate session is held out, nothing
//! confirms the slip, and it is reported as unexplained.
//! Sign: a positive `δ` puts the link ahead of the rotor, which is thrown back.
//! Left out: slips that take longer than 8 ms; places where samples are missing on either side.
//! - `throws`: abrupt displacements of a rotor, and what is ordinary; `size`: jump and time of a slip
//!
//! References: M. Nordin, P.-O. Gutman (2002), Controlling mechanical systems with backlash, a survey, for rotor and link as two masses; R. A.
//! Fisher (1932), Statistical Methods for Research Workers, § 21.1.

mod size;
#[cfg(test)]
mod tests;
mod throws;

use rayon::prelude::*;

use self::throws::Throws;
use super::claims::{Sighting, claimed};
use super::{FittedRows, Instrument, Measurement};
use crate::diagnose::evidence::probability::calibrated;
use crate::diagnose::result::EffectGain;
use crate::diagnose::rows::inertia::typical_inertia;
use crate::distributions::chi_squared_upper_tail;
use crate::effects::Phenomenon;
use crate::error::Result;
use crate::replay::Gain;
use crate::robot::{Masses, Model};
use crate::timeseries::{Channel, Estimate, TimeSeries};

/// Probability of a coincidence below which it is none: one healthy machine in a hundred with any name, shared by some 30 effects.
const CHANCE: f64 = 3e-4;
/// Share of ordinary windows with as large a throw, below which a session shows a slip: the upper end of a 95 % interval.
const SHOWN: f64 = 0.025;
/// Least number of sessions that show it.
const FEWEST: usize = 2;
/// [s] Time before and after a throw over which two sessions are compared, in this number of steps.
const COMPARED: f64 = 0.25;
const STEPS: i32 = 10;
/// [1] Part of a motion by which two sessions differ that move alike, and at most which there is of it in a rest.
const ALIKE: f64 = 0.1;
/// [1] Multiple of a throw that a joint moves within the time of the comparison after a rest: a rotor that was only thrown stays where it is.
const MOVES: f64 = 5.0;

/// A step of a link against its rotor: its coupling slips once.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Step {
    /// Index of the joint.
    joint: usize,
    /// `δ` [rad or m].
    jump: Estimate,
    /// [s] Time since the start of the session.
    time: Estimate,
}

/// Throws that coincide in several sessions.
#[derive(Debug, Clone, PartialEq)]
struct Coincidence {
    joint: usize,
    /// The session whose throw set the time.
    first: usize,
    /// [s] Its time since the start of the session.
    time: f64,
    /// The sessions that tell, and their share `p`.
    shares: Vec<(usize, f64)>,
    /// Probability that the throws coincide by chance.
    chance: f64,
}

impl Coincidence {
    /// The sessions that show it.
    fn sessions(&self) -> Vec<usize> {
        self.shares.iter().filter(|(_, share)| *share < SHOWN).map(|(session, _)| *session).collect()
    }
}

/// The throws of some sessions, `throws[session][joint]`.
struct Searched<'s> {
    model: &'s Model,
    sessions: &'s [&'s TimeSeries],
    throws: Vec<Vec<Option<Throws>>>,
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
        let (trained, held_out) = sessions.split_at(division.trained());
        let trained = Searched::new(model, trained, |number, session| division.training(number, session));
        let held_out = Searched::new(model, held_out, |_, session| std::iter::once(0..session.len()).collect());
        let sightings = trained.coincidences().iter().filter_map(|one| sighting(&trained, &held_out, one)).collect();
        Ok(Measurement { findings: claimed(model, &problem.catalogue, sightings), ..Measurement::default() })
    }
}

/// What a coincidence says; `None` where its throws disagree about the direction of the slip.
fn sighting(trained: &Searched, held_out: &Searched, one: &Coincidence) -> Option<Sighting> {
    let (model, shown) = (trained.model, one.sessions());
    let link = typical_inertia(model)[one.joint] - model.joints[one.joint].reflected_inertia();
    let step = size::measured(model, trained.sessions, link, one.joint, &shown, trained.begin(one, &shown))?;
    Some(Sighting {
        phenomenon: Phenomenon::Step { jump: step.jump, time: step.time },
        joints: vec![one.joint],
        probability: calibrated(one.chance),
        evidence_nats: -one.chance.max(1e-300).ln(),
        gain: (!held_out.sessions.is_empty()).then(|| gain(trained, held_out, one)),
        words: in_words(model, &step, shown.len()),
    })
}

/// Description of a slip that no held-out data can confirm.
fn in_words(model: &Model, Step { joint, jump, time }: &Step, sessions: usize) -> String {
    format!(
        "link and rotor are displaced against each other by {:.2e} ± {:.1e} {} at {:.2} s in {sessions} sessions; hold out a further session to confirm it",
        jump.value,
        jump.std_error,
        model.joints[*joint].kind.position_unit(),
        time.value
    )
}

/// Gain on the held-out sessions; on the training sessions that did not set the time, where the held-out ones show none.
fn gain(trained: &Searched, held_out: &Searched, one: &Coincidence) -> EffectGain {
    let all: Vec<usize> = (0..held_out.sessions.len()).collect();
    let confirmed = held_out.gain(one, &all);
    let others = one.shares.iter().map(|(session, _)| *session).filter(|session| *session != one.first);
    match trained.gain(one, &others.collect::<Vec<_>>()) {
        elsewhere if elsewhere.shown && !confirmed.shown => {
            EffectGain::of(elsewhere, "throws of the rotor, in training sessions at the time that another one shows")
        }
        _ => EffectGain::of(confirmed, "throws of the rotor"),
    }
}

impl<'s> Searched<'s> {
    fn new(
        model: &'s Model,
        sessions: &'s [&'s TimeSeries],
        parts: impl Fn(usize, &TimeSeries) -> Vec<std::ops::Range<usize>> + Sync,
    ) -> Self {
        let of_session = |(number, session): (usize, &&TimeSeries)| {
            let parts = parts(number, session);
            (0..model.joints.len()).map(|joint| Throws::of(model, joint, session, &parts)).collect()
        };
        let throws = sessions.par_iter().enumerate().map(of_session).collect();
        Self { model, sessions, throws }
    }

    /// The coincidences that are none of chance, the clearest first.
    fn coincidences(&self) -> Vec<Coincidence> {
        let (mut found, mut times): (Vec<Coincidence>, Vec<f64>) = (Vec::new(), Vec::new());
        let places =
            (0..self.sessions.len()).flat_map(|session| (0..self.model.joints.len()).map(move |j| (session, j)));
        let places: Vec<(usize, usize)> = places.collect();
        loop {
            let seen = places.par_iter().filter_map(|(session, joint)| {
                let (one, evidence) = self.coincidence(*joint, *session, &times)?;
                (one.chance < CHANCE && one.sessions().len() >= FEWEST).then_some((one, evidence))
            });
            // A slip shakes other joints too: take it where all sessions together show it most, then ignore it on all joints.
            let Some((best, _)) = seen.max_by(|(_, a), (_, b)| a.total_cmp(b)) else { break };
            times.push(best.time);
            found.push(best);
        }
        found
    }

    /// Of the largest throw of a joint in a session, outside the times around earlier ones; with the evidence `Σ E` of all sessions. `None` where no
    /// other session can tell.
    fn coincidence(&self, joint: usize, first: usize, earlier: &[f64]) -> Option<(Coincidence, f64)> {
        let time = self.throws[first][joint].as_ref()?.largest(earlier)?;
        let (_, thrown) = self.throws[first][joint].as_ref()?.near(time)?;
        let own_motion = |other: &usize| *other == first || !self.alike(joint, [first, *other], time, thrown);
        let told = (0..self.sessions.len()).filter(own_motion).filter_map(|session| {
            let throws = self.throws[session][joint].as_ref()?;
            let (_, throw) = throws.near(time)?;
            let ordinary = throws.ordinary(time, earlier)?;
            Some((session, ordinary.share_beyond(throw), ordinary.windows()))
        });
        let told: Vec<(usize, f64, usize)> = told.collect();
        let windows = told.iter().map(|(_, _, windows)| *windows).max()? as f64;
        let mut evidence: Vec<f64> = told.iter().map(|(_, share, _)| -share.ln()).collect();
        evidence.sort_by(|a, b| b.total_cmp(a));
        let all: f64 = evidence.iter().sum();
        let next = evidence.get(1)?;
        let counted = all - (evidence[0] - windows.ln() - next).max(0.0);
        let by_chance = chi_squared_upper_tail(2.0 * counted, 2.0 * told.len() as f64);
        let chance = (windows * self.model.joints.len() as f64 * by_chance).min(1.0);
        let shares = told.into_iter().map(|(session, share, _)| (session, share)).collect();
        Some((Coincidence { joint, first, time, shares, chance }, all))
    }

    /// Whether a joint moves alike around a time in two sessions, or begins or ends a rest in both, by more than it is `thrown` [rad or m]; also where a
    /// session does not tell, because it ends.
    fn alike(&self, joint: usize, pair: [usize; 2], time: f64, thrown: f64) -> bool {
        let [Some(a), Some(b)] = pair.map(|session| self.path(session, joint, time)) else { return true };
        let squares = |path: &[f64]| path.iter().map(|q| q * q).sum::<f64>();
        let apart: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
        let together = squares(&apart) < ALIKE * ALIKE * squares(&a).max(squares(&b));
        // Whether it rests before and after, beside what it moves in all.
        let rests = [&a, &b].map(|path| {
            let moves = path.iter().any(|q| q.abs() > MOVES * thrown);
            let (before, after) = path.split_at(path.len() / 2);
            [before, after].map(|half| moves && squares(half) < ALIKE * ALIKE * squares(path))
        });
        together || (0..2).any(|half| rests.iter().all(|rests| rests[half]))
    }

    /// [rad or m] Motion of a joint around a time, relative to where it is then; `None` where it was not recorded.
    fn path(&self, session: usize, joint: usize, time: f64) -> Option<Vec<f64>> {
        let recorded = self.sessions[session];
        let q = recorded.joint(&self.model.joints[joint].name)?.get(Channel::Position)?;
        let start = recorded.time.first()?;
        let at = |k: i32| {
            let later = time + COMPARED * f64::from(k) / f64::from(STEPS);
            q.get(recorded.time.partition_point(|t| t - start < later)).copied()
        };
        let middle = at(0)?;
        (-STEPS..=STEPS).map(|k| Some(at(k)? - middle)).collect()
    }

    /// [s] When the first of the throws of these sessions is.
    fn begin(&self, one: &Coincidence, sessions: &[usize]) -> f64 {
        let throws = sessions.iter().filter_map(|session| self.throws[*session][one.joint].as_ref()?.near(one.time));
        throws.map(|(time, _)| time).fold(f64::INFINITY, f64::min)
    }

    /// By how much the throw at the time of a slip exceeds ordinary ones, in that of these sessions which shows it best.
    fn gain(&self, one: &Coincidence, sessions: &[usize]) -> Gain {
        let share = SHOWN / sessions.len().max(1) as f64;
        let of_session = |session: &usize| {
            let throws = self.throws[*session][one.joint].as_ref()?;
            let (_, throw) = throws.near(one.time).filter(|(_, throw)| *throw > 0.0)?;
            let ordinary = throws.ordinary(one.time, &[])?;
            let less = |share: f64| 100.0 * (1.0 - ordinary.exceeded_by(share) / throw);
            let interval_percent = [less(share), less(1.0 - share)];
            Some(Gain { gain_percent: less(0.5), interval_percent, shown: interval_percent[0] > 0.0 })
        };
        let gains = sessions.iter().filter_map(of_session);
        gains.max_by(|a, b| a.interval_percent[0].total_cmp(&b.interval_percent[0])).unwrap_or_default()
    }
}

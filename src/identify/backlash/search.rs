//! Where the gap is: found at a resolution at which it is a few counts, then at finer and finer ones, down to the counts of the encoder.
//!
//! A gap of a thousand counts cannot be sought count by count. Near none, a reversal's window ends before the flank is reached, and so much is free
//! there that it may be explained. And a model is not exact to a count of a fine encoder: at that resolution it explains no reversal. So the readings
//! are first taken as those of a coarse encoder, whose windows reach the largest gap looked for. Each finer level looks near the gap of the one before,
//! at the reversals that it explained. The result is that of the level with the least error ([`pool`]): finer readings count while the model keeps up
//! with them. Where the error of the link's share of friction may be a large part of the gap's, that share is found anew for this level (`share`).

use super::Untold;
use super::ensemble::Spread;
use super::fit::{Fit, Known, Profile, count_likelier, eased, grid, median, pool, pooled_best, scan, share};
use super::result::{LeftOut, NORMAL_95, Reason, SEEN};
use super::reversal::{FEWEST, Session};
use super::share::settle;
use super::transmission::Transmission;
use super::window::{Site, sites};
use crate::gearhead::Friction;
use crate::identify::quantity::Quantity;
use crate::robot::{JointModel, Model};

/// Ratio of the resolutions of two levels.
const RATIO: f64 = 4.0;
/// Most counts of the largest gap at the coarsest level.
const RANGE: f64 = 30.0;
/// Counts to either side of a gap that is known about.
const NEAR: f64 = 8.0;
/// Counts to either side of the gap of the scan over the whole range, whose step is two counts.
const FIRST: f64 = 4.0;
/// Counts to either side of the gap of the level before: two of that level.
const NEXT: f64 = 2.0 * RATIO;
/// Counts that a window reaches beyond the largest gap tried.
const BEYOND: f64 = 4.0;
/// Standard errors by which the gaps of two levels may differ.
const DIFFER: f64 = 3.0;
/// Counts to either side of the gap of the last scan of a level, and its step.
const CLOSE: f64 = 2.5;
const CLOSE_STEP: f64 = 0.25;
/// Counts from gap to gap where only the likelihood of a share is wanted.
const SHARE_STEP: f64 = 0.5;
/// [1] Standard deviation of friction about its law, as machines have that differ from their model: the rotor's place at its turn is then known to a count.
const USUAL_LEVEL: f64 = 0.08;
/// The same of machines that are as their model, with the blur of a count and the temper for it. Of the arm of scenario 01, 0.04 and 0.005 leave more of the
/// error that depends on the phase of a count, or more reversals unexplained.
const SHARP_LEVEL: f64 = 0.02;
const SHARP_BLUR: f64 = 0.05;
const SHARP_TEMPER: f64 = 0.5;
/// [1] Link share before anything is known of it, and its standard deviation.
const ANY_SHARE: [f64; 2] = [0.3, 0.2];
/// The same of the share of the reversals at a level.
const CLOSE_SHARE: f64 = 0.05;
/// Deviation of a link share that is held: the guesses have to differ a little, so that one reversal may.
const HELD: f64 = 0.02;

/// Whether gravity leaves enough reversals for a gap to be measured, however small the link's share of friction is.
pub(super) fn is_level(sessions: &[Session], joint: &JointModel, friction: &Friction) -> bool {
    let all = sessions.iter().flat_map(|session| sites(session, joint, friction, 0.0, 1.0));
    all.filter(|site| !site.carried(Known::default().least_share)).count() >= FEWEST
}

/// Fits the gap to all reversals of the sessions, sought anywhere or near a known one; beside it the standard error of the part of it that may be wind-up
/// [rad or m].
///
/// # Errors
/// Why they do not tell it.
pub(super) fn fit(
    sessions: &[Session],
    model: &Model,
    friction: &Friction,
    known: Known,
) -> Result<(Fit, f64), Untold> {
    let joint = &model.joints[sessions.first().ok_or(Untold::ByReversals)?.joint];
    let mut search = Search::new(sessions, joint, friction, known).ok_or(Untold::ByReversals)?;
    let fit = match known.gap {
        Some(near) => search.look_near(near).and_then(|()| search.at_level(0, FIRST)).ok_or(Untold::ByReversals)?,
        None => {
            let coarsest = search.coarsest();
            search.look_anywhere(coarsest).ok_or(Untold::ByReversals)?;
            search.descend(coarsest)?
        }
    };
    let wind_up = search.wind_up_error(model.accuracy.stiffness, fit.share.value);
    Ok((fit, wind_up))
}

/// Which reversal of the sessions: its time and its deceleration.
type Key = (f64, f64);

fn key(site: &Site) -> Key {
    (site.time, site.deceleration)
}

/// The state of a search.
struct Search<'s> {
    sessions: &'s [Session<'s>],
    joint: &'s JointModel,
    friction: &'s Friction,
    known: Known,
    /// [N·m or N] of the torque.
    noise: f64,
    /// [rad or m] count of the encoder.
    finest: f64,
    /// [rad or m] largest gap looked for.
    largest: f64,
    spread: Spread,
    /// [rad or m] where the gap seems to be.
    gap: f64,
    /// Reversals that no gap explained at a coarser level.
    given_up: Vec<Key>,
    /// Reversals that some gap explains better than others, whichever that is: a wrong gap may leave those that contradict it without a preference.
    asked: Option<usize>,
}

impl<'s> Search<'s> {
    /// `None` without a reversal that the load leaves free.
    fn new(sessions: &'s [Session], joint: &'s JointModel, friction: &'s Friction, known: Known) -> Option<Self> {
        let all = sessions.iter().flat_map(|session| sites(session, joint, friction, 0.0, 1.0));
        let finest = all.into_iter().find(|site| !site.carried(known.least_share))?.window.count;
        let noise = sessions.iter().map(|session| session.signals.torque_noise).fold(0.0, f64::max);
        let spread = Spread {
            members: if known.gap.is_some() { 32 } else { 16 },
            share: known.share.map_or(ANY_SHARE, |share| [share, HELD]),
            level: 0.05,
            level_time: 0.1,
            torque: 4.0 * noise,
            blur: 0.2,
            temper: 0.15,
        };
        let largest = largest_gap(sessions);
        let (gap, given_up, asked) = (0.0, Vec::new(), None);
        Some(Self { sessions, joint, friction, known, noise, finest, largest, spread, gap, given_up, asked })
    }

    /// The level at which the largest gap is at most [`RANGE`] counts; level 0 is that of the encoder.
    fn coarsest(&self) -> i32 {
        let ratio = self.largest / (RANGE * self.finest);
        ratio.max(1.0).log(RATIO).ceil() as i32
    }

    /// [rad or m] A count of a level.
    fn count(&self, level: i32) -> f64 {
        self.finest * RATIO.powi(level)
    }

    /// The reversals of a level with windows that reach so far, and those at which the load rests on one flank.
    fn sites(&self, travel: f64, level: i32) -> (Vec<Site>, Vec<Site>) {
        let of = |session| sites(session, self.joint, self.friction, travel, RATIO.powi(level));
        self.sessions.iter().flat_map(of).partition(|site| !site.carried(self.known.least_share))
    }

    /// Takes up what a scan tells of the gap and, within a deviation, of the share; `None` where it explains no reversal.
    fn take(&mut self, gaps: &[f64], profiles: &[Profile], deviation: f64) -> Option<()> {
        self.gap = gaps[pooled_best(profiles)?];
        if self.known.share.is_none() {
            self.spread.share = [share(profiles).map_or(ANY_SHARE[0], |(share, _)| share), deviation];
        }
        Some(())
    }

    /// The link share that a scan begins with: the one that is known, or one with a deviation.
    fn share_about(&self, share: f64, deviation: f64) -> [f64; 2] {
        self.known.share.map_or([share, deviation], |_| self.spread.share)
    }

    /// Looks near a gap that is known about, count by count.
    fn look_near(&mut self, near: f64) -> Option<()> {
        let gaps = grid(near - NEAR * self.finest, near + NEAR * self.finest, self.finest);
        let reach = near.max(0.0) + (NEAR + BEYOND) * self.finest;
        let profiles = scan(&self.sites(reach, 0).0, &gaps, &self.spread);
        self.take(&gaps, &profiles, 0.1)
    }

    /// Looks over the whole range at a level.
    fn look_anywhere(&mut self, level: i32) -> Option<()> {
        let count = self.count(level);
        let gaps = grid(-FIRST * count, self.largest.max(2.0 * FIRST * count), 2.0 * count);
        let profiles = scan(&self.sites(self.largest + BEYOND * count, level).0, &gaps, &self.spread);
        self.asked = Some(profiles.iter().filter(|one| one.explained() && one.tells()).count());
        self.take(&gaps, &eased(&profiles), 0.1)
    }

    /// The fit of the level with the least error, where it sees a gap. Below the resolution of a level that is coarser than the encoder a small gap may hide, which
    /// the model does not find among the finer counts, so that only the encoder's own counts tell that there is none, unless noise hides it.
    fn descend(&mut self, coarsest: i32) -> Result<Fit, Untold> {
        let mut fits: Vec<(i32, Fit)> = Vec::new();
        let measured = |fit: &Fit| (fit.gap.mean.value, fit.gap.mean.std_error);
        for level in (0..=coarsest).rev() {
            let found = match self.at_level(level, if level == coarsest { FIRST } else { NEXT }) {
                Some(found) => found,
                None if fits.is_empty() => continue,
                None => break,
            };
            let (gap, error) = measured(&found);
            let before = fits.last().map(|(_, before)| measured(before));
            if before.is_some_and(|(before, its)| (gap - before).abs() > DIFFER * error.hypot(its)) {
                break;
            }
            self.gap = gap;
            fits.push((level, found));
        }
        let error = |k: &usize| fits[*k].1.gap.mean.std_error;
        let least = (0..fits.len()).rev().min_by(|a, b| error(a).total_cmp(&error(b))).ok_or(Untold::ByReversals)?;
        if fits[least].1.gap.is_seen() {
            let (level, fit) = fits.swap_remove(least);
            let Some(wind_up) = self.wind_up_that_matters(&fit) else { return Ok(self.sharpened(level, fit)) };
            let settled = self.settled(level, fit, wind_up).ok_or(Untold::ByReversals)?;
            return if settled.gap.is_seen() { Ok(settled) } else { Err(Untold::ByResolution) };
        }
        let finest = fits.pop().filter(|(level, _)| *level == 0 && self.shows_a_count()).ok_or(Untold::ByResolution)?.1;
        match self.wind_up_that_matters(&finest) {
            Some(wind_up) => self.settled(0, finest, wind_up).ok_or(Untold::ByReversals),
            None => Ok(finest),
        }
    }

    /// [rad or m] What the gear unwinds and winds up again at a reversal if all friction is the link's; `None` where a share of it that is off by as much as before
    /// anything is known changes a gap by less than its error.
    fn wind_up_that_matters(&self, fit: &Fit) -> Option<f64> {
        let all = self.sites(0.0, 0).0.into_iter().map(|Site { window, .. }| {
            let Transmission { breakaway: [forth, back], dead_zone, .. } = window.transmission;
            (forth + back) / dead_zone.stiffness
        });
        let wind_up = median(all)?;
        (self.known.share.is_none() && wind_up * ANY_SHARE[1] > fit.gap.mean.std_error).then_some(wind_up)
    }

    /// The fit with the share of friction that its reversals tell when it is held ([`settle`]), and with the error of that share in the gap's; `None` where they
    /// have no gap in common then.
    fn settled(&self, level: i32, fit: Fit, wind_up: f64) -> Option<Fit> {
        let (count, gap, before) = (self.count(level), fit.gap.mean.value, fit.share.value);
        // One set of windows for all shares, whose likelihoods are those of the same readings.
        let used = self.sites_of(&fit, gap + wind_up * before.max(0.0) + CLOSE * count, level);
        let scanned = |share: [f64; 2], step: f64| {
            // The gap may be less by all of the wind-up that this share has more, or as it was.
            let other = gap + wind_up * (before - share[0]);
            let gaps = grid(gap.min(other) - CLOSE * count, gap.max(other) + CLOSE * count, step * count);
            scan(&used, &gaps, &Spread { torque: self.noise, level: USUAL_LEVEL, share, ..self.spread })
        };
        let highest = |share: f64| scanned([share, HELD], SHARE_STEP).iter().map(Profile::highest).collect();
        let (share, share_error) = settle(before, self.spread.temper, highest).unwrap_or((before, ANY_SHARE[1]));
        let profiles = scanned([share, share_error.clamp(HELD, CLOSE_SHARE)], CLOSE_STEP);
        let left_out = fit.gap.left_out.clone();
        let Fit { gap, .. } = pool(&used, &profiles, left_out, used.len(), self.joint.kind.position_unit())?;
        let gap = gap.with_shared(wind_up * share_error);
        Some(Fit { gap, share: Quantity::new(share, share_error, NORMAL_95, "1") })
    }

    /// The reversals of a fit, with windows for gaps up to this one [rad or m].
    fn sites_of(&self, fit: &Fit, largest: f64, level: i32) -> Vec<Site> {
        let (mut used, _) = self.sites(largest.max(0.0) + BEYOND * self.count(level), level);
        used.retain(|site| fit.gap.values.iter().any(|value| value.time == site.time));
        used
    }

    /// See [`fit`]: between the flanks the gear unwinds and winds up again, so that a motor crosses `b + s (F₊ + F₋)/k`.
    fn wind_up_error(&self, accuracy: f64, share: f64) -> f64 {
        let errors = self.sites(0.0, 0).0.into_iter().map(|Site { window, .. }| {
            let Transmission { breakaway: [forth, back], link_inertia, .. } = window.transmission;
            share.clamp(0.0, 1.0) * (forth + back) * self.joint.compliance_error(accuracy, link_inertia)
        });
        median(errors).unwrap_or(0.0)
    }

    /// Whether the torque shows a gap of one count, if the link has little of the friction: over the time `√(2 c/a)` in which a motor that brakes with `a` crosses it,
    /// the link's friction is lacking in the torque.
    fn shows_a_count(&self) -> bool {
        let share = ANY_SHARE[0] - ANY_SHARE[1];
        let squares = self.sites(0.0, 0).0.into_iter().map(|Site { window, deceleration, .. }| {
            let [one, other] = window.transmission.breakaway;
            let readings = (2.0 * window.count / deceleration.abs()).sqrt() / window.interval;
            (share * one.min(other) / self.noise).powi(2) * readings
        });
        squares.sum::<f64>().sqrt() > SEEN
    }

    /// The fit with friction that keeps closer to its law, if that makes most of its reversals likelier and the gap no less sure. Where it does, the torque tells
    /// where in a count the rotor turned; else a reversal tells little more than how many edges it passed, and its error is a function of that phase.
    fn sharpened(&self, level: i32, fit: Fit) -> Fit {
        let count = self.count(level);
        let gap = fit.gap.mean.value;
        let used = self.sites_of(&fit, gap + CLOSE * count, level);
        let gaps = grid(gap - CLOSE * count, gap + CLOSE * count, CLOSE_STEP * count);
        let usual = Spread {
            torque: self.noise,
            level: USUAL_LEVEL,
            share: self.share_about(fit.share.value, CLOSE_SHARE),
            ..self.spread
        };
        let sharp = Spread { level: SHARP_LEVEL, blur: SHARP_BLUR, temper: SHARP_TEMPER, ..usual };
        let scanned = |spread: &Spread| scan(&used, &gaps, spread);
        // The reversals tell the share better now, and a wrong one leaves them unexplained.
        let first = scanned(&Spread { share: self.share_about(fit.share.value, 0.1), ..sharp });
        let better = share(&first).map_or(fit.share.value, |(share, _)| share);
        let sharp = scanned(&Spread { share: self.share_about(better, CLOSE_SHARE), ..sharp });
        if 2 * count_likelier(&used, &sharp, &gaps, &usual) <= used.len() {
            return fit;
        }
        let found = pool(&used, &sharp, fit.gap.left_out.clone(), used.len(), self.joint.kind.position_unit());
        let no_less_sure = |found: &Fit| found.gap.mean.std_error <= fit.gap.mean.std_error;
        found.filter(no_less_sure).unwrap_or(fit)
    }

    /// The fit of one level, `width` counts around the gap so far.
    fn at_level(&mut self, level: i32, width: f64) -> Option<Fit> {
        let count = self.count(level);
        let mut found = None;
        for (width, step, factor) in [(width, 1.0, 2.0), (CLOSE, CLOSE_STEP, 1.0)] {
            (self.spread.torque, self.spread.level) = (factor * self.noise, USUAL_LEVEL);
            let gaps = grid(self.gap - width * count, self.gap + width * count, step * count);
            let (mut near, carried) = self.sites(self.gap.max(0.0) + (width + BEYOND) * count, level);
            near.retain(|site| !self.given_up.contains(&key(site)));
            let profiles = scan(&near, &gaps, &self.spread);
            self.take(&gaps, &profiles, CLOSE_SHARE)?;
            found = Some((near, carried, profiles));
        }
        let (near, carried, profiles) = found?;
        let asked = *self.asked.get_or_insert(profiles.iter().filter(|one| one.tells()).count());
        let left_out = |time, reason| LeftOut { time, reason };
        let carried = carried.iter().map(|site| left_out(site.time, Reason::CarriedByLoad));
        let given_up = self.given_up.iter().map(|(time, _)| left_out(*time, Reason::Unexplained));
        let fit = pool(&near, &profiles, carried.chain(given_up).collect(), asked, self.sessions.first()?.unit);
        let unexplained = near.iter().zip(&profiles).filter(|(_, profile)| !profile.explained());
        self.given_up.extend(unexplained.map(|(site, _)| key(site)));
        fit
    }
}

/// The largest gap looked for [rad or m]: half the median stroke.
fn largest_gap(sessions: &[Session]) -> f64 {
    let strokes = |session: &Session| -> Vec<f64> {
        let position = &session.signals.position;
        session.reversals.iter().map(|one| 2.0 * (position[one.end] - position[one.turn]).abs()).collect()
    };
    0.5 * median(sessions.iter().flat_map(strokes)).unwrap_or(0.0)
}

//! The gap by iterated linear least squares with switching functions, after J. Vörös.
//!
//! Vörös writes backlash as one difference equation with switching functions. Its input is the motor `θ`, its output the link `q`, its
//! slopes are 1 and its offsets half the gap, `b/2`:
//!
//! ```text
//!   f₊(t) = 1 if θ(t) − b/2 ≥ q(t − 1), else 0          the flank that pushes positively touches
//!   f₋(t) = 1 if θ(t) + b/2 ≤ q(t − 1), else 0          the other flank
//!   q(t)  = (θ − b/2) f₊ + (θ + b/2) f₋ + q(t − 1) (1 − f₊)(1 − f₋)                               (a)
//! ```
//! With `σ = ±1`, the flank that touched last, and `p`, the motor's position then, this is `q = p − (b/2) σ`. A cascade of backlash and
//! a linear system follows it: here the link, whose torque loads the motor while a flank touches, `f = f₊ + f₋`:
//!
//! ```text
//!   τ = J θ̈ + F_r(θ̇) + H q̈ + f (F_l(q̇) + G),    F_r = (1 − s) F,  F_l = s F                      (b)
//!   τ − J θ̈ − F(θ̇) − f G = H p̈ − (H b/2) σ̈ − s (1 − f) F(θ̇)                                     (c)
//! ```
//! (c) is linear in `H`, `H b/2` and `s`. `p`, `σ`, `f` are internal variables: each iteration takes them from (a) with the gap of the
//! iteration before, and solves (c) for the next, `b = 2 (H b/2)/H`, half of the way. Both sides pass the filter `1/(s + λ)²`, so that no
//! signal is differentiated and errors of the friction are forgotten. While the motor sticks, both sides are zero: friction at rest is
//! set-valued and balances the torque.
//!
//! The iteration has several fixed points. It starts from gaps that double, from two counts of the encoder on; of the fixed points with
//! possible inertia and share, the one with the smallest mean square of (c) counts.
//!
//! Left out: elasticity of the gear; a link that coasts through its gap while the motor brakes; gravity that outweighs the link's friction.
//! Added to Vörös: the motor's own balance, because the output of his cascade, the link's torque, is not measured.
//! Reference: J. Vörös (2010), Modeling and identification of systems with backlash, Automatica 46, 369–374: backlash as one difference
//! equation of switching functions and its cascade with a linear system, identified by an iterated least squares with internal variables.

use nalgebra::{DMatrix, DVector};

use super::motion::Motion;
use crate::gearhead::{Direction, FrictionLaw};
use crate::identify::backlash::{Reversal, Session, braking};
use crate::identify::least_squares;
use crate::identify::quantity::Quantity;
use crate::robot::Model;
use crate::timeseries::TimeSeries;

/// Fewest reversals: the standard error comes from leaving out one of them at a time.
const FEWEST: usize = 4;
/// `λ` [1/s]: a few times faster than an arm's friction changes, and slower than a rotor crosses its gap, 50 to 100 ms. With 3 1/s errors
/// of the friction add up, with 10 1/s and more inertia is no longer determined.
const FILTER: f64 = 6.0;
/// [1] Rows of a reversal after the gap has been crossed, in time constants of the filter.
const TAIL: f64 = 3.0;
/// [s] Least interval of samples; shorter ones are averaged.
const INTERVAL: f64 = 0.004;
/// [1] Speed below which the motor sticks, as a part of the slowest steady speed of the friction law.
const STICKS: f64 = 0.2;
/// Largest number of iterations from one start.
const ITERATIONS: usize = 40;
/// [1] Relative change of the gap at which the iteration ends.
const CONVERGED: f64 = 1e-3;
/// [1] Relative change that still counts as a fixed point: a sample that changes its flank at every iteration moves the gap that much.
const FIXED: f64 = 0.02;
/// Largest start, as a part of the range of the motion; a stroke is at least that long.
const LARGEST: f64 = 0.05;
/// Smallest start, in counts, and for an exact encoder as a part of the range of the motion.
const SMALLEST: (f64, f64) = (2.0, 1e-4);
/// [1] Link inertia that is possible, in parts of the model's.
const INERTIA: [f64; 2] = [0.5, 2.0];
/// [1] Shares of the friction on the link that are possible. Beyond 0 to 1 the share makes up for an error of the friction, up to a quarter.
const SHARE: [f64; 2] = [-0.25, 1.25];
/// Fewest counts of the encoder in a gap that is reported: the straight lines between edges err by up to a count at a turn, a quarter of
/// such a gap.
const FEWEST_COUNTS: f64 = 4.0;
/// Most reversals that are used: the fastest of the gentle ones, because the motor sticks least at these.
const MOST: usize = 12;
/// [1] Deceleration up to which braking is gentle, as a part of `F_C/H`: the link's own share of the friction brakes it as fast.
const GENTLE: f64 = 0.5;
/// Number of unknowns: `H`, `H b/2`, `s`.
const UNKNOWNS: usize = 3;

/// Friction and inertia that the method takes as known.
pub(super) struct Known<'a> {
    /// `F`, from steady windows.
    pub law: &'a FrictionLaw,
    /// [rad/s or m/s] slowest speed of these windows.
    pub slowest: f64,
}

/// Duration [s] of the sessions with reversals, and the gap, or why there is none. `None`: the sessions have too few reversals.
pub(super) fn estimate(
    model: &Model,
    joint: usize,
    data: &[TimeSeries],
    known: &Known,
) -> Option<(f64, Result<Quantity, String>)> {
    let sessions: Vec<Session> = data.iter().filter_map(|series| Session::of(model, joint, series)).collect();
    let chosen = fastest_gentle(&sessions, known.law);
    if chosen.iter().map(Vec::len).sum::<usize>() < FEWEST {
        return None;
    }
    let inertia = model.joints[joint].reflected_inertia();
    let used = sessions.iter().zip(chosen).filter(|(_, reversals)| !reversals.is_empty());
    let recordings: Vec<Recording> =
        used.map(|(session, reversals)| Recording::of(session, reversals, inertia, known)).collect();
    let whole = |one: &Recording| one.session.signals.clock.elapsed(0, one.session.signals.time.len() - 1);
    Some((recordings.iter().map(whole).sum(), gap(&recordings)))
}

/// The reversals that are used, in the order of time, one list for each session.
fn fastest_gentle(sessions: &[Session], law: &FrictionLaw) -> Vec<Vec<Reversal>> {
    let coulomb =
        [Direction::Positive, Direction::Negative].map(|side| law.coulomb(side)).into_iter().fold(0.0, f64::max);
    let mut all = Vec::new();
    for (number, session) in sessions.iter().enumerate() {
        let (clock, mut link_inertia) = (&session.signals.clock, session.rigid.link_inertia_of());
        for reversal in &session.reversals {
            let (start, speed) = braking(session.signals.position, reversal, clock);
            let deceleration = speed / clock.elapsed(start, reversal.turn.max(start + 1));
            if deceleration * link_inertia(&session.rigid.posture(reversal.turn)) <= GENTLE * coulomb {
                all.push((speed, number, *reversal));
            }
        }
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.truncate(MOST);
    let of_session = |number: usize| {
        let mut own: Vec<Reversal> = all.iter().filter(|one| one.1 == number).map(|one| one.2).collect();
        own.sort_by_key(|reversal| reversal.turn);
        own
    };
    (0..sessions.len()).map(of_session).collect()
}

/// The best fixed point with its standard error by the jackknife over reversals.
fn gap(recordings: &[Recording]) -> Result<Quantity, String> {
    let [first, ..] = recordings else { return Err("no reversals".to_owned()) };
    let best = starts(recordings).filter_map(|start| iterate(recordings, start));
    let Some(best) = best.min_by(|a, b| a.mean_square.total_cmp(&b.mean_square)) else {
        return Err(format!(
            "no fixed point of the iteration has a possible link inertia ({} to {} of the model's) and share of friction; \
             it needs reversals with gentle braking, at which the link stays on its flank, and firm acceleration after them",
            INERTIA[0], INERTIA[1]
        ));
    };
    let count = first.session.signals.count;
    if best.gap < FEWEST_COUNTS * count {
        return Err(format!(
            "the gap would be {:.1} counts of the encoder, at least {FEWEST_COUNTS} are needed: {:.0} times as many counts a turn",
            best.gap / count,
            (FEWEST_COUNTS * count / best.gap).ceil()
        ));
    }
    let blocks = blocks(recordings, best.gap);
    let without = |left_out: usize| {
        let others = blocks.iter().enumerate().filter(|(k, _)| *k != left_out).map(|(_, one)| one);
        solve(others).map(|found| found.gap)
    };
    let jackknife: Vec<f64> = (0..blocks.len()).filter_map(without).collect();
    let n = jackknife.len() as f64;
    let mean = jackknife.iter().sum::<f64>() / n;
    let scatter = ((n - 1.0) / n * jackknife.iter().map(|one| (one - mean).powi(2)).sum::<f64>()).sqrt();
    // All turns lie between edges, by a part of a count that is the same in all of them at worst.
    let std_error = scatter.hypot(count / 12f64.sqrt());
    Ok(Quantity::new(best.gap, std_error, 1.96, first.session.unit))
}

/// Gaps from which the iteration starts.
fn starts(recordings: &[Recording]) -> impl Iterator<Item = f64> {
    let range = |one: &Recording| {
        let ends = one.motion.position.iter().fold([f64::MAX, f64::MIN], |[a, b], x| [a.min(*x), b.max(*x)]);
        ends[1] - ends[0]
    };
    let range = recordings.iter().map(range).fold(0.0, f64::max);
    let count = recordings.first().map_or(0.0, |one| one.session.signals.count);
    let smallest = (SMALLEST.0 * count).max(SMALLEST.1 * range);
    std::iter::successors(Some(smallest), |gap| Some(2.0 * gap))
        .take_while(move |gap| *gap > 0.0 && *gap <= LARGEST * range)
}

/// The fixed point that the iteration reaches from a start; `None` where it reaches none that is possible.
fn iterate(recordings: &[Recording], start: f64) -> Option<Solution> {
    let mut gap = start;
    for _ in 0..ITERATIONS {
        let found = solve(blocks(recordings, gap).iter())?;
        let change = (found.gap - gap).abs();
        if change <= CONVERGED * gap {
            return found.is_possible(recordings).then_some(found);
        }
        gap = 0.5 * (gap + found.gap);
        if gap <= 0.1 * start.min(gap.abs()) || !gap.is_finite() {
            return None;
        }
    }
    let found = solve(blocks(recordings, gap).iter())?;
    ((found.gap - gap).abs() <= FIXED * gap && found.is_possible(recordings)).then_some(found)
}

/// Rows of (c) of one reversal.
struct Block {
    x: Vec<[f64; UNKNOWNS]>,
    y: Vec<f64>,
}

/// A solution of (c).
struct Solution {
    /// `b` [rad or m].
    gap: f64,
    /// `H` [kg·m² or kg].
    inertia: f64,
    /// `s`.
    share: f64,
    /// Of the residuals of (c).
    mean_square: f64,
}

impl Solution {
    fn is_possible(&self, recordings: &[Recording]) -> bool {
        let nominal = recordings.first().map_or(0.0, |one| one.link_inertia);
        let [least, most] = INERTIA.map(|part| part * nominal);
        self.gap > 0.0 && (least..=most).contains(&self.inertia) && (SHARE[0]..=SHARE[1]).contains(&self.share)
    }
}

/// The least squares of (c) over some reversals.
fn solve<'a>(blocks: impl Iterator<Item = &'a Block>) -> Option<Solution> {
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for block in blocks {
        x.extend(block.x.iter().flatten().copied());
        y.extend(&block.y);
    }
    let rows = y.len();
    if rows <= UNKNOWNS {
        return None;
    }
    let fit = least_squares::linear(&DMatrix::from_row_slice(rows, UNKNOWNS, &x), &DVector::from_vec(y))?;
    let [inertia, moment, share] = fit.parameters[..] else { return None };
    Some(Solution { gap: 2.0 * moment / inertia, inertia, share, mean_square: fit.chi_squared / rows as f64 })
}

fn blocks(recordings: &[Recording], gap: f64) -> Vec<Block> {
    recordings.iter().flat_map(|one| one.blocks(gap)).collect()
}

/// The signals of a session that do not depend on the gap, at intervals of [`INTERVAL`].
struct Recording<'a> {
    session: &'a Session<'a>,
    reversals: Vec<Reversal>,
    /// Samples of the session in one interval.
    stride: usize,
    filter: Filter,
    motion: Motion,
    /// `F(θ̇)` [N·m or N], 0 where the motor sticks.
    friction: Vec<f64>,
    /// `G` [N·m or N], 0 where the motor sticks.
    gravity: Vec<f64>,
    /// `(τ − F)/(s + λ)² − J θ̈/(s + λ)²`.
    net: Vec<f64>,
    /// `H` of the model [kg·m² or kg] at the first reversal.
    link_inertia: f64,
}

impl<'a> Recording<'a> {
    fn of(session: &'a Session<'a>, reversals: Vec<Reversal>, inertia: f64, known: &Known) -> Self {
        let signals = &session.signals;
        let stride = ((INTERVAL / signals.clock.interval).round() as usize).max(1);
        let at = |all: &[f64]| -> Vec<f64> { all.iter().copied().step_by(stride).collect() };
        let motion = Motion::of(signals);
        let motion = Motion { position: at(&motion.position), velocity: at(&motion.velocity) };
        let moving = |value: f64, k: usize| if motion.velocity[k].abs() > STICKS * known.slowest { value } else { 0.0 };
        let every = |value: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..motion.position.len()).map(|k| moving(value(k), k)).collect()
        };
        let torque = |k: usize| mean_around(&signals.torque, k * stride, stride / 2);
        let gravity = at(&session.rigid.gravity_along(0..signals.position.len()));
        let friction = every(&|k| known.law.kinetic(motion.velocity[k]));
        let filter = Filter { intervals: at(signals.time).windows(2).map(|pair| pair[1] - pair[0]).collect() };
        let net = filter.smoothed(&every(&|k| torque(k) - known.law.kinetic(motion.velocity[k])));
        let accelerated = filter.differentiated(&motion.position);
        let net = net.iter().zip(&accelerated).map(|(net, a)| net - inertia * a).collect();
        let gravity = every(&|k| gravity[k]);
        let turn = reversals.first().map_or(0, |reversal| reversal.turn);
        let link_inertia = session.rigid.link_inertia_of()(&session.rigid.posture(turn));
        Self { session, reversals, stride, filter, motion, friction, gravity, net, link_inertia }
    }

    /// The rows of every reversal, with the internal variables of a gap.
    fn blocks(&self, gap: f64) -> Vec<Block> {
        let Internal { contact, flank, last } = Internal::of(&self.motion.position, gap);
        let only = |signal: &[f64], where_: bool| -> Vec<f64> {
            signal.iter().zip(&contact).map(|(value, touches)| if *touches == where_ { *value } else { 0.0 }).collect()
        };
        let (link, jumps) = (self.filter.differentiated(&last), self.filter.differentiated(&flank));
        let free = self.filter.smoothed(&only(&self.friction, false));
        let gravity = self.filter.smoothed(&only(&self.gravity, true));
        let row = |k: usize| ([link[k], -jumps[k], -free[k]], self.net[k] - gravity[k]);
        let block = |reversal: &Reversal| {
            let (x, y) = self.rows(reversal, gap).map(row).unzip();
            Block { x, y }
        };
        self.reversals.iter().map(block).collect()
    }

    /// From the turn until the filter has forgotten the crossing of the gap.
    fn rows(&self, reversal: &Reversal, gap: f64) -> std::ops::Range<usize> {
        let (position, last) = (&self.motion.position, self.motion.position.len());
        let [turn, end] = [reversal.turn, reversal.end].map(|k| (k / self.stride).min(last - 1));
        let crossed = |k: &usize| (position[*k] - position[turn]) * reversal.sign() > gap;
        let crossed = (turn..end).find(crossed).unwrap_or(end);
        let interval = self.session.signals.clock.interval * self.stride as f64;
        turn..(crossed + (TAIL / FILTER / interval) as usize).min(end)
    }
}

/// Mean of a signal over some samples to either side, fewer at the ends.
fn mean_around(signal: &[f64], at: usize, to_either_side: usize) -> f64 {
    let part = &signal[at.saturating_sub(to_either_side)..(at + to_either_side + 1).min(signal.len())];
    part.iter().sum::<f64>() / part.len() as f64
}

/// The internal variables of (a).
struct Internal {
    /// `f`: whether a flank touches.
    contact: Vec<bool>,
    /// `σ`, 0 until a flank touches.
    flank: Vec<f64>,
    /// `p` [rad or m].
    last: Vec<f64>,
}

impl Internal {
    fn of(position: &[f64], gap: f64) -> Self {
        let samples = position.len();
        let mut found = Self { contact: vec![false; samples], flank: vec![0.0; samples], last: vec![0.0; samples] };
        let (mut link, mut flank) = (position.first().copied().unwrap_or(0.0), 0.0);
        for (k, theta) in position.iter().enumerate() {
            let side = if theta - 0.5 * gap >= link {
                1.0
            } else if theta + 0.5 * gap <= link {
                -1.0
            } else {
                0.0
            };
            if side != 0.0 {
                (flank, link) = (side, theta - 0.5 * gap * side);
            }
            (found.contact[k], found.flank[k]) = (side != 0.0, flank);
            found.last[k] = link + 0.5 * gap * flank;
        }
        found
    }
}

/// The filter `1/(s + λ)²`, from rest.
struct Filter {
    /// [s]
    intervals: Vec<f64>,
}

impl Filter {
    /// `u/(s + λ)` by straight lines between samples.
    fn once(&self, u: &[f64]) -> Vec<f64> {
        let mut found = vec![0.0; u.len()];
        for (k, h) in (1..u.len()).zip(&self.intervals) {
            let keep = (-FILTER * h).exp();
            found[k] = keep * found[k - 1] + 0.5 * (1.0 - keep) / FILTER * (u[k - 1] + u[k]);
        }
        found
    }

    /// `u/(s + λ)²`.
    fn smoothed(&self, u: &[f64]) -> Vec<f64> {
        self.once(&self.once(u))
    }

    /// `s² u/(s + λ)² = u − 2λ u/(s + λ) + λ² u/(s + λ)²`, for a signal that has rested at its first value.
    fn differentiated(&self, u: &[f64]) -> Vec<f64> {
        let u: Vec<f64> = u.iter().map(|x| x - u[0]).collect();
        let first = self.once(&u);
        let second = self.once(&first);
        (0..u.len()).map(|k| u[k] - 2.0 * FILTER * first[k] + FILTER * FILTER * second[k]).collect()
    }
}

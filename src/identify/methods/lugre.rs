//! Stiffness and damping of the bristles of the LuGre model, from slow reversals of a torque that does not make the joint slip.
//!
//! ```text
//!   ż = v − σ0 |v| z/g(v),    F = σ0 z + σ1 ż + F_V v                                             (a)
//!   slow motion in the direction s:   dF/dθ = σ0 (1 − s F/F_S)                                     (b)
//!   θ − θ_r = −s (F_S/σ0) ln[(F_S − s F)/(F_S − s F_r)]      from a reversal (θ_r, F_r)             (c)
//! ```
//! The torque of the motor is the friction, `F = τ`, where it changes slowly. (c) is linear in `1/σ0`; the counts of the encoder are on
//! its left side, so that their error does not weaken the slope. Every branch has a `θ_r` of its own. The shape of `g` is the static law
//! of the joint from steady windows; the motor within its gap carries the part `ρ` of it, found by a scan: `F_S = ρ F_S,joint`.
//!
//! ```text
//!   J θ̈ + F = τ     with (a), for small steps of the torque                                        (d)
//! ```
//! The damping `σ1` is the one with which (d), under the measured torque, follows the measured position best, `σ0` and `ρ` held.
//! Sign: positive torque deflects positively. The motor must not touch a flank, and nothing but friction may hold it.
//! Left out: `σ1` that falls with speed; gravity on the joint.
//! References: C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky (1995), A new model for control of systems with friction, IEEE
//! Transactions on Automatic Control 40, equations 1 to 3; C. Canudas de Wit, P. Lischinsky (1997), Adaptive friction compensation with
//! partially known dynamic friction model, International Journal of Adaptive Control and Signal Processing 11: static law first, then
//! `σ0` and `σ1` from small displacements about rest.

use super::limit_cycle;
use crate::gearhead::{Direction, FrictionLaw, Memory};
use crate::identify::backlash::torque_between;
use crate::identify::quantity::Quantity;
use crate::identify::signals::Signals;
use crate::robot::{JointModel, Model};
use crate::timeseries::TimeSeries;

/// [s] Span of the mean of the torque.
const SMOOTH: f64 = 0.1;
/// [1] Least and largest torque at the reversals, as parts of the joint's friction at rest.
const LEVELS: [f64; 2] = [0.1, 0.95];
/// [1] Deviation of the torque from a straight line between two reversals, RMS, as a part of its change.
const STRAIGHT: f64 = 0.05;
/// Fewest branches between two reversals.
const FEWEST: usize = 4;
/// Fewest counts of the encoder in the width of the hysteresis: they blur an average of many readings, but not the width by more than one.
const FEWEST_COUNTS: f64 = 8.0;
/// Values of `ρ` of the scan, and the largest.
const SCAN: (usize, f64) = (200, 1.5);
/// [1] Residual of (c), RMS, as a part of the width of the hysteresis, above which it is not a branch of (c): a flank that is touched over a fifth of
/// the way leaves 1.6 %, over half of it 5 % and takes the stiffness 10 % up. Below half a count it is the encoder's.
const MISFIT: f64 = 0.01;
/// [s] Largest step of the simulation of (d).
const STEP: f64 = 1e-4;
/// Values of `σ1` of the scan, from and to [√(σ0 J)].
const DAMPINGS: (usize, [f64; 2]) = (60, [0.02, 5.0]);

/// What the presliding data of a joint show.
pub(super) struct Found {
    /// `σ0`.
    pub stiffness: Quantity,
    /// `σ1`, where small steps of the torque were recorded.
    pub damping: Option<Quantity>,
}

/// A session with small steps of the torque.
struct Steps<'a> {
    signals: Signals<'a>,
    /// First sample of every half period, and the one after its last.
    halves: Vec<[usize; 2]>,
    /// [s] Intervals of the samples.
    intervals: Vec<f64>,
    /// [N·m or N] Mean torque in each interval.
    torque: Vec<f64>,
}

/// One branch of the hysteresis.
struct Branch {
    direction: Direction,
    /// `F_r`.
    start: f64,
    /// `F` and `θ`.
    points: Vec<[f64; 2]>,
}

/// Duration [s] of the sessions with slow torque reversals about rest, and what they show, or why nothing.
pub(super) fn estimate(
    model: &Model,
    joint: usize,
    data: &[TimeSeries],
    law: &FrictionLaw,
) -> Option<(f64, Result<Found, String>)> {
    let at_rest = [Direction::Positive, Direction::Negative].map(|side| law.magnitude(side, 0.0));
    let least = at_rest[0].min(at_rest[1]);
    let (mut duration, mut branches, mut steps, mut count) = (0.0, Vec::new(), Vec::new(), 0.0);
    for signals in data.iter().filter_map(|series| Signals::of(model, joint, series)) {
        if signals.rectified || signals.time.len() < 2 {
            continue;
        }
        let length = signals.clock.elapsed(0, signals.time.len() - 1);
        if let Some(found) = branches_of(&signals, least) {
            branches.extend(found);
            (duration, count) = (duration + length, signals.count);
        } else if let Some(halves) = limit_cycle::half_periods(&signals, LEVELS[0] * least..limit_cycle::LEAST * least)
        {
            duration += length;
            let clock = &signals.clock;
            let intervals: Vec<f64> = (1..signals.time.len()).map(|k| clock.elapsed(k - 1, k)).collect();
            let torque =
                torque_between(&signals.torque, &intervals, model.joints[joint].amplifier.current_time_constant);
            steps.push(Steps { signals, halves, intervals, torque });
        }
    }
    if branches.is_empty() {
        return None;
    }
    let joint = &model.joints[joint];
    let found = loop_of(&branches, at_rest, count).map(|found| {
        let (effort, position) = (joint.kind.effort_unit(), joint.kind.position_unit());
        Found {
            stiffness: Quantity::new(found.stiffness, found.std_error, 1.96, format!("{effort}/{position}")),
            damping: damping(&steps, joint, law, &found),
        }
    });
    Some((duration, found))
}

/// The branches of a session whose torque goes to and fro at a constant rate without making the joint slip; `None` for other sessions.
fn branches_of(signals: &Signals, least: f64) -> Option<Vec<Branch>> {
    let clock = &signals.clock;
    let (n, half) = (signals.torque.len(), clock.after(0, 0.5 * SMOOTH).max(1));
    let mut sums = vec![0.0];
    signals.torque.iter().for_each(|tau| sums.push(sums[sums.len() - 1] + tau));
    let smooth = |k: usize| {
        let (from, to) = (k.saturating_sub(half), (k + half + 1).min(n));
        (sums[to] - sums[from]) / (to - from) as f64
    };
    let torque: Vec<f64> = (0..n).map(smooth).collect();
    let largest = torque.iter().fold(0.0_f64, |most, tau| most.max(tau.abs()));
    if largest > LEVELS[1] * least || largest < LEVELS[0] * least {
        return None;
    }
    let turns = turns(&torque, largest);
    let branch = |pair: &[usize]| {
        // The mean rounds the ends.
        let (from, to) = (pair[0] + half, pair[1].saturating_sub(half));
        if from >= to {
            return None;
        }
        let rate = (torque[to] - torque[from]) / (to - from) as f64;
        let off = (from..to).map(|k| (torque[k] - torque[from] - rate * (k - from) as f64).powi(2)).sum::<f64>();
        let straight = (off / (to - from) as f64).sqrt() <= STRAIGHT * (torque[to] - torque[from]).abs();
        let direction = Direction::of(torque[to] - torque[from]);
        // The mean at a turn of a triangle is nearer to zero by a quarter of its half span.
        let start = torque[from] - rate * half as f64;
        let points = (from..to).step_by(half).map(|k| [torque[k], signals.position[k]]).collect();
        straight.then_some(Branch { direction, start, points })
    };
    let found: Option<Vec<Branch>> = turns.windows(2).map(branch).collect();
    found.filter(|all| all.len() >= FEWEST)
}

/// Samples of the extremes of a torque that alternate between more than half of the largest, both signs.
fn turns(torque: &[f64], largest: f64) -> Vec<usize> {
    let mut found: Vec<usize> = Vec::new();
    for (k, tau) in torque.iter().enumerate().filter(|(_, tau)| tau.abs() > 0.5 * largest) {
        match found.last_mut() {
            Some(last) if torque[*last].signum() == tau.signum() => {
                if tau.abs() > torque[*last].abs() {
                    *last = k;
                }
            }
            _ => found.push(k),
        }
    }
    found
}

/// The fit of (c).
struct Loop {
    /// `σ0`.
    stiffness: f64,
    std_error: f64,
    /// `ρ`.
    part: f64,
}

fn loop_of(branches: &[Branch], at_rest: [f64; 2], count: f64) -> Result<Loop, String> {
    let points = || branches.iter().flat_map(|branch| &branch.points);
    let width = |axis: usize| {
        let ends = points().fold([f64::MAX, f64::MIN], |[a, b], point| [a.min(point[axis]), b.max(point[axis])]);
        ends[1] - ends[0]
    };
    let (torque, angle) = (width(0), width(1));
    if angle < FEWEST_COUNTS * count || angle == 0.0 {
        let bound = if count > 0.0 {
            format!(", so that bristles are stiffer than {:.3e}", torque / (FEWEST_COUNTS * count))
        } else {
            String::new()
        };
        return Err(format!(
            "the motor moves by {:.1} counts of its encoder between the reversals of {:.3}, at least {FEWEST_COUNTS} are needed{bound}; \
             more torque below the breakaway torque or a finer encoder would show softer ones",
            if count > 0.0 { angle / count } else { 0.0 },
            0.5 * torque
        ));
    }
    let all: Vec<&Branch> = branches.iter().collect();
    let (part, compliance, misfit) = best(&all, at_rest).ok_or("the torque exceeds the friction at rest")?;
    if misfit > (MISFIT * angle).max(0.5 * count) || compliance <= 0.0 {
        return Err(format!(
            "the hysteresis is no branch of the LuGre model, {:.0} % off: the motor touches a flank of its gear or slips; less torque",
            100.0 * misfit / angle
        ));
    }
    let without = |left_out: usize| {
        let rest: Vec<&Branch> = all.iter().enumerate().filter(|(k, _)| *k != left_out).map(|(_, one)| *one).collect();
        best(&rest, at_rest).map(|(_, compliance, _)| 1.0 / compliance)
    };
    let jackknife: Vec<f64> = (0..all.len()).filter_map(without).collect();
    let n = jackknife.len() as f64;
    let mean = jackknife.iter().sum::<f64>() / n;
    let scatter = ((n - 1.0) / n * jackknife.iter().map(|one| (one - mean).powi(2)).sum::<f64>()).sqrt();
    // The branches repeat, so that the ends of the hysteresis keep their place within a count.
    let counts = count / angle / 6f64.sqrt() / compliance;
    Ok(Loop { stiffness: 1.0 / compliance, std_error: scatter.hypot(counts), part })
}

/// `ρ`, `1/σ0` and the residual [rad or m] of the least squares of (c).
fn best(branches: &[&Branch], at_rest: [f64; 2]) -> Option<(f64, f64, f64)> {
    // Beyond F_S the logarithm has no value.
    let reached = |branch: &&Branch| {
        let own = at_rest[branch.direction.index()];
        let most = branch.points.iter().map(|point| branch.direction.sign() * point[0]).fold(0.0, f64::max);
        most / own
    };
    let lowest = 1.01 * branches.iter().map(reached).fold(0.0, f64::max);
    let at = |k: usize| lowest * (SCAN.1 / lowest).powf(k as f64 / (SCAN.0 - 1) as f64);
    let fits = (0..SCAN.0).map(|k| (at(k), slope(branches, at_rest, at(k))));
    let best = fits.min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
    (lowest < SCAN.1).then_some((best.0, best.1.0, best.1.1))
}

/// `1/σ0` at a `ρ`, and the residual.
fn slope(branches: &[&Branch], at_rest: [f64; 2], part: f64) -> (f64, f64) {
    let (mut xx, mut xy, mut yy, mut number) = (0.0, 0.0, 0.0, 0.0);
    for branch in branches {
        let (s, own) = (branch.direction.sign(), part * at_rest[branch.direction.index()]);
        let x: Vec<f64> = (branch.points.iter())
            .map(|point| -s * own * ((own - s * point[0]) / (own - s * branch.start)).ln())
            .collect();
        let n = x.len() as f64;
        let means = [x.iter().sum::<f64>() / n, branch.points.iter().map(|point| point[1]).sum::<f64>() / n];
        for (x, point) in x.iter().zip(&branch.points) {
            let (x, y) = (x - means[0], point[1] - means[1]);
            (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        }
        number += n;
    }
    (xy / xx, ((yy - xy * xy / xx).max(0.0) / number).sqrt())
}

/// `σ1` by (d) on the small steps; `None` without them, or where their residual has its minimum at an end of the scan.
fn damping(steps: &[Steps], joint: &JointModel, law: &FrictionLaw, found: &Loop) -> Option<Quantity> {
    let inertia = joint.reflected_inertia();
    if steps.is_empty() || inertia <= 0.0 {
        return None;
    }
    let scale = (found.stiffness * inertia).sqrt();
    let (number, [from, to]) = DAMPINGS;
    let at = |k: usize| scale * from * (to / from).powf(k as f64 / (number - 1) as f64);
    let squares = |k: usize| -> f64 {
        let bristles = Memory::Bristles { stiffness: found.stiffness, damping: at(k) };
        steps.iter().map(|steps| mismatch(steps, inertia, law, found.part, bristles)).sum()
    };
    let squares: Vec<f64> = (0..number).map(squares).collect();
    let least = (0..number).min_by(|a, b| squares[*a].total_cmp(&squares[*b]))?;
    if least == 0 || least + 1 == number {
        return None;
    }
    // The parabola through the three lowest, in ln σ1.
    let width = (to / from).ln() / (number - 1) as f64;
    let [below, lowest, above] = [squares[least - 1], squares[least], squares[least + 1]];
    let bend = (below - 2.0 * lowest + above) / (width * width);
    let shift = 0.5 * (below - above) / (width * bend);
    let samples: f64 = steps.iter().map(|one| one.signals.time.len() as f64).sum();
    // Readings between two edges of the encoder repeat their error: the edges count.
    let edges: f64 =
        steps.iter().map(|one| one.signals.position.windows(2).filter(|pair| pair[0] != pair[1]).count() as f64).sum();
    let independent = if edges > 0.0 { edges.min(samples) } else { samples };
    let std_error = (2.0 * lowest / independent / bend).sqrt();
    let value = at(least) * shift.exp();
    let unit = joint.kind.damping_unit();
    // An error of σ0 changes the ringing's frequency, and through it the damping in the same proportion.
    let inherited = value * found.std_error / found.stiffness;
    Some(Quantity::new(value, (value * std_error).hypot(inherited), 1.96, unit))
}

/// Sum of squares between (d) and the measured position, both about their means between two steps: bristles under unequal friction of
/// both directions drift.
fn mismatch(steps: &Steps, inertia: f64, law: &FrictionLaw, part: f64, bristles: Memory) -> f64 {
    let position = steps.signals.position;
    let (mut theta, mut v, mut z) = (0.0, 0.0_f64, 0.0);
    let mut difference = vec![position[0]];
    for ((whole, torque), measured) in steps.intervals.iter().zip(&steps.torque).zip(&position[1..]) {
        let parts = (whole / STEP).ceil().max(1.0);
        let h = whole / parts;
        for _ in 0..parts as usize {
            let direction = Direction::of(v);
            let viscous = part * law.viscous(direction);
            let dry = (part * law.magnitude(direction, v.abs()) - viscous * v.abs()).max(f64::MIN_POSITIVE);
            let change = bristles.change(z, v, dry, h);
            v += h * (torque - bristles.force(z, change, h) - viscous * v) / inertia;
            theta += h * v;
            z += bristles.change(z, v, dry, h);
        }
        difference.push(measured - theta);
    }
    let about_mean = |[from, to]: &[usize; 2]| {
        let part = &difference[*from..*to];
        let mean = part.iter().sum::<f64>() / part.len() as f64;
        part.iter().map(|one| (one - mean).powi(2)).sum::<f64>()
    };
    steps.halves.iter().map(about_mean).sum()
}

//! Mistakes that the torque balance shows: the single change of data or model that makes it fit.
//!
//! The balance leaves the share `u` of the squared torque (see [`balance`](super::balance)). It is 0.000 to 0.06 on correct recordings, up to 0.25 on
//! simulated machines with an effect of twice its full strength, and 0.1 to 1 with a wrong sign. If `u` of a joint is above [`SUSPICIOUS`],
//! every change is tried in turn. On correct data each change makes the balance worse or leaves it unchanged, and none halves the RMS. A change is
//! named if the RMS of a joint falls to half or less, `Σ ln(u_before/u_after)` over all joints also exceeds `ln` [`FACTOR`], and the residual of that
//! joint is as small as on correct data. Changes that are nearly as good are named as alternatives.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::balance;
use super::balance::{Balance, Columns, Mask, Normal, SUSPICIOUS};
use super::change::{Change, Culprit, Evidence, Quantity};
use super::limits::Outside;
use super::overload::Overload;
use super::rows::Rows;
use crate::robot::{JointModel, Masses, Model};
use crate::units::{DEG, JointKind};

/// Share below which a joint counts as explained: 7 % in RMS.
const FLOOR: f64 = 0.005;
/// Factor by which a change has to lower the residual share of one joint, and the product of the shares of all joints: half in RMS. A wrong
/// sign or unit causes an error of the order of the torque. On 430 correct machines, with one or two effects of up to twice their full
/// strength each, no change lowers the residual more than 1.9 times.
pub const FACTOR: f64 = 4.0;
/// Largest share of the mistaken joint after the change: 32 % in RMS. Correct recordings leave up to 24 %.
pub const EXPLAINED: f64 = 0.1;
/// Factor by which an alternative may be worse than the best change.
pub const NEARLY: f64 = 1.5;
/// [1] Weight of a coefficient's deviation from one, in the score of a change.
const UNLIKELY: f64 = 0.5;
/// [s] Lags that are tried: larger than those of a sensor or a filter, see `sensor_delay`.
const LAGS: [f64; 8] = [-0.4, -0.3, -0.2, -0.15, 0.15, 0.2, 0.3, 0.4];

/// The result of one change.
struct TriedChange {
    change: Change,
    score: f64,
    before: Vec<Option<Balance>>,
    after: Vec<Option<Balance>>,
}

/// The change that makes the balance fit, if one does. `timed`: whether a velocity channel confirms the time base.
/// `limits`: quantities outside the limits of the model; they support a factor that brings them back.
pub fn best(model: &Model, rows: &[Rows], timed: bool, limits: &Limits<'_>) -> Option<Culprit> {
    let moves = |session: usize, joint: usize, row: usize| rows[session].joints[joint].moves[row];
    let bounds = balance::bounds(model);
    let columns = Columns::new(model, rows);
    let normals = columns.normals(rows, &moves);
    let before: Vec<Option<Balance>> = normals.iter().map(|normal| normal.solve(&bounds)).collect();
    let suspicious: Vec<usize> =
        (0..before.len()).filter(|joint| before[*joint].is_some_and(|one| one.left > SUSPICIOUS)).collect();
    if suspicious.is_empty() {
        return None;
    }
    let tried = |change: Change| {
        let trial = trial(model, rows, change, (&columns, &normals), &before);
        TriedChange { score: trial.score + FACTOR.ln() * brought_back(model, change, limits), ..trial }
    };
    let mut trials: Vec<TriedChange> =
        changes(model, rows, &suspicious, &before, timed).into_par_iter().map(tried).collect();
    trials.sort_by(|a, b| b.score.total_cmp(&a.score));
    let first = trials.first()?;
    let joint = worst(first)?;
    let (was, is) = (first.before[joint]?.left, first.after[joint]?.left);
    if first.score < FACTOR.ln() || was < FACTOR * is || is > EXPLAINED || was < SUSPICIOUS {
        return None;
    }
    let alternatives = trials[1..]
        .iter()
        .take_while(|other| other.score > first.score - NEARLY.ln())
        .map(|other| other.change)
        .collect();
    let percent = |left: f64| 100.0 * left.sqrt();
    let evidence = Evidence::Residual([percent(was), percent(is)]);
    Some(Culprit { change: first.change, alternatives, joint, evidence })
}

/// Quantities outside the limits of the model.
#[derive(Debug)]
pub struct Limits<'a> {
    /// Positions.
    pub outside: &'a [Outside],
    /// Torques.
    pub overloads: &'a [Overload],
}

/// Number of joints that a change brings back into their limits.
fn brought_back(model: &Model, change: Change, limits: &Limits<'_>) -> f64 {
    let one_of = |which: Option<usize>, joint: usize| which.is_none_or(|only| only == joint);
    let torque = |which: Option<usize>, factor: f64| {
        limits.overloads.iter().filter(|one| one_of(which, one.joint) && one.explained_by(factor)).count()
    };
    let count = match change {
        Change::MotionScale(which, factor) => {
            limits.outside.iter().filter(|one| one_of(which, one.joint) && one.explained_by(factor)).count()
        }
        Change::MotorMotions(factor) => {
            let ratio = |joint: usize| model.joints[joint].gear_ratio;
            limits.outside.iter().filter(|one| one.explained_by(factor / ratio(one.joint))).count()
        }
        Change::TorqueScale(which, factor) => torque(which, factor),
        Change::AllTorques(quantity) => {
            let factor = |joint: usize| quantity.factor(&model.joints[joint]);
            limits
                .overloads
                .iter()
                .filter(|one| factor(one.joint).is_some_and(|factor| one.explained_by(factor)))
                .count()
        }
        // The limit of the drive scales with the ratio too.
        Change::Ratio(joint, factor) if model.robot.bodies[joint].joint.limits.effort.is_finite() => {
            torque(Some(joint), factor)
        }
        _ => 0,
    };
    count as f64
}

/// The joint that a change improves most.
fn worst(trial: &TriedChange) -> Option<usize> {
    let gain = |joint: &usize| match (trial.before[*joint], trial.after[*joint]) {
        (Some(before), Some(after)) => before.left.max(FLOOR).ln() - after.left.max(FLOOR).ln(),
        _ => f64::NEG_INFINITY,
    };
    (0..trial.before.len()).max_by(|a, b| gain(a).total_cmp(&gain(b)))
}

fn trial(
    model: &Model,
    rows: &[Rows],
    change: Change,
    (columns, normals): (&Columns, &[Normal]),
    before: &[Option<Balance>],
) -> TriedChange {
    let bounds = balance::bounds(model);
    let scale = match change {
        Change::TorqueScale(which, factor) => Some((which, factor)),
        Change::TorqueSign(joint) => Some((Some(joint), -1.0)),
        _ => None,
    };
    if let Some((which, factor)) = scale {
        // The motion is unchanged.
        let of_joint = |(joint, normal): (usize, &Normal)| match which {
            Some(only) if only != joint => before[joint],
            _ => normal.scaled(factor).solve(&bounds),
        };
        let after: Vec<_> = normals.iter().enumerate().map(of_joint).collect();
        return TriedChange { change, score: score(before, &after), before: before.to_vec(), after };
    }
    let exchanged = change.exchanged();
    let both = |session: usize, joint: usize, row: usize| {
        let moves = |joint: usize| rows[session].joints[joint].moves[row];
        exchanged.filter(|pair| pair.contains(&joint)).map_or_else(|| moves(joint), |[i, j]| moves(i) && moves(j))
    };
    let mask: &Mask<'_> = &both;
    let solved = |columns: &Columns, rows: &[Rows]| -> Vec<Option<Balance>> {
        columns.normals(rows, mask).iter().map(|normal| normal.solve(&bounds)).collect()
    };
    let before = if exchanged.is_some() { solved(columns, rows) } else { before.to_vec() };
    let (changed, undone) = change.undone(model, rows);
    let after = if change.of_torque() { solved(columns, &undone) } else { balance::balances(&changed, &undone, mask) };
    TriedChange { change, score: score(&before, &after), before, after }
}

/// `Σ ln(u_before/u_after)`, minus a penalty for unlikely coefficients after the change.
fn score(before: &[Option<Balance>], after: &[Option<Balance>]) -> f64 {
    let of_joint = |(before, after): (&Option<Balance>, &Option<Balance>)| match (before, after) {
        (Some(before), Some(after)) => {
            let gain = before.left.max(FLOOR).ln() - after.left.max(FLOOR).ln();
            gain - UNLIKELY * (after.oddness() - before.oddness())
        }
        _ => 0.0,
    };
    before.iter().zip(after).map(of_joint).sum()
}

/// All changes to try.
fn changes(model: &Model, rows: &[Rows], suspicious: &[usize], before: &[Option<Balance>], timed: bool) -> Vec<Change> {
    let dof = model.joints.len();
    let mut changes = Vec::new();
    for &i in suspicious {
        changes.extend([Change::TorqueSign(i), Change::MotionSign(i)]);
        if never_negative(rows, i) {
            changes.push(Change::Unsigned(Some(i)));
        }
        changes.extend(LAGS.map(|lag| Change::TorqueLag(Some(i), lag)));
    }
    if model.masses == Masses::Estimated {
        // Friction determines the sign; the rest of the balance is only as good as the estimated masses.
        changes.retain(|change| matches!(change, Change::TorqueSign(_) | Change::MotionSign(_) | Change::Unsigned(_)));
    }
    if dof > 1 && (0..dof).all(|joint| never_negative(rows, joint)) {
        changes.push(Change::Unsigned(None));
    }
    for i in 0..dof {
        for j in i + 1..dof {
            if suspicious.contains(&i) && suspicious.contains(&j) {
                changes.extend([Change::SwapTorque(i, j), Change::SwapMotion(i, j), Change::SwapJoints(i, j)]);
            }
        }
    }
    if model.masses == Masses::Estimated {
        changes.push(Change::TorqueScale(None, -1.0));
        return changes;
    }
    changes.extend((0..dof).map(Change::AxisSign));
    changes.push(Change::Gravity);
    for &i in suspicious {
        changes.extend(scales(model, rows, i));
        changes.extend(before[i].and_then(|one| one.needed_scale()).map(|f| Change::TorqueScale(Some(i), f)));
    }
    if dof > 1 {
        changes.extend(LAGS.map(|lag| Change::TorqueLag(None, lag)));
        changes.extend([-1.0, 1e-3, 1e3].map(|factor| Change::TorqueScale(None, factor)));
        changes.extend([DEG, 1.0 / DEG].map(|factor| Change::MotionScale(None, factor)));
        changes.extend([1.0, DEG].map(Change::MotorMotions));
        let from_current = rows.iter().all(|session| session.from_current);
        changes.extend(Quantity::instead_of(from_current).map(Change::AllTorques));
    }
    changes.retain(|change| !too_small_for_degrees(model, rows, *change));
    if !timed {
        changes.extend([1e-3, 0.1, 1.0 / 3.0, 0.5, 2.0, 3.0, 10.0, 1e3].map(Change::TimeScale));
    }
    changes
}

/// Whether a change takes radians for degrees although no joint covers a turn as read: the true motion would be less than 6°. Without weight a
/// motion that is smaller by a factor looks like a torque that is larger by it.
fn too_small_for_degrees(model: &Model, rows: &[Rows], change: Change) -> bool {
    let Change::MotionScale(which, DEG) = change else { return false };
    let covers_a_turn = |joint: usize| {
        let positions = rows.iter().flat_map(|session| &session.joints[joint].q);
        let [low, high] =
            positions.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], q| [low.min(*q), high.max(*q)]);
        model.joints[joint].kind == JointKind::Revolute && high - low > TAU
    };
    let joints = which.map_or(0..model.joints.len(), |joint| joint..joint + 1);
    !joints.into_iter().any(covers_a_turn)
}

/// Whether the torque of a joint is never below zero by more than one percent of its largest value.
pub fn never_negative(rows: &[Rows], joint: usize) -> bool {
    rows.iter().all(|session| {
        let torque = &session.joints[joint].tau;
        let largest = torque.iter().fold(0.0_f64, |most, tau| most.max(tau.abs()));
        torque.iter().all(|tau| *tau >= -0.01 * largest)
    })
}

/// Factors of one joint that have a name.
fn scales(model: &Model, rows: &[Rows], i: usize) -> Vec<Change> {
    let joint = &model.joints[i];
    let n = joint.gear_ratio;
    let from_current = rows.iter().all(|session| session.from_current);
    let motion: &[f64] = match joint.kind {
        JointKind::Revolute => &[DEG, 1.0 / DEG, 1.0 / n, DEG / n],
        JointKind::Prismatic => &[1e-3, 1e3, 1.0 / n, DEG / n],
    };
    let distinct = |factor: &&f64| factor.ln().abs() > 0.2;
    let mut scales = torque_scales(joint, from_current);
    scales.retain(|factor| distinct(&factor));
    let scales = scales.into_iter().map(|f| Change::TorqueScale(Some(i), f));
    let motions = motion.iter().filter(distinct).map(|f| Change::MotionScale(Some(i), *f));
    scales.chain(motions).chain(ratios(model, i).into_iter().map(|f| Change::Ratio(i, f))).collect()
}

/// Factors of the torque of a joint that have a name.
pub fn torque_scales(joint: &JointModel, from_current: bool) -> Vec<f64> {
    let other = Quantity::instead_of(from_current).into_iter().filter_map(|quantity| quantity.factor(joint));
    [1e-3, 1e3].into_iter().chain(other).collect()
}

/// Factors of the gear ratio of a joint that are likely mistakes: the ratio of another joint, none at all, and its inverse.
pub fn ratios(model: &Model, i: usize) -> Vec<f64> {
    let n = model.joints[i].gear_ratio;
    let others = model.joints.iter().map(|other| other.gear_ratio / n).filter(|f| (f.ln()).abs() > 0.2);
    others.chain([1.0 / (n * n), 1.0 / n]).collect()
}

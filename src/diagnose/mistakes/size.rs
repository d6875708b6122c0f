//! A torque of another size than the model's: the part of it that follows inertia and weight is several times too large or too small.
//!
//! Friction may take any size, so a torque that is mostly friction is explained at every scale, and the residual of the balance does not show a wrong
//! one. The torque of the rigid body does: the model gives its size, and on a recording in another unit all of it is off by one factor. The
//! bounds of that factor ([`Size`](super::balance::Size)) allow for payload, tilt, spring and for whatever remains.
//! It cannot be seen where the factor is within the accuracy of the model, or where the rigid body explains too little beside friction.

use super::balance;
use super::balance::{COLUMNS, Columns, MODEL_FACTOR, Normal, Size};
use super::change::{Change, Culprit, Evidence};
use super::rows::Rows;
use super::search::{ratios, torque_scales};
use crate::robot::{Masses, Model};

/// Standard deviations by which centres of mass may be off: a mistake is told where no likely centre explains the torque.
const CENTRES_OFF: f64 = 3.0;

/// The joint whose torque has an impossible size, if there is one; that with the largest factor.
pub fn best(model: &Model, rows: &[Rows]) -> Option<Culprit> {
    if model.masses == Masses::Estimated {
        return None;
    }
    let moves = |session: usize, joint: usize, row: usize| rows[session].joints[joint].moves[row];
    let bounds = balance::bounds(model);
    let normals = Columns::new(model, rows).normals(rows, &moves);
    let of_joint = |joint: usize| {
        let size = of_rows(model, joint, &normals[joint], &bounds)?;
        Some((joint, size, size.impossible()?))
    };
    let off = |found: &(usize, Size, f64)| found.2.max(1e-9).ln().abs();
    let worst = (0..normals.len()).filter_map(of_joint).max_by(|a, b| off(a).total_cmp(&off(b)))?;
    Some(culprit(model, rows, worst))
}

/// Size of the rigid body's torque in these rows of a joint; `None` where it explains nothing.
pub fn of_rows(model: &Model, joint: usize, normal: &Normal, bounds: &[[f64; 2]; COLUMNS]) -> Option<Size> {
    normal.size(bounds, doubtful_moment(model, joint))
}

/// First moment that the centres of mass beyond a joint may be off by together [kg·m].
fn doubtful_moment(model: &Model, joint: usize) -> f64 {
    let squares: f64 = model.robot.bodies[joint..].iter().map(|body| body.inertia.mass.powi(2)).sum();
    CENTRES_OFF * model.accuracy.centres * squares.sqrt()
}

fn culprit(model: &Model, rows: &[Rows], (joint, size, estimate): (usize, Size, f64)) -> Culprit {
    let from_current = rows.iter().all(|session| session.from_current);
    let needed = 1.0 / estimate.max(1e-9);
    let scales = torque_scales(&model.joints[joint], from_current).into_iter();
    let scales = scales.map(|factor| (factor, Change::TorqueScale(Some(joint), factor)));
    // The torque of a current scales with the ratio.
    let ratios = ratios(model, joint).into_iter().filter(|_| from_current);
    let ratios = ratios.map(|factor| (factor, Change::Ratio(joint, factor)));
    let off = |factor: f64| (factor / needed).ln().abs();
    let mut named: Vec<(f64, Change)> =
        scales.chain(ratios).filter(|(factor, _)| *factor > 0.0 && off(*factor) < MODEL_FACTOR.ln()).collect();
    named.sort_by(|a, b| off(a.0).total_cmp(&off(b.0)));
    let mut changes: Vec<Change> = named.into_iter().map(|(_, change)| change).collect();
    // Any factor may be that of a wrong torque constant; a constant of one was never set.
    let unset = from_current && model.joints[joint].motor.is_some_and(|motor| motor.torque_constant == 1.0);
    changes.insert(if unset { 0 } else { changes.len() }, Change::TorqueScale(Some(joint), needed));
    let change = changes.remove(0);
    let evidence = Evidence::Size([estimate, size.least, size.largest]);
    Culprit { change, alternatives: changes, joint, evidence }
}

//! Reversals and rests of a joint in the rows of a motion.

use super::observe::rest_speed;
use crate::effects::Motion;

/// [s] Time after a reversal that is examined.
pub const AFTER_REVERSAL: f64 = 2.0;

/// [s] Time before a reversal at which its zone begins.
pub const BEFORE_REVERSAL: f64 = 0.1;

/// [s] Time since the last reversal of a joint, negative within [`BEFORE_REVERSAL`] of the next one; NaN elsewhere.
pub fn since_reversal(motion: &Motion, joint: usize) -> Vec<f64> {
    let m = &motion.joints[joint];
    let fastest = m.v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let rest = rest_speed(motion.model, joint, fastest);
    let mut since = vec![f64::NAN; motion.rows()];
    let mut last: Option<(usize, f64)> = None;
    let mut turned: Option<f64> = None;
    for row in 0..motion.rows() {
        if row > 0 && motion.part[row] != motion.part[row - 1] {
            (last, turned) = (None, None);
        }
        let v = m.v[row];
        if v.abs() >= rest {
            if last.is_some_and(|(_, before)| before * v < 0.0) {
                turned = Some(motion.time[row]);
                let first = last.map_or(row, |(at, _)| at + 1);
                mark_before(&motion.time, first, motion.time[row], &mut since);
            }
            last = Some((row, v));
        }
        if let Some(turned) = turned {
            since[row] = motion.time[row] - turned;
        }
    }
    since.iter_mut().filter(|t| **t > AFTER_REVERSAL).for_each(|t| *t = f64::NAN);
    since
}

/// Assigns the rows up to `end` (excluded) that lie shortly before a reversal at `turned` to this reversal, not to the previous one.
fn mark_before(time: &[f64], end: usize, turned: f64, since: &mut [f64]) {
    for row in (0..end).rev().take_while(|row| turned - time[*row] <= BEFORE_REVERSAL && time[*row] <= turned) {
        since[row] = time[row] - turned;
    }
}

/// [s] Duration of each rest of a joint's rotor before it starts to move.
pub fn rests(motion: &Motion, joint: usize) -> Vec<f64> {
    let m = &motion.joints[joint];
    let fastest = m.v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let rest = rest_speed(motion.model, joint, fastest);
    let mut rests = Vec::new();
    let mut since: Option<usize> = None;
    for row in 0..motion.rows() {
        if since.is_some_and(|since| motion.part[since] != motion.part[row]) {
            since = None;
        }
        match (m.v[row].abs() < rest, since) {
            (true, None) => since = Some(row),
            (false, Some(begin)) => {
                rests.push(motion.time[row] - motion.time[begin]);
                since = None;
            }
            _ => {}
        }
    }
    rests
}

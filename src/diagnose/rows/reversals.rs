//! Reversals and rests of a joint in the rows of a motion.

use super::widths::rest_speed;
use crate::effects::Motion;

/// [s] Time after a reversal that is examined.
pub const AFTER_REVERSAL: f64 = 2.0;

/// [s] Time before a reversal at which its zone begins.
pub const BEFORE_REVERSAL: f64 = 0.1;

/// [rad/s or m/s] Speed below which a joint counts as at rest.
pub fn rest(motion: &Motion, joint: usize) -> f64 {
    let fastest = motion.joints[joint].v.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    rest_speed(motion.model, joint, fastest)
}

/// Direction in which a joint moves in each row: −1 or +1; 0 at rest.
pub fn heading(motion: &Motion, joint: usize) -> Vec<i8> {
    let rest = rest(motion, joint);
    motion.joints[joint].v.iter().map(|v| if v.abs() < rest { 0 } else { v.signum() as i8 }).collect()
}

/// Rows in whose kernel a joint rests, or [sticks](super::direction::sticks) between two slips: friction there is whatever holds it. Where one row shows
/// that, it is so in the kernels that reach to the middle of that row's.
pub fn held(motion: &Motion, joint: usize) -> Vec<bool> {
    let m = &motion.joints[joint];
    let mut held = vec![false; motion.rows()];
    let is_held = |row: &usize| m.direction[*row] == 0.0 || m.sticks.get(*row).is_some_and(|sticks| *sticks != 0.0);
    for row in (0..motion.rows()).filter(is_held) {
        let near = |other: &usize| {
            let distance = (motion.time[*other] - motion.time[row]).abs();
            motion.part[*other] == motion.part[row] && distance <= motion.half_width[*other]
        };
        (0..=row).rev().take_while(near).for_each(|other| held[other] = true);
        (row..motion.rows()).take_while(near).for_each(|other| held[other] = true);
    }
    held
}

/// [s] Time since the last reversal of a joint, negative within [`BEFORE_REVERSAL`] of the next one; NaN elsewhere. A reversal is the first
/// row in which the joint moves in the other direction, with or without a rest before it.
pub fn since_reversal(motion: &Motion, joint: usize) -> Vec<f64> {
    let heading = heading(motion, joint);
    let mut since = vec![f64::NAN; motion.rows()];
    let mut last: Option<usize> = None;
    let mut turned: Option<f64> = None;
    for row in 0..motion.rows() {
        if row > 0 && motion.part[row] != motion.part[row - 1] {
            (last, turned) = (None, None);
        }
        if heading[row] != 0 {
            if let Some(last) = last.filter(|last| heading[*last] != heading[row]) {
                turned = Some(motion.time[row]);
                mark_before(&motion.time, last + 1, motion.time[row], &mut since);
            }
            last = Some(row);
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

/// Whether each row is within `margin` [s] of a reversal: from before the joint last moved in the one direction until after it first moves in
/// the other.
pub fn near_reversal(motion: &Motion, joint: usize, margin: f64) -> Vec<bool> {
    let heading = heading(motion, joint);
    let mut near = vec![false; motion.rows()];
    let mut last: Option<usize> = None;
    for row in (0..motion.rows()).filter(|row| heading[*row] != 0) {
        let same = |other: &usize| motion.part[*other] == motion.part[row];
        if let Some(before) = last.filter(|before| same(before) && heading[*before] != heading[row]) {
            let from = motion.time[before] - margin;
            let to = motion.time[row] + margin;
            (0..row).rev().take_while(|k| same(k) && motion.time[*k] > from).for_each(|k| near[k] = true);
            (row..motion.rows()).take_while(|k| same(k) && motion.time[*k] < to).for_each(|k| near[k] = true);
        }
        last = Some(row);
    }
    near
}

/// [s] Duration of each rest of a joint's rotor before it starts to move.
pub fn rests(motion: &Motion, joint: usize) -> Vec<f64> {
    let heading = heading(motion, joint);
    let mut rests = Vec::new();
    let mut since: Option<usize> = None;
    for (row, heading) in heading.into_iter().enumerate() {
        if since.is_some_and(|since| motion.part[since] != motion.part[row]) {
            since = None;
        }
        match (heading, since) {
            (0, None) => since = Some(row),
            (1 | -1, Some(begin)) => {
                rests.push(motion.time[row] - motion.time[begin]);
                since = None;
            }
            _ => {}
        }
    }
    rests
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::path::Path;

    use super::*;
    use crate::diagnose::rows::observe::observe;
    use crate::diagnose::rows::widths::FAITHFUL;
    use crate::effects::drawn::{MODEL, ROBOT};
    use crate::robot::Model;
    use crate::timeseries::{Channel, JointSeries, TimeSeries};

    /// [s] Time between the starts of two slips, and duration of each.
    const PERIOD: f64 = 0.6;
    const SLIP: f64 = 0.3;

    /// [s] Time since a slip began.
    fn since(t: f64) -> f64 {
        t - (t / PERIOD).floor() * PERIOD
    }

    /// A joint that slips by 20 mrad twice in 1.2 s, always in the same direction, and sticks in between. A row in the middle of whose kernel it sticks is
    /// held; one in whose kernel it slides, but for less than half of the half width beside it, is not. The encoder is
    /// fine enough for both: with coarse counts nobody can tell how long it sticks.
    #[test]
    fn property_rows_in_which_a_joint_sticks_are_held() {
        let encoder = "[joints.joint1.encoder]\ncounts_per_turn = 2e6\n";
        let model = Model::from_texts(&format!("{MODEL}{encoder}"), ROBOT, Path::new("model.toml")).expect("a model");
        let count = model.joints[0].encoder_step();
        let time: Vec<f64> = (0..20_000).map(|k| 1e-3 * f64::from(k)).collect();
        let slipped = |t: f64| 0.5 * (1.0 - (PI * (since(t) / SLIP).min(1.0)).cos());
        let position = |t: &f64| (0.02 * ((t / PERIOD).floor() + slipped(*t)) / count).round() * count;
        let current = |t: &f64| 0.5 + since(*t);
        let channels = [
            (Channel::Position, time.iter().map(position).collect::<Vec<f64>>().into()),
            (Channel::Current, time.iter().map(current).collect::<Vec<f64>>().into()),
        ];
        let joint = JointSeries { name: "joint1".to_owned(), channels: channels.into() };
        let session = TimeSeries { name: "one".to_owned(), time, joints: vec![joint] };
        let motion = observe(&model, &[&session], &[0.25], FAITHFUL).expect("enough motion");
        let held = held(&motion, 0);
        let mut slides = 0;
        for (row, held) in held.into_iter().enumerate() {
            let (t, w) = (since(motion.time[row]), motion.half_width[row]);
            let sticks = (w - t).max(t + w - SLIP);
            assert!(held || sticks < w, "{t} of {SLIP}, {w}: {sticks}");
            assert!(!held || sticks > -0.5 * w, "{t} of {SLIP}, {w}: {sticks}");
            slides += usize::from(!held);
        }
        assert!(slides > 100, "{slides}");
    }
}

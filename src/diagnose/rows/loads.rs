//! Rows under a load that holds its link on a flank, whatever floats.
//!
//! A link that floats in its gap takes away its own torque and its friction, at most `|T| + 0.35 F_C`, and as much again leaves room for the
//! links of other joints. A nominal model that is off within its stated accuracy leaves some `σ` beside it,
//! and so does a fit of rows that move more slowly. Where rigid body and friction leave
//!
//! ```text
//!   |e| > 2 (|T| + 0.35 F_C) + 3 σ,      |e| > 5 s
//! ```
//! in the mean over ±0.1 s, something presses: a contact, or a current that comes late. The second bound asks for more than what is typical, `s`, of
//! the rigid zone.
//! A row of the rigid zone is wrong about a link only where its torque is in doubt, `|T| < 0.35 F_C`: there the first term is `2 · 0.35 F_C`.

use super::reversals::heading;
use super::zones::{RIGID, settled};
use crate::effects::Motion;
use crate::identify::statistics::typical;

/// [1] Multiple of what the joint's own link takes away when it floats.
const FLOATING: f64 = 2.0;
/// [1] Standard deviations of the predicted torque: one fit in 370 is off by more in a row.
const DEVIATIONS: f64 = 3.0;
/// [1] Multiple of what the rows of the zone leave over typically: chance leaves no row of millions beyond.
const UNLIKE: f64 = 5.0;

/// What a fit leaves over in the rows of a joint.
pub struct LeftOver<'a> {
    /// `e[row]` [N·m or N] Torque that rigid body and friction leave.
    pub torque: &'a [f64],
    /// `σ[row]` [N·m or N]: how far the fit and the nominal model can be off there. Asked only where something may press.
    pub error: &'a dyn Fn() -> Vec<f64>,
    /// `F_C` [N·m or N]
    pub coulomb: f64,
}

/// A joint's zone with the rows under an overwhelming load that it does not show already.
pub fn with_overwhelmed(
    zone: &[bool],
    motion: &Motion,
    joint: usize,
    left_over: &LeftOver,
    held_out: &[bool],
) -> Vec<bool> {
    let unlike = unlike(zone, left_over, held_out);
    let mut all = zone.to_vec();
    for (row, _) in pressed(zone, motion, joint, left_over, unlike) {
        all[row] = true;
    }
    all
}

/// [N·m or N] More than what is typical of the training rows of a zone.
pub fn unlike(zone: &[bool], left_over: &LeftOver, held_out: &[bool]) -> f64 {
    let shown = (0..zone.len()).filter(|row| zone[*row] && !held_out[*row]).map(|row| left_over.torque[row]);
    UNLIKE * typical(shown)
}

/// Rows under a load of more than `least` [N·m or N], with the load. Not those whose kernel contains a turn or a rest, with friction of either sign.
pub fn pressed(zone: &[bool], motion: &Motion, joint: usize, left_over: &LeftOver, least: f64) -> Vec<(usize, f64)> {
    let pressing = settled(motion, left_over.torque);
    let magnitude: Vec<f64> = motion.joints[joint].link_torque.iter().map(|torque| torque.abs()).collect();
    let link = settled(motion, &magnitude);
    let friction = RIGID.doubt[0].abs() * left_over.coulomb;
    let doubt = |row: usize| FLOATING * (friction + if zone[row] { 0.0 } else { link[row] });
    let heading = heading(motion, joint);
    let may_press = |row: &usize| pressing[*row].abs() > least.max(doubt(*row)) && is_steady(motion, &heading, *row);
    let pressed: Vec<usize> = (0..pressing.len()).filter(may_press).collect();
    if pressed.is_empty() {
        return Vec::new();
    }
    let error = settled(motion, &(left_over.error)());
    let presses = |row: &usize| pressing[*row].abs() > doubt(*row) + DEVIATIONS * error[*row];
    pressed.into_iter().filter(presses).map(|row| (row, pressing[row])).collect()
}

/// Those of the loaded rows that follow one another for longer than `shortest` [s] from the first to the last, and how long they do in all [s].
pub fn lasting(motion: &Motion, loaded: &[(usize, f64)], shortest: f64) -> (Vec<(usize, f64)>, f64) {
    let one_load = |a: &(usize, f64), b: &(usize, f64)| b.0 == a.0 + 1 && motion.part[a.0] == motion.part[b.0];
    let duration = |load: &[(usize, f64)]| motion.time[load[load.len() - 1].0] - motion.time[load[0].0];
    let lasting: Vec<&[(usize, f64)]> = loaded.chunk_by(one_load).filter(|load| duration(load) > shortest).collect();
    (lasting.concat(), lasting.iter().map(|load| duration(load)).sum())
}

/// Whether a joint moves in one direction in all rows that the kernel of a row contains.
fn is_steady(motion: &Motion, heading: &[i8], row: usize) -> bool {
    let near = |other: &usize| {
        motion.part[*other] == motion.part[row]
            && (motion.time[*other] - motion.time[row]).abs() <= motion.half_width[row]
    };
    let same = |other: usize| heading[other] == heading[row] && heading[other] != 0;
    (0..=row).rev().take_while(near).all(same) && (row..heading.len()).take_while(near).all(same)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::effects::drawn::{LENGTH, MODEL, ROBOT, drawn};
    use crate::robot::Model;

    /// [N·m] A load beside a link torque of up to 2 N·m and a Coulomb friction of 2 N·m: more than twice their sum of 2.7 N·m.
    const LOAD: f64 = 8.0;
    /// [s] When it presses.
    const PRESSED: [f64; 2] = [3.0, 7.0];

    /// Rows that are added where a load presses, by a fit that can be off by `error` [N·m], beside rows that leave `elsewhere` [N·m].
    fn added(motion: &Motion, error: f64, elsewhere: f64) -> Vec<usize> {
        let pressed = |row: &usize| (PRESSED[0]..PRESSED[1]).contains(&motion.time[*row]);
        let rows = 0..motion.rows();
        let zone: Vec<bool> = rows.clone().map(|row| !pressed(&row)).collect();
        let torque: Vec<f64> = rows.clone().map(|row| if pressed(&row) { LOAD } else { elsewhere }).collect();
        let left_over = LeftOver { torque: &torque, error: &|| vec![error; motion.rows()], coulomb: 2.0 };
        let with = with_overwhelmed(&zone, motion, 0, &left_over, &vec![false; motion.rows()]);
        rows.filter(|row| with[*row] && !zone[*row]).collect()
    }

    /// Rows are added under a load, in steady motion only; none where the fit may be off by a third of the load, where other rows leave as
    /// much over, or where the load is no larger than what links take away.
    #[test]
    fn property_rows_are_added_under_a_load_that_nothing_else_explains() {
        let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a good model");
        let motion = drawn(&model, 3, None, LENGTH);
        let found = added(&motion, 0.1, 0.1);
        let m = &motion.joints[0];
        let pressed = motion.time.iter().filter(|time| (PRESSED[0]..PRESSED[1]).contains(*time)).count();
        // The rest lies near turns, whose rows are left out.
        assert!(found.len() > pressed / 3, "{} of {pressed}", found.len());
        let turns = |row: &usize| m.v[row - 1] * m.v[row + 1] < 0.0;
        assert!(!found.iter().any(turns), "a row at a turn");
        assert!(added(&motion, LOAD / 3.0, 0.1).is_empty(), "the fit may be off by as much");
        assert!(added(&motion, 0.1, LOAD / 4.0).is_empty(), "other rows leave over as much");
        let mut heavy = motion.clone();
        heavy.joints[0].link_torque.fill(LOAD / 2.0);
        assert!(added(&heavy, 0.1, 0.1).is_empty(), "a floating link takes away as much");
        let in_zone = |load: f64| {
            let torque = vec![load; heavy.rows()];
            let left_over = LeftOver { torque: &torque, error: &|| vec![0.1; heavy.rows()], coulomb: 2.0 };
            super::pressed(&vec![true; heavy.rows()], &heavy, 0, &left_over, 0.5).len()
        };
        // Twice 0.35 of the friction, and three errors: 1.7 N·m.
        assert!(in_zone(1.8) > heavy.rows() / 3 && in_zone(1.6) == 0, "on its flank it takes away nothing");
    }

    /// Two rows of a joint that sticks and slips are no load that lasts, nor are two that lie in different parts.
    #[test]
    fn property_a_load_lasts_in_rows_that_follow_one_another() {
        let model = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a good model");
        let mut motion = drawn(&model, 3, None, LENGTH);
        let step = motion.time[1] - motion.time[0];
        motion.part[30..].fill(1);
        let rows = [3, 7, 20, 21, 22, 23, 28, 29, 30, 31].map(|row| (row, 1.0));
        let (found, lasts) = lasting(&motion, &rows, 2.5 * step);
        assert_eq!(found, rows[2..6]);
        assert!((lasts - 3.0 * step).abs() < 1e-9, "{lasts}");
        assert!(lasting(&motion, &rows, 3.5 * step).0.is_empty());
    }
}

//! Rows in which the link certainly lies on a flank of its gear. The position of a link that floats or changes its flank is unknown.
//!
//! ```text
//!   T_g = T + ρ F        T torque that the links need, F friction, ρ its share behind the gear
//! ```
//! A row counts if every plausible `ρ` puts the link on the same flank with at least a part of Coulomb friction, over the whole kernel and
//! for the duration of a change of flank before it. If that leaves fewer than two flanks, motion is slow or gravity holds the link; then the
//! rows of the rigid zone count, however weak the torque.

use super::flanks::flanks;
use crate::diagnose::fit::problem::Problem;
use crate::robot::Masses;

/// Smallest and largest share of friction behind the gear: where both put the link on the same flank, it certainly lies there.
const LINK_SHARES: [f64; 2] = [0.05, 0.5];
/// [1] Part of Coulomb friction that the torque on the flank has to exceed, because links with less sometimes float. With 0 a varying gap had
/// a wrong order on two machines of nine (tuning seeds 103, 209 of `tests/gaps`), together with gears of 180 to 210 N·m/rad (3000 true). With
/// 0.25 to 0.35 all nine were right, and eight constant gaps gave no report.
const LOADED: f64 = 0.3;
/// [s] Time in which a link crosses its gap and comes to rest on the other flank: 8 mrad at 4 rad/s² take 0.06 s.
const SETTLING: f64 = 0.1;
/// Number of rows on two flanks above which weakly loaded rows are not needed.
const ENOUGH: usize = 50;

/// Whether the link lies on a flank, row by row.
pub fn contact(problem: &Problem, joint: usize) -> Vec<bool> {
    let motion = &problem.motion;
    let (m, model) = (&motion.joints[joint], &motion.model.joints[joint]);
    if motion.model.masses == Masses::Estimated {
        // With estimated masses, contact cannot be determined.
        return vec![true; motion.rows()];
    }
    let friction = |row: usize| m.friction.dry(m.v[row]) * m.direction[row] + m.friction.viscous * m.v[row];
    let shares = model.friction.map_or(LINK_SHARES, |friction| [friction.link_share; 2]);
    let side = |row: usize, least: f64| {
        let [few, many] = shares.map(|share| m.link_torque[row] + share * friction(row));
        let certain = few * many > 0.0 && few.abs().min(many.abs()) > least;
        if certain { few.signum() } else { 0.0 }
    };
    let loaded: Vec<f64> = (0..motion.rows()).map(|row| side(row, LOADED * m.friction.coulomb)).collect();
    let held: Vec<bool> = (0..motion.rows()).map(|row| settled(problem, &loaded, row)).collect();
    let trained: Vec<f64> =
        (0..motion.rows()).filter(|row| held[*row] && !problem.held_out[*row]).map(|row| loaded[row]).collect();
    if trained.len() >= ENOUGH && flanks(&trained).1 {
        return held;
    }
    (0..motion.rows()).map(|row| problem.judged[joint][row] && side(row, 0.0) != 0.0).collect()
}

/// Whether all rows from [`SETTLING`] before a row's kernel until the end of it have the same flank.
fn settled(problem: &Problem, side: &[f64], row: usize) -> bool {
    let motion = &problem.motion;
    let near = |other: usize| {
        let after = motion.time[other] - motion.time[row];
        let half = motion.half_width[row];
        motion.part[other] == motion.part[row] && (-half - SETTLING..=half).contains(&after)
    };
    let alike = |other: usize| side[other] == side[row];
    side[row] != 0.0
        && (0..row).rev().take_while(|other| near(*other)).all(alike)
        && (row + 1..side.len()).take_while(|other| near(*other)).all(alike)
}

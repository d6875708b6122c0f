//! Rows in which the link lies on a flank of its gear for certain: one that floats in its gap, or changes its flank, is ahead by anything.
//!
//! ```text
//!   T_g = T + ρ F        T what the links need, F friction, ρ its share behind the gear
//! ```
//! A row counts where every likely `ρ` puts the link on the same flank with a part of Coulomb friction at least, since before a change of
//! flank could have ended and over the whole kernel. Where that leaves no two flanks, motion is slow or gravity holds the link: rows count
//! then in which the rigid zone says that the links follow, however weak the torque.

use super::flanks::flanks;
use crate::diagnose::fit::problem::Problem;
use crate::robot::Masses;

/// Least and largest share of friction behind the gear: where both put the link on the same flank it lies there for certain.
const LINK_SHARES: [f64; 2] = [0.05, 0.5];
/// [1] Part of Coulomb friction that the torque on the flank has to exceed: rows with less float now and then. At none a gap that varies came
/// out with a wrong order on two machines of nine (tuning seeds 103, 209 of `tests/gaps`), beside gears of 180 to 210 N·m/rad (3000 true); from
/// 0.25 to 0.35 of friction all nine came out, and eight gaps that do not vary stayed silent.
const LOADED: f64 = 0.3;
/// [s] in which a link crosses its gap and comes to rest on the other flank: 8 mrad at 4 rad/s² take 0.06 s.
const SETTLING: f64 = 0.1;
/// Rows on two flanks that are enough to do without the weakly loaded ones.
const ENOUGH: usize = 50;

/// Whether the link lies on a flank, row by row.
pub fn contact(problem: &Problem, joint: usize) -> Vec<bool> {
    let motion = &problem.motion;
    let (m, model) = (&motion.joints[joint], &motion.model.joints[joint]);
    if motion.model.masses == Masses::Estimated {
        // Where masses are a guess nobody knows when it floats.
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

/// Whether the flank of a row is that of all rows since [`SETTLING`] before its kernel until the end of it.
fn settled(problem: &Problem, side: &[f64], row: usize) -> bool {
    let motion = &problem.motion;
    let near = |other: usize| {
        let after = motion.time[other] - motion.time[row];
        let half = motion.half_width[row];
        motion.session[other] == motion.session[row] && (-half - SETTLING..=half).contains(&after)
    };
    let alike = |other: usize| side[other] == side[row];
    side[row] != 0.0
        && (0..row).rev().take_while(|other| near(*other)).all(alike)
        && (row + 1..side.len()).take_while(|other| near(*other)).all(alike)
}

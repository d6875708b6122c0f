//! Which joints feel that the link of another joint floats in its gap.
//!
//! While the link of joint `j` floats, joint `i` lacks the torque `M_ij a_j`. By its inertia, joint `i` feels joint `j` where `|M_ij| a_j` is more
//! than [`FELT`] of the RMS torque of `i`, because in an arm of six joints some wrist joint reverses almost all the time.
//!
//! An unknown gap may be too small to matter. Then the residual `e` of `i` jumps no more where the link of `j` may float than elsewhere. The
//! jumps `e(t + Δ) − e(t)` of both kinds of rows are compared by Student's t of the scale `s` of those elsewhere:
//! `x = mean ρ(floating) − mean ρ(elsewhere)`, `ρ(d) = (ν + 1)/2 · ln(1 + d²/(ν s²))`.
//! `∂ mean ρ/∂ ln s = −1` at the scale that fits, so `x` is about the logarithm of the ratio of the scales. Slow errors, such as those of an
//! effect that nobody has named yet, cancel in the jumps.

use std::collections::BTreeMap;

use nalgebra::DMatrix;

use super::observe::NOISE_SHARE;
use crate::diagnose::fit::regression::{NU, log_density, scale};
use crate::dynamics::Dynamics;
use crate::effects::Motion;
use crate::timeseries::root_mean_square;

/// [1] Part of a joint's RMS torque that may be neglected: as much as the noise of the acceleration causes in a row.
const FELT: f64 = NOISE_SHARE;
/// Number of poses over which the coupling of the joints is averaged.
const POSES: usize = 16;
/// `Δ` [s] Time of a jump: a link floats for up to 0.2 s after a reversal.
const JUMP: f64 = 0.1;
/// [1] Logarithm of the ratio of scales from which on a gap is felt. A fifth more scatter is what a floating link adds whose torque is two
/// thirds of the residual that is there anyway, `√(1.2² − 1)`.
const MORE_SCATTER: f64 = 0.2;
/// Fewest jumps of either kind of a session that can be compared.
const FEWEST_JUMPS: usize = 30;
/// [s] Jumps within such a time count as one event in the error of their mean.
const EVENT: f64 = 0.5;

/// Whether joint `i` feels the motion of the link of joint `j` in its gap.
#[derive(Debug, Clone, Default)]
pub struct Felt {
    /// `by_inertia[i][j]`: the inertia that couples them is large enough.
    by_inertia: Vec<Vec<bool>>,
    /// `unseen[i][j]`: and yet nothing of a gap shows.
    unseen: Vec<Vec<bool>>,
}

/// Rows in which the flank of a joint's link is known.
pub struct Contact {
    /// For the other joints: the link does not float.
    pub link: Vec<bool>,
    /// For the joint itself: it moves, too.
    pub own: Vec<bool>,
}

impl Felt {
    /// By inertia alone. Rows held out do not decide.
    pub fn by_inertia(motion: &Motion, held_out: &[bool]) -> Self {
        let dof = motion.joints.len();
        let mut dynamics = Dynamics::new(&motion.model.robot);
        let mut mass = DMatrix::zeros(dof, dof);
        let mut coupling = DMatrix::<f64>::zeros(dof, dof);
        let rows = motion.rows();
        for pose in 0..POSES.min(rows) {
            let row = pose * rows / POSES.min(rows);
            let q: Vec<f64> = motion.joints.iter().map(|m| m.q[row]).collect();
            dynamics.mass_matrix(&q, &mut mass);
            coupling += mass.abs() / POSES.min(rows) as f64;
        }
        let misses = |i: usize, j: usize| coupling[(i, j)] * root_mean_square(&motion.joints[j].a);
        let trained = |values: &[f64]| -> Vec<f64> {
            values.iter().zip(held_out).filter(|(_, held_out)| !**held_out).map(|(value, _)| *value).collect()
        };
        let torque: Vec<f64> = motion.joints.iter().map(|m| root_mean_square(&trained(&m.torque))).collect();
        let of_joint = |i: usize| (0..dof).map(|j| i != j && misses(i, j) > FELT * torque[i]).collect();
        Self { by_inertia: (0..dof).map(of_joint).collect(), unseen: vec![vec![false; dof]; dof] }
    }

    /// Whether joint `i` feels the link of joint `j`.
    pub fn feels(&self, i: usize, j: usize) -> bool {
        self.by_inertia[i][j] && !self.unseen[i][j]
    }

    /// The joints of which joint `i` feels nothing, although their inertia would let it.
    pub fn unseen_by(&self, i: usize) -> impl Iterator<Item = usize> {
        (0..self.unseen[i].len()).filter(move |j| self.unseen[i][*j])
    }

    /// Rows of joint `i` in which neither its own link floats nor one that it feels.
    pub fn rigid(&self, i: usize, contacts: &[Contact]) -> Vec<bool> {
        let mut rigid = contacts[i].own.clone();
        for j in (0..contacts.len()).filter(|j| self.feels(i, *j)) {
            rigid.iter_mut().zip(&contacts[j].link).for_each(|(rigid, known)| *rigid &= known);
        }
        rigid
    }

    /// Forgets what does not show: unknown gaps, with the `residual` of a fit to the rigid rows, one per joint.
    pub fn forget_unseen(&mut self, motion: &Motion, contacts: &[Contact], residual: &[Vec<f64>], held_out: &[bool]) {
        let mut unseen = self.unseen.clone();
        for (i, unseen) in unseen.iter_mut().enumerate() {
            let unknown = |j: &usize| self.feels(i, *j) && motion.model.joints[*j].backlash.is_none();
            let doubtful: Vec<usize> = (0..contacts.len()).filter(unknown).collect();
            if doubtful.is_empty() {
                continue;
            }
            let rigid = self.rigid(i, contacts);
            let jumps = jumps(motion, &residual[i], held_out);
            for j in doubtful {
                let kind = |row: usize| match (rigid[row], contacts[i].own[row] && !contacts[j].link[row]) {
                    (true, _) => Some(false),
                    (_, true) => Some(true),
                    _ => None,
                };
                unseen[j] = more_scatter(&jumps, kind).is_some_and(|most| most < MORE_SCATTER);
            }
        }
        self.unseen = unseen;
    }
}

/// Jump of the residual between two rows, in an event of the recording.
struct Jump {
    rows: [usize; 2],
    size: f64,
    session: usize,
    event: (usize, i64),
}

/// The jumps of a residual over [`JUMP`], in the training data.
fn jumps(motion: &Motion, residual: &[f64], held_out: &[bool]) -> Vec<Jump> {
    let mut later = 0;
    let mut from = |row: usize| {
        let same = |later: usize| later < motion.rows() && motion.part[later] == motion.part[row];
        later = later.max(row);
        while same(later) && motion.time[later] - motion.time[row] < JUMP {
            later += 1;
        }
        (same(later) && !held_out[row] && !held_out[later]).then(|| Jump {
            rows: [row, later],
            size: residual[later] - residual[row],
            session: motion.session[row],
            event: (motion.part[row], (motion.time[row] / EVENT) as i64),
        })
    };
    (0..motion.rows()).filter_map(&mut from).collect()
}

/// `x` plus its standard error, the mean over the sessions by the number of their floating jumps; `None` where too few can be compared. A session is
/// compared with itself, because fast motion leaves larger errors than slow motion. `floating` gives the kind of a row, `None` where it is neither.
fn more_scatter(jumps: &[Jump], floating: impl Fn(usize) -> Option<bool>) -> Option<f64> {
    let mut sessions = BTreeMap::<usize, [Vec<&Jump>; 2]>::new();
    for jump in jumps {
        let [Some(a), Some(b)] = jump.rows.map(&floating) else { continue };
        sessions.entry(jump.session).or_default()[usize::from(a || b)].push(jump);
    }
    let (mut count, mut sum, mut noise) = (0.0, 0.0, 0.0);
    for [elsewhere, afloat] in sessions.values().filter(|kinds| kinds.iter().all(|jumps| jumps.len() >= FEWEST_JUMPS)) {
        let s = scale(&elsewhere.iter().map(|jump| jump.size).collect::<Vec<_>>(), NU);
        let [(elsewhere, noise_elsewhere), (floating, noise_floating)] =
            [elsewhere, afloat].map(|jumps| mean_rho(jumps, s));
        let n = afloat.len() as f64;
        count += n;
        sum += n * (floating - elsewhere);
        noise += n * n * (noise_elsewhere + noise_floating);
    }
    (count > 0.0).then(|| (sum + noise.sqrt()) / count)
}

/// Mean of `ρ`, and the variance of this mean from the scatter between events.
fn mean_rho(jumps: &[&Jump], s: f64) -> (f64, f64) {
    let rho = |jump: &Jump| -log_density(jump.size, s, NU);
    let mean = jumps.iter().map(|jump| rho(jump)).sum::<f64>() / jumps.len() as f64;
    let mut events = BTreeMap::<_, f64>::new();
    for jump in jumps {
        *events.entry(jump.event).or_default() += rho(jump) - mean;
    }
    (mean, events.values().map(|sum| sum * sum).sum::<f64>() / (jumps.len() as f64).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Jumps of two sessions; in the second one everything is ten times as large. Those of the first hundred rows float, `factor` times as large.
    fn jumps(factor: f64) -> Vec<Jump> {
        let of_row = |row: usize| {
            let (session, place) = (row / 1000, row % 1000);
            let afloat = if place < 100 { factor } else { 1.0 };
            // Low-discrepancy numbers from −1 to 1.
            let even = 2.0 * (row as f64 * 0.618_034).fract() - 1.0;
            Jump {
                rows: [row, row],
                size: even * afloat * 10_f64.powi(session as i32),
                session,
                event: (0, row as i64),
            }
        };
        (0..2000).map(of_row).collect()
    }

    #[test]
    fn property_sessions_are_compared_with_themselves_and_more_scatter_is_seen() {
        let floating = |row: usize| Some(row % 1000 < 100);
        let (alike, wider) = (more_scatter(&jumps(1.0), floating), more_scatter(&jumps(1.5), floating));
        // The logarithm of the ratio is 0 and 0.41, and its standard error of some 0.7/√200 = 0.05 is added. The slope of mean ρ is 1 at the scale that fits
        // and grows from there, the more the fewer outliers there are: to 2 at most with even numbers.
        assert!(alike.is_some_and(|x| (0.0..0.1).contains(&x)), "{alike:?}");
        assert!(wider.is_some_and(|x| (0.41..0.82).contains(&x)), "{wider:?}");
        assert_eq!(more_scatter(&jumps(1.0), |row| Some(row < 20)), None);
    }
}

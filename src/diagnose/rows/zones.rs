//! The rigid zone: rows in which the links are known to follow the rotors.
//!
//! Around reversals, and where the torque through the gear changes its sign, a link floats in its gap. The other joints feel its motion.
//! Rows from 0.1 s before to 0.2 s after a reversal, and from 0.1 s before to 0.15 s after a change of flank, are left out on all joints,
//! each extended by the half width of its kernel. The flank in contact is not measured: with a link torque `T` (inertia, gravity) and
//! friction of `0.15` to `0.35` of Coulomb friction behind the gear, the flank is in doubt while
//! `−0.35 < T sgn v / F_C < −0.15`. Another share of friction moves the change of flank only within the times that are left out anyway.
//! Other loads on a link, such as a contact, are not in `T`. Where rigid body and friction leave more torque than an error of friction
//! can explain, that torque is added to `T`. A joint without a gap is rigid everywhere. Of its own rows only rests
//! are left out, where friction is whatever holds the joint, and turns and rests that a kernel mixes with motion.
//!
//! Two rules reduce what is left out. A gap `b` that the model file gives is crossed in about `√(2 b/a)`, with the RMS acceleration `a` of
//! the joint: nothing is left out for longer than [`CROSSINGS`] times that. And joint `i` feels joint `j` only where `|M_ij| a_j` is more
//! than [`FELT`] of the RMS torque of `i`, because in an arm of six joints some wrist joint reverses almost all the time.

use nalgebra::DMatrix;

use super::reversals::heading;
use super::widths::NOISE_SHARE;
use crate::dynamics::Dynamics;
use crate::effects::Motion;
use crate::timeseries::root_mean_square;
use crate::units::JointKind;

// With longer margins and doubt from −0.6 to −0.08, a fast run kept one row in twenty to eighty. A contact that pressed on a joint for
// seconds was lost, and of four rotors with inertias 25 % or 12 % off one was named. With these margins all four are named, and one row
// in six is kept (tuning seeds 3800 to 3802, 5600 to 5701, 6501 of `benches/blind`).
/// For the fit: a floating link must not be taken for an effect. Robust fits tolerate the floating rows that remain.
pub const RIGID: Margins = Margins { reversal: [0.1, 0.2], flank: [0.1, 0.15], doubt: [-0.35, -0.15] };
/// For error figures, which are plain RMS: a few floating rows would dominate them.
pub const JUDGED: Margins = Margins { reversal: [0.1, 0.4], flank: [0.15, 0.3], doubt: [-0.6, -0.08] };
/// [1] Part of Coulomb friction above which a torque that neither rigid body nor friction explains counts as a load. Smaller torques can
/// come from friction of another law.
const LOADED: f64 = 0.6;
/// [s] Half of the time over which the load is averaged before the flank is judged.
const SETTLING: f64 = 0.1;
/// [1] Multiple of the crossing time of a gap after which the link rests on the other flank. For an unknown gap 0.2 s are left out, which
/// corresponds to 8 mrad at 4 rad/s².
const CROSSINGS: f64 = 3.0;
/// [1] Part of a joint's RMS torque that may be neglected: as much as the noise of the acceleration causes in a row.
const FELT: f64 = NOISE_SHARE;
/// Number of poses over which the coupling of the joints is averaged.
const POSES: usize = 16;

/// How wide an unknown gap may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Widest {
    /// Of any width: nothing is known of the gear.
    Any,
    /// As wide as gears of robots become: 50 arc minutes, three times those of a standard planetary gear; half a millimetre on a screw.
    OfGears,
    /// A precise gear: 10 arc minutes; a tenth of a millimetre.
    Precise,
    /// None: the link follows its rotor.
    None,
}

impl Widest {
    /// From the most careful to the least.
    pub const ALL: [Self; 4] = [Self::Any, Self::OfGears, Self::Precise, Self::None];

    /// What it means for the rows, to be added to a sentence.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Any => "",
            Self::OfGears => " (unknown gaps assumed to be at most 15 mrad or 0.5 mm, otherwise too few rows remain)",
            Self::Precise => " (unknown gaps assumed to be at most 3 mrad or 0.1 mm, otherwise too few rows remain)",
            Self::None => " (unknown gaps assumed to be zero, otherwise too few rows remain)",
        }
    }

    /// [rad or m]
    const fn gap(self, kind: JointKind) -> f64 {
        match (self, kind) {
            (Self::Any, _) => f64::INFINITY,
            (Self::OfGears, JointKind::Revolute) => 0.015,
            (Self::OfGears, JointKind::Prismatic) => 5e-4,
            (Self::Precise, JointKind::Revolute) => 0.003,
            (Self::Precise, JointKind::Prismatic) => 1e-4,
            (Self::None, _) => 0.0,
        }
    }
}

/// Times and torques that are left out.
#[derive(Debug, Clone, Copy)]
pub struct Margins {
    /// [s] Before and after a reversal.
    pub reversal: [f64; 2],
    /// [s] Before and after a change of flank.
    pub flank: [f64; 2],
    /// Range of `T sgn v / F_C` in which the flank is in doubt.
    pub doubt: [f64; 2],
}

/// State of a joint in a row.
#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Rest,
    /// Direction, and whether the link is driven (or drives the motor).
    Carried(bool, bool),
    InDoubt(bool),
}

/// Whether each row of each joint is rigid: `zones[joint][row]`. Inputs are the current estimate of the Coulomb friction `F_C` and, after a
/// first fit, the torque that rigid body and friction leave in all rows. Held-out rows have zones, but do not decide what a joint feels.
pub fn rigid_zone(
    motion: &Motion,
    coulomb: &[f64],
    left_over: Option<&[Vec<f64>]>,
    held_out: &[bool],
    margins: &Margins,
    widest: Widest,
) -> Vec<Vec<bool>> {
    let dof = motion.joints.len();
    let felt = felt(motion, held_out);
    let mut zones = vec![vec![true; motion.rows()]; dof];
    for joint in 0..dof {
        let gap = motion.model.joints[joint].backlash.unwrap_or_else(|| widest.gap(motion.model.joints[joint].kind));
        let load = load(motion, joint, coulomb[joint], left_over.map(|left_over| left_over[joint].as_slice()));
        let doubt = (gap > 0.0).then(|| margins.doubt.map(|share| share * coulomb[joint]));
        let states = states(motion, joint, &load, doubt);
        let known = known(motion, &states, margins, longest(motion, joint, gap));
        for (other, zone) in zones.iter_mut().enumerate() {
            let of_row = |row: usize| known[row] && (other != joint || !matches!(states[row], State::Rest));
            if other == joint || (gap > 0.0 && felt[other][joint]) {
                zone.iter_mut().enumerate().for_each(|(row, rigid)| *rigid &= of_row(row));
            }
        }
    }
    zones
}

/// Whether joint `i` feels the motion of the link of joint `j` in its gap: `felt[i][j]`.
fn felt(motion: &Motion, held_out: &[bool]) -> Vec<Vec<bool>> {
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
    (0..dof).map(|i| (0..dof).map(|j| i == j || misses(i, j) > FELT * torque[i]).collect()).collect()
}

/// [s] Longest time that the link of a joint takes through its gap [rad or m].
fn longest(motion: &Motion, joint: usize, gap: f64) -> f64 {
    if gap.is_infinite() {
        return f64::INFINITY;
    }
    CROSSINGS * (2.0 * gap / root_mean_square(&motion.joints[joint].a).max(1e-9)).sqrt()
}

/// Known torque through the gear: that of the nominal link, and that of loads on it.
fn load(motion: &Motion, joint: usize, coulomb: f64, left_over: Option<&[f64]>) -> Vec<f64> {
    let mut load = settled(motion, &motion.joints[joint].link_torque);
    if let Some(left_over) = left_over {
        let pressing = settled(motion, left_over);
        let strong = |pressing: &f64| pressing.abs() > LOADED * coulomb;
        load.iter_mut().zip(&pressing).filter(|(_, pressing)| strong(pressing)).for_each(|(load, p)| *load += p);
    }
    load
}

/// State of a joint in each row, by the `load` on its link and the loads between which the flank is in `doubt`; `None` without a gap.
fn states(motion: &Motion, joint: usize, load: &[f64], doubt: Option<[f64; 2]>) -> Vec<State> {
    let state = |(heading, load): (i8, &f64)| match (load * f64::from(heading), doubt) {
        _ if heading == 0 => State::Rest,
        (driven, Some([low, high])) if driven <= high && driven >= low => State::InDoubt(heading > 0),
        (driven, Some([low, _])) if driven < low => State::Carried(heading > 0, false),
        _ => State::Carried(heading > 0, true),
    };
    heading(motion, joint).into_iter().zip(load).map(state).collect()
}

/// Running mean, so that noise of the acceleration does not change flanks.
pub fn settled(motion: &Motion, values: &[f64]) -> Vec<f64> {
    let (mut first, mut last, mut sum) = (0, 0, 0.0);
    let near =
        |a: usize, b: usize| motion.part[a] == motion.part[b] && (motion.time[a] - motion.time[b]).abs() <= SETTLING;
    (0..values.len())
        .map(|row| {
            while last < values.len() && (last <= row || near(last, row)) {
                sum += values[last];
                last += 1;
            }
            while !near(first, row) {
                sum -= values[first];
                first += 1;
            }
            sum / (last - first) as f64
        })
        .collect()
}

/// Rows in which the flank of a joint is known; nothing is left out for longer than `longest` [s], apart from the width of the kernels.
fn known(motion: &Motion, states: &[State], margins: &Margins, longest: f64) -> Vec<bool> {
    let mut known: Vec<bool> = states.iter().map(|state| !matches!(state, State::InDoubt(_))).collect();
    for row in 1..states.len() {
        if states[row] == states[row - 1] || motion.session[row] != motion.session[row - 1] {
            continue;
        }
        let turned = match (states[row - 1], states[row]) {
            (State::Rest, _) | (_, State::Rest) => true,
            (State::Carried(a, _) | State::InDoubt(a), State::Carried(b, _) | State::InDoubt(b)) => a != b,
        };
        let [before, after] = if turned { margins.reversal } else { margins.flank }.map(|time| time.min(longest));
        let w = motion.half_width[row];
        let (from, to) = (motion.time[row] - before - w, motion.time[row] + after + w);
        let same = |other: usize| motion.session[other] == motion.session[row];
        (0..row).rev().take_while(|other| same(*other) && motion.time[*other] >= from).for_each(|r| known[r] = false);
        let later = (row..states.len()).take_while(|other| same(*other) && motion.time[*other] <= to);
        later.for_each(|other| known[other] = false);
    }
    known
}

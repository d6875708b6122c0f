//! Torque constants that the model guesses, from the torque of inertia and weight.
//!
//! A first model of a URDF states constants with an accuracy of 1: the true one may be several times as large. With `f` the true constant over the guess
//! and `y` the torque that follows from the guess, the [balance](super::balance) of a joint is linear in `f`,
//!
//! ```text
//!   f y = I + G + δ₁ G₁ + δ₂ G₂ + Σ μ_k P_k + κ L + J v̇ + friction + k q + c
//! ```
//! Tilt `δ` and payload `μ` are the same on all joints, so all are solved at once: a load on a wrist would be taken for a small constant there. The residual of
//! a joint has the weight `1/u`, `u` its mean square; it is not taken to be smaller than what a model of usual accuracy leaves. Spring `k` and offset `c` are
//! left out of a joint whose constant they would leave undetermined, as over a short way they are the weight.
//!
//! A constant is replaced where the residual is a small part of what `y` shows beside friction. All stages work with the model that this gives, because
//! their fits are linear in the constants, and a load or a tilt has one size on all joints only if the constants of these joints are nearly right.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};

use super::balance::{COLUMNS, Columns, FULL, Normal, bounds};
use super::{rows, training_parts};
use crate::diagnose::rows::division::Division;
use crate::linear::Equilibrated;
use crate::robot::{Masses, Model};
use crate::timeseries::{Channel, TimeSeries};

/// `s_K` [1] Accuracy from which on constants are guesses: the true one may be twice or half of it.
const GUESS: f64 = 0.5;
/// Columns of tilt and payload.
const SHARED: std::ops::Range<usize> = 2..FULL;
/// Number of those of a tilt, which are the first.
const TILT: usize = 2;
/// Column of the spring; the offset follows.
const SPRING: usize = COLUMNS - 2;
/// Column of the torque.
const TORQUE: usize = COLUMNS;
/// [1] Residual that a model of usual accuracy leaves, as a share of inertia and weight.
const LEAST: f64 = 0.05;
/// [1] Residual, as a share of what the torque shows beside friction, below which `f` is right within a tenth: it is too small by the square of this.
const DETERMINED: f64 = 0.3;
/// [1] A guess that is off by more is another mistake, such as a unit.
const FURTHEST: f64 = 30.0;
/// Repetitions of the fit, each with the weights of the last.
const REPETITIONS: usize = 8;

/// The model with constants that agree with inertia and weight in the training data, where its own are guesses and the recordings hold currents.
pub fn with_constants<'m>(model: &'m Model, sessions: &[&TimeSeries], division: Division) -> Cow<'m, Model> {
    let mut scaled = Cow::Borrowed(model);
    if model.accuracy.torque_constants < GUESS || model.masses == Masses::Estimated {
        return scaled;
    }
    let trained = training_parts(sessions, division);
    let parts: Vec<Cow<TimeSeries>> = trained.iter().flat_map(|session| session.uninterrupted()).collect();
    let parts: Vec<&TimeSeries> = parts.iter().map(AsRef::as_ref).collect();
    let has_current = |name: &str| {
        let current = |part: &&TimeSeries| part.joint(name).is_some_and(|joint| joint.get(Channel::Current).is_some());
        let torque = |part: &&TimeSeries| part.joint(name).is_some_and(|joint| joint.get(Channel::Torque).is_some());
        parts.iter().all(current) && !parts.iter().any(torque)
    };
    if model.joints.is_empty() || parts.is_empty() {
        return scaled;
    }
    let rows = rows::rows(model, &parts);
    let moves = |session: usize, joint: usize, row: usize| rows[session].joints[joint].moves[row];
    let normals = Columns::new(model, &rows).normals(&rows, &moves);
    for (joint, factor) in factors(&normals, &bounds(model)).into_iter().enumerate() {
        let Some(factor) = factor.filter(|_| has_current(&model.joints[joint].name)) else { continue };
        if let Some(motor) = &mut scaled.to_mut().joints[joint].motor {
            motor.torque_constant *= factor;
        }
    }
    scaled
}

/// What became of the constants of a model, a clause for the report; empty where nothing did.
pub fn words(given: &Model, used: &Model) -> String {
    let constant = |model: &Model, joint: usize| model.joints[joint].motor.map(|motor| motor.torque_constant);
    let of_joint = |joint: usize| {
        let [guess, found] = [given, used].map(|model| constant(model, joint));
        let (guess, found) = (guess?, found?);
        (guess != found).then(|| format!("{} {guess:.3} to {found:.3}", given.joints[joint].name))
    };
    match (0..given.joints.len()).filter_map(of_joint).collect::<Vec<_>>().join(", ") {
        none if none.is_empty() => none,
        list => format!(
            "; torque constants that the model file guesses were first brought into agreement with inertia and weight: {list} [N·m/A]"
        ),
    }
}

/// Products of `y`, the shared columns and `I + G` of a joint, without what friction and rotor explain, and a spring and an offset where they are asked for.
struct Reduced {
    torque: f64,
    of_torque: DVector<f64>,
    shared: DMatrix<f64>,
    of_shared: DVector<f64>,
    rigid: f64,
    by_rigid: f64,
    rows: f64,
    /// Least sum of squares that a model of usual accuracy leaves.
    least: f64,
}

impl Reduced {
    /// `None` where there is too little motion.
    fn new(normal: &Normal, with_spring: bool) -> Option<Self> {
        if normal.is_short() {
            return None;
        }
        let mut gram = normal.with_torque();
        // `I + G` in the place of `I`.
        let weight = gram.row(1).into_owned();
        gram.row_mut(0).zip_apply(&weight, |own, weight| *own += weight);
        let weight = gram.column(1).into_owned();
        gram.column_mut(0).zip_apply(&weight, |own, weight| *own += weight);
        let least = LEAST * LEAST * gram[(0, 0)].max(f64::MIN_POSITIVE);
        let kept: Vec<usize> = [TORQUE, 0].into_iter().chain(SHARED).collect();
        let nuisance: Vec<usize> = (FULL..if with_spring { COLUMNS } else { SPRING })
            .filter(|column| gram[(*column, *column)] > 0.0)
            .collect();
        let of = |rows: &[usize], columns: &[usize]| gram.select_rows(rows).select_columns(columns);
        let cross = of(&nuisance, &kept);
        let factor = Equilibrated::new(&of(&nuisance, &nuisance))?;
        let mut left = of(&kept, &kept);
        for (column, cross_column) in cross.column_iter().enumerate() {
            let explained = cross.tr_mul(&factor.solve(&cross_column.into_owned()));
            left.column_mut(column).zip_apply(&explained, |own, explained| *own -= explained);
        }
        let count = SHARED.len();
        Some(Self {
            torque: left[(0, 0)],
            rigid: left[(1, 1)],
            by_rigid: left[(0, 1)],
            of_torque: left.view((2, 0), (count, 1)).column(0).into_owned(),
            of_shared: left.view((2, 1), (count, 1)).column(0).into_owned(),
            shared: left.view((2, 2), (count, count)).into_owned(),
            rows: normal.rows() as f64,
            least,
        })
    }

    /// `f` of least squares beside these shared coefficients.
    fn factor(&self, beta: &DVector<f64>) -> f64 {
        (self.by_rigid + beta.dot(&self.of_torque.rows(0, beta.len()))) / self.torque
    }

    /// Sum of squares of `f y − β S − (I + G)`.
    fn left(&self, f: f64, beta: &DVector<f64>) -> f64 {
        let count = beta.len();
        let of_beta =
            beta.dot(&(self.shared.view((0, 0), (count, count)) * beta + 2.0 * self.of_shared.rows(0, count)));
        let of_torque = f * (f * self.torque - 2.0 * beta.dot(&self.of_torque.rows(0, count)) - 2.0 * self.by_rigid);
        (of_torque + of_beta + self.rigid).max(0.0)
    }
}

/// `f` of each joint where it is determined, beside a tilt and, unless its mass were negative, a payload. `limits`: bounds of the balance's coefficients.
fn factors(normals: &[Normal], limits: &[[f64; 2]; COLUMNS]) -> Vec<Option<f64>> {
    let usual: Vec<f64> = limits[SHARED].iter().map(|[_, high]| *high).collect();
    let solved = |reduced: &[Option<Reduced>]| {
        let (with_load, beta) = solved(reduced, &usual);
        if beta.iter().skip(TILT).sum::<f64>() >= 0.0 { with_load } else { solved(reduced, &usual[..TILT]).0 }
    };
    let mut reduced: Vec<Option<Reduced>> = normals.iter().map(|normal| Reduced::new(normal, true)).collect();
    let found = solved(&reduced);
    // Over a short way the weight is a spring and an offset.
    for index in (0..normals.len()).filter(|index| found[*index].is_none()) {
        reduced[index] = Reduced::new(&normals[index], false);
    }
    solved(&reduced)
}

/// `f` of each joint and the shared coefficients, which are expected within their `usual` sizes.
fn solved(reduced: &[Option<Reduced>], usual: &[f64]) -> (Vec<Option<f64>>, DVector<f64>) {
    let count = usual.len();
    let mut squares: Vec<f64> = reduced.iter().map(|joint| joint.as_ref().map_or(1.0, |joint| joint.rigid)).collect();
    let (mut found, mut beta) = (vec![None; reduced.len()], DVector::zeros(count));
    for _ in 0..REPETITIONS {
        let mut a = DMatrix::from_fn(count, count, |i, j| if i == j { usual[i].max(1e-9).powi(-2) } else { 0.0 });
        let mut b = DVector::zeros(count);
        for (joint, squares) in reduced.iter().zip(&squares).filter_map(|(joint, u)| Some((joint.as_ref()?, u))) {
            let (weight, of_torque) = (joint.rows / squares, joint.of_torque.rows(0, count));
            let shared = joint.shared.view((0, 0), (count, count)) - of_torque * of_torque.transpose() / joint.torque;
            a += weight * shared;
            b += weight * (of_torque * (joint.by_rigid / joint.torque) - joint.of_shared.rows(0, count));
        }
        let Some(factor) = Equilibrated::new(&a) else { break };
        beta = factor.solve(&b);
        for (index, joint) in reduced.iter().enumerate() {
            let Some(joint) = joint else { continue };
            let f = joint.factor(&beta);
            squares[index] = joint.left(f, &beta).max(joint.least);
            let share = (squares[index] / (f * f * joint.torque)).sqrt();
            found[index] = Some(f).filter(|_| share < DETERMINED && (FURTHEST.recip()..FURTHEST).contains(&f));
        }
    }
    (found, beta)
}

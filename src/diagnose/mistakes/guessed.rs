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
//! A constant is replaced where `f` is above 1, or the residual is a small part of what `y` shows beside friction and no load may be most of `y`; otherwise
//! by what the checks for [mistakes](super) say of its scale. All stages work with the model that this gives, because
//! their fits are linear in the constants, and a load or a tilt has one size on all joints only if the constants of these joints are nearly right.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};

use super::balance::{COLUMNS, Columns, FULL, Normal, bounds};
use super::{Mistake, rows, size, suspected, training_parts};
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
/// [1] Residual, as a share of what the torque shows beside friction, below which a small `f` is right within a tenth: it is too small by the square of
/// this.
const DETERMINED: f64 = 0.3;
/// [1] Error of a small `f` by what may be a load or a tilt, relative to it, above which the guess is as good.
const UNKNOWN: f64 = 1.0;
/// [1] A guess that is off by more is another mistake, such as a unit.
const FURTHEST: f64 = 30.0;
/// Repetitions of the fit, each with the weights of the last.
const REPETITIONS: usize = 8;

/// The model with constants that agree with inertia and weight in the training data, where its own are guesses and the recordings hold currents.
pub fn with_constants<'m>(model: &'m Model, sessions: &[&TimeSeries], division: Division) -> Cow<'m, Model> {
    if model.accuracy.torque_constants < GUESS || model.masses == Masses::Estimated {
        return Cow::Borrowed(model);
    }
    let trained = training_parts(sessions, division);
    let parts: Vec<Cow<TimeSeries>> = trained.iter().flat_map(|session| session.uninterrupted()).collect();
    let parts: Vec<&TimeSeries> = parts.iter().map(AsRef::as_ref).collect();
    if model.joints.is_empty() || parts.is_empty() {
        return Cow::Borrowed(model);
    }
    let mut scaled = model.clone();
    scale_by_balance(&mut scaled, &parts);
    scale_by_mistakes(&mut scaled, &parts);
    restore_far_ones(model, &mut scaled);
    Cow::Owned(scaled)
}

/// Constants from the balance of all joints; where it determines none, from the size of the rigid body's torque.
fn scale_by_balance(model: &mut Model, parts: &[&TimeSeries]) {
    let rows = rows::rows(model, parts);
    let moves = |session: usize, joint: usize, row: usize| rows[session].joints[joint].moves[row];
    let normals = Columns::new(model, &rows).normals(&rows, &moves);
    let bounds = bounds(model);
    let of_size = |joint: usize| size::of_rows(model, joint, &normals[joint], &bounds)?.impossible();
    let of_joint = |(joint, factor): (usize, Option<f64>)| {
        let name = &model.joints[joint].name;
        let factor = factor.or_else(|| of_size(joint).filter(|s| *s > 0.0).map(f64::recip))?;
        has_current(parts, name).then(|| (name.clone(), factor))
    };
    let found: Vec<(String, f64)> = factors(&normals, &bounds).into_iter().enumerate().filter_map(of_joint).collect();
    found.iter().for_each(|(name, factor)| scale(model, name, *factor));
}

/// What the other checks say of a scale is a constant too; each may have to be right before the next one shows.
fn scale_by_mistakes(model: &mut Model, parts: &[&TimeSeries]) {
    for _ in 0..model.joints.len() {
        let found = suspected(model, parts);
        let Some(mistake) = found.iter().find(|mistake| is_of_guess(model, parts, mistake)) else { break };
        mistake.joints.iter().for_each(|name| scale(model, name, mistake.factor.unwrap_or(1.0)));
    }
}

/// Constants that would be off by more than a guess may be stay as the model file gives them: that is another mistake, to be told.
fn restore_far_ones(given: &Model, scaled: &mut Model) {
    for (given, used) in given.joints.iter().zip(&mut scaled.joints) {
        let factor = given.motor.zip(used.motor).map(|(given, used)| used.torque_constant / given.torque_constant);
        if factor.is_some_and(|factor| !is_near(&factor)) {
            used.motor = given.motor;
        }
    }
}

/// Multiplies the torque constant of a joint.
fn scale(model: &mut Model, name: &str, factor: f64) {
    let joint = model.joints.iter_mut().find(|joint| joint.name == name);
    if let Some(motor) = joint.and_then(|joint| joint.motor.as_mut()) {
        motor.torque_constant *= factor;
    }
}

/// Whether these sessions hold currents of a joint, from which a constant makes its torque.
fn has_current(sessions: &[&TimeSeries], name: &str) -> bool {
    let has = |session: &&TimeSeries, channel| session.joint(name).is_some_and(|joint| joint.get(channel).is_some());
    sessions.iter().all(|session| has(session, Channel::Current))
        && !sessions.iter().any(|session| has(session, Channel::Torque))
}

/// Whether a mistake is no more than a guessed torque constant.
pub fn is_of_guess(model: &Model, sessions: &[&TimeSeries], mistake: &Mistake) -> bool {
    model.accuracy.torque_constants >= GUESS
        && mistake.mistake == "torque_scale"
        && mistake.factor.as_ref().is_some_and(is_near)
        && mistake.joints.iter().all(|name| has_current(sessions, name))
}

/// Whether a guess may be off by this factor.
fn is_near(factor: &f64) -> bool {
    (FURTHEST.recip()..FURTHEST).contains(factor)
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
        let solution = Solution::new(reduced, &usual);
        let mass: f64 = solution.beta.iter().skip(TILT).sum();
        let solution = if mass >= 0.0 { solution } else { Solution::new(reduced, &usual[..TILT]) };
        solution.determined(reduced, &usual)
    };
    let mut reduced: Vec<Option<Reduced>> = normals.iter().map(|normal| Reduced::new(normal, true)).collect();
    let found = solved(&reduced);
    // Over a short way the weight is a spring and an offset.
    for index in (0..normals.len()).filter(|index| found[*index].is_none()) {
        reduced[index] = Reduced::new(&normals[index], false);
    }
    solved(&reduced)
}

/// Constants and shared coefficients together.
struct Solution {
    /// `β`
    beta: DVector<f64>,
    /// `f` of each joint.
    f: Vec<f64>,
    /// Sum of squares that each joint leaves.
    squares: Vec<f64>,
}

impl Solution {
    /// Least squares with shared coefficients that are expected within their `usual` sizes, as many as there are of these.
    fn new(reduced: &[Option<Reduced>], usual: &[f64]) -> Self {
        let squares = reduced.iter().map(|joint| joint.as_ref().map_or(1.0, |joint| joint.rigid)).collect();
        let mut solution = Self { beta: DVector::zeros(usual.len()), f: vec![1.0; reduced.len()], squares };
        for _ in 0..REPETITIONS {
            let weight = |joint: usize, u: f64| reduced[joint].as_ref().map_or(0.0, |joint| joint.rows / u);
            let Some(factor) = Equilibrated::new(&solution.information(reduced, usual, &weight)) else { break };
            let mut b = DVector::zeros(usual.len());
            for (joint, u) in reduced.iter().zip(&solution.squares).filter_map(|(joint, u)| Some((joint.as_ref()?, u)))
            {
                let of_torque = joint.of_torque.rows(0, usual.len()) * (joint.by_rigid / joint.torque);
                b += joint.rows / u * (of_torque - joint.of_shared.rows(0, usual.len()));
            }
            solution.beta = factor.solve(&b);
            for (index, joint) in reduced.iter().enumerate() {
                let Some(joint) = joint else { continue };
                let f = joint.factor(&solution.beta);
                solution.f[index] = f;
                solution.squares[index] = joint.left(f, &solution.beta).max(joint.least);
            }
        }
        solution
    }

    /// Precision of the shared coefficients where the constants are free; `weight` of a joint by its number and the squares that it leaves.
    fn information(
        &self,
        reduced: &[Option<Reduced>],
        usual: &[f64],
        weight: &dyn Fn(usize, f64) -> f64,
    ) -> DMatrix<f64> {
        let count = usual.len();
        let mut a = DMatrix::from_fn(count, count, |i, j| if i == j { usual[i].max(1e-9).powi(-2) } else { 0.0 });
        for (index, joint) in reduced.iter().enumerate() {
            let Some(joint) = joint else { continue };
            let of_torque = joint.of_torque.rows(0, count);
            let shared = joint.shared.view((0, 0), (count, count)) - of_torque * of_torque.transpose() / joint.torque;
            a += weight(index, self.squares[index]) * shared;
        }
        a
    }

    /// `f` where it is determined. What a model leaves out is the same in all rows, so a joint says what a single row would: it may look like a
    /// load or a tilt entirely, and what that moves `f` is its error, also where a load was left out.
    fn determined(&self, reduced: &[Option<Reduced>], usual: &[f64]) -> Vec<Option<f64>> {
        let covariance = Equilibrated::new(&self.information(reduced, usual, &|_, u| u.recip()));
        let of_joint = |(index, joint): (usize, &Option<Reduced>)| {
            let (joint, f) = (joint.as_ref()?, self.f[index]);
            let share = (self.squares[index] / (f * f * joint.torque)).sqrt();
            let slope = &joint.of_torque / joint.torque;
            let by_shared = slope.dot(&covariance.as_ref()?.solve(&slope)).max(0.0).sqrt() / f;
            // A load or noise in the torque makes `f` smaller, so a large one is nearer to the truth than the guess; only what bears the weight, such as a
            // balancer, makes it larger.
            let is_known = f > 1.0 || share < DETERMINED && by_shared < UNKNOWN;
            Some(f).filter(|f| is_known && is_near(f))
        };
        reduced.iter().enumerate().map(of_joint).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::effects::drawn::{MODEL, ROBOT};
    use crate::timeseries::JointSeries;

    /// A joint with `I + G = (1, 0)`, `y = (1/f, 0)` and one shared column `S = (p, q)`.
    fn joint([f, p, q]: [f64; 3]) -> Option<Reduced> {
        Some(Reduced {
            torque: f.powi(-2),
            of_torque: DVector::from_element(1, p / f),
            shared: DMatrix::from_element(1, 1, p * p + q * q),
            of_shared: DVector::from_element(1, p),
            rigid: 1.0,
            by_rigid: f.recip(),
            rows: 1000.0,
            least: LEAST * LEAST,
        })
    }

    /// What the shared column moves `f` by, relative to `f`, is `p/√(q²/u + 1/usual²)`, and the joint alone leaves the least `u`. So a load of up to
    /// twice the own torque leaves a small constant unknown, and a large one not, as a load would have made it smaller. A column of another
    /// form, `q`, is seen and does no harm; nor does one that is known to be small.
    #[test]
    fn analytic_a_constant_is_unknown_where_a_load_may_be_most_of_the_torque() {
        let found = |numbers, usual| Solution::new(&[joint(numbers)], &[usual]).determined(&[joint(numbers)], &[usual]);
        assert_eq!(found([0.5, 2.0, 0.0], 1.0), [None]);
        for (numbers, usual) in [([2.0, 2.0, 0.0], 1.0), ([0.5, 2.0, 2.0], 1.0), ([0.5, 2.0, 0.0], 0.4)] {
            let [Some(f)] = *found(numbers, usual) else { panic!("{numbers:?}") };
            // Rounding.
            assert!((f / numbers[0] - 1.0).abs() < 1e-9, "{numbers:?}: {f}");
        }
    }

    /// A scale within a factor of thirty, on a joint with a current, is what a guessed constant may be off by; nothing else is.
    #[test]
    fn property_a_scale_is_of_a_guess_only_where_constants_are_guesses() {
        let model = |accuracy: f64| {
            let text = MODEL.replace("[accuracy]\n", &format!("[accuracy]\ntorque_constants = {accuracy}\n"));
            Model::from_texts(&text, ROBOT, Path::new("model.toml")).expect("a model")
        };
        let guesses = model(1.0);
        let name = guesses.joints[0].name.clone();
        let recorded = |channel| TimeSeries {
            name: "one".to_owned(),
            time: vec![0.0],
            joints: vec![JointSeries { name: name.clone(), channels: [(channel, vec![0.0].into())].into() }],
        };
        let mistake = |mistake, factor| Mistake {
            mistake,
            joints: vec![name.clone()],
            factor: Some(factor),
            evidence: String::new(),
            remedy: String::new(),
            alternatives: Vec::new(),
        };
        let (current, torque) = (recorded(Channel::Current), recorded(Channel::Torque));
        assert!(is_of_guess(&guesses, &[&current], &mistake("torque_scale", 8.0)));
        let scaled = |factor: f64| {
            let mut used = guesses.clone();
            scale(&mut used, &name, factor);
            restore_far_ones(&guesses, &mut used);
            used.joints[0].motor.expect("a motor").torque_constant
                / guesses.joints[0].motor.expect("a motor").torque_constant
        };
        // Two mistakes of a factor of eight are too far together: the constant is that of the file.
        assert_eq!([8.0, 64.0, 1.0 / 64.0].map(scaled), [8.0, 1.0, 1.0]);
        for (model, session, told) in [
            (&model(0.05), &current, mistake("torque_scale", 8.0)),
            (&guesses, &torque, mistake("torque_scale", 8.0)),
            (&guesses, &current, mistake("torque_scale", 100.0)),
            (&guesses, &current, mistake("milliampere_for_ampere", 8.0)),
        ] {
            assert!(!is_of_guess(model, &[session], &told), "{}", told.mistake);
        }
    }
}

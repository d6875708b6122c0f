//! Torque constants that the model guesses, from the torque of inertia and weight.
//!
//! A first model of a URDF states constants with an accuracy of 1: the true one may be several times as large. With `f` the true constant over the guess
//! and `y` the torque that follows from the guess, the [balance](super::balance) of a joint is
//!
//! ```text
//!   y = g z + friction + k q + c + noise      z = I + G + δ₁ G₁ + δ₂ G₂ + Σ μ_k P_k,  g = 1/f,  μ_k ≥ 0
//! ```
//! Tilt `δ` and payload `μ` are the same on all joints, so all are solved at once: a load on a wrist would be taken for a small constant there. The sum of
//! squares of `y` is what is least, with the weight `1/u` of its mean square in each joint. The balance is linear in `f`, too, but least squares of `f y − z`
//! make `f` and the load smaller than they are, by the noise in `y`: beside loads of 5 to 20 % of an arm's mass, constants of all joints came out as 0.5 to
//! 0.9 of what they are. `u` is not taken to be smaller than what a model of usual accuracy leaves. Spring `k` and offset `c` are left out of a joint whose
//! constant they would leave undetermined, as over a short way they are the weight.
//!
//! A constant is replaced where the residual is a small part of `y` and its error by a load or a tilt is smaller than that of the guess; otherwise its guess is
//! taken to be off as those of the nearest joints are, as far as the [size](super::size) of its torque allows, and by what the checks for [mistakes](super) say of its scale. All stages work with the
//! model that this gives and with the accuracy that the constants have then: the deviations of their fits are small, and a load or a tilt has one size on
//! all joints only if the constants of these joints are nearly right.
//! References: W. A. Fuller (1987), Measurement Error Models, ch. 1.1 (attenuation); G. H. Golub, V. Pereyra (1973), SIAM J. Numer. Anal. 10, 413-432
//! (`g` projected out of the step).

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};

use super::balance::{COLUMNS, Columns, FULL, Normal, SIZE_FACTOR, bounds};
use super::{Mistake, rows, size, suspected, training_parts};
use crate::diagnose::rows::division::Division;
use crate::identify::statistics::median;
use crate::linear::Equilibrated;
use crate::robot::{JointModel, Masses, Model};
use crate::timeseries::{Channel, TimeSeries};

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
/// [1] Residual, as a share of what the torque shows beside friction, above which the torque may be anything. On 52 simulated arms `f` was right within a tenth
/// (RMS) where the residual was below this, and up to six times too large above it.
const DETERMINED: f64 = 0.5;
/// [1] Where guesses are off by more in the median of the joints, the unit of the currents may be [another](shows_another_unit). What the balance does not show
/// and another check tells of a single joint is a mistake beyond it, too.
const COMMON: f64 = 30.0;
/// [N·m/A] Least torque constant of a robot's motor: a smaller one turns faster than 3000 rad/s on 6 V, its back EMF in V·s/rad being the same number.
const LEAST_CONSTANT: f64 = 0.002;
/// [1] The guess of a single joint that is off by more is another mistake. It follows from an effort limit, for which robot files may have one number on all
/// joints, and motors of one arm differ by factors of a hundred.
const FURTHEST: f64 = 1000.0;
/// Largest number of steps of the fit, and of halvings of a step.
const STEPS: usize = 50;
/// [1] Fall of the loss with which a fit ends: a thousandth of what one standard deviation is worth.
const ENDED: f64 = 5e-4;

/// The model with constants that agree with inertia and weight in the training data, where its own are guesses and the recordings hold currents.
pub fn with_constants<'m>(model: &'m Model, sessions: &[&TimeSeries], division: Division) -> Cow<'m, Model> {
    if !model.accuracy.guesses_torque_constants() || model.masses == Masses::Estimated {
        return Cow::Borrowed(model);
    }
    let trained = training_parts(sessions, division);
    let parts: Vec<Cow<TimeSeries>> = trained.iter().flat_map(|session| session.uninterrupted()).collect();
    let parts: Vec<&TimeSeries> = parts.iter().map(AsRef::as_ref).collect();
    if model.joints.is_empty() || parts.is_empty() {
        return Cow::Borrowed(model);
    }
    let mut scaled = model.clone();
    let doubtful = scale_by_balance(&mut scaled, &parts);
    scale_by_mistakes(&mut scaled, &parts, doubtful);
    restore_far_ones(model, &mut scaled);
    Cow::Owned(scaled)
}

/// Constants from the balance of all joints; where it determines none, from those of the nearest joints, as near to them as the size of the rigid body's torque
/// allows. Returns the names of joints whose constant the balance tells no better than the guess, each with the factor that it would ask for.
fn scale_by_balance(model: &mut Model, parts: &[&TimeSeries]) -> Vec<(String, f64)> {
    let rows = rows::rows(model, parts);
    let moves = |session: usize, joint: usize, row: usize| rows[session].joints[joint].moves[row];
    let normals = Columns::new(model, &rows).normals(&rows, &moves);
    let bounds = bounds(model);
    let stated = model.accuracy;
    let found = factors(&normals, &bounds, stated.torque_constants);
    let with_current: Vec<bool> = model.joints.iter().map(|joint| has_current(parts, &joint.name)).collect();
    let is_known = |joint: usize, found: &Factor| with_current[joint] && found.error < stated.torque_constants;
    let known: Vec<Option<Factor>> =
        found.iter().enumerate().map(|(joint, found)| found.filter(|found| is_known(joint, found))).collect();
    let mut doubtful = Vec::new();
    for index in (0..known.len()).filter(|joint| with_current[*joint]) {
        let name = model.joints[index].name.clone();
        if let Some(Factor { f, error }) = known[index] {
            scale(model, &name, f);
            // The masses, too, are only as accurate as the model says, and the constant was measured by their weight.
            model.joints[index].constant_accuracy = Some(error.hypot(stated.masses).min(stated.torque_constants));
            continue;
        }
        let neighbours = factor_of_nearest(&known, index);
        let size = size::of_rows(model, index, &normals[index], &bounds);
        let used = size.map_or(neighbours, |size| size.possible_factor(neighbours));
        scale(model, &name, used);
        doubtful.extend(found[index].map(|found| (name, found.f / used)));
    }
    doubtful
}

/// `f` of the nearest joints along the arm whose constant is known, their geometric mean where there are two; one where none is. Neighbours have motors of
/// about one size, and effort limits that are all too large are so together.
fn factor_of_nearest(known: &[Option<Factor>], joint: usize) -> f64 {
    let at = |distance: usize| {
        let places = [joint.checked_sub(distance), joint.checked_add(distance)].into_iter().flatten();
        places.filter_map(|place| Some((*known.get(place)?)?.f.ln())).collect::<Vec<_>>()
    };
    let nearest = (1..known.len()).map(at).find(|logarithms| !logarithms.is_empty()).unwrap_or_default();
    (nearest.iter().sum::<f64>() / nearest.len().max(1) as f64).exp()
}

/// What the other checks say of a scale is a constant too; each may have to be right before the next one shows. Where they take the torque of a joint for one
/// that was recorded in place of its current, it is a `doubtful` constant that was nearer than the guess.
fn scale_by_mistakes(model: &mut Model, parts: &[&TimeSeries], mut doubtful: Vec<(String, f64)>) {
    for _ in 0..model.joints.len() {
        let found = suspected(model, parts);
        let of_guess = found.iter().filter(|mistake| is_of_guess(model, parts, mistake));
        if let Some((mistake, factor)) = of_guess.filter_map(|one| Some((one, scale_of_guess(one)?))).next() {
            mistake.joints.iter().for_each(|name| scale(model, name, factor));
            continue;
        }
        let as_current = found.iter().filter(|mistake| mistake.mistake == "torque_recorded_as_current");
        let names: Vec<&String> = as_current.flat_map(|mistake| &mistake.joints).collect();
        let Some(place) = doubtful.iter().position(|(name, _)| names.contains(&name)) else { break };
        let (name, factor) = doubtful.swap_remove(place);
        scale(model, &name, factor);
    }
}

/// Constants that would be off by more than a guess may be stay as the model file gives them: that is another mistake, to be told.
fn restore_far_ones(given: &Model, scaled: &mut Model) {
    let factor =
        |given: &JointModel, used: &JointModel| Some(used.motor?.torque_constant / given.motor?.torque_constant);
    let joints = || given.joints.iter().zip(&scaled.joints);
    let logarithms: Vec<f64> = joints().filter_map(|(given, used)| Some(factor(given, used)?.ln())).collect();
    let is_usual = is_within(COMMON, median(logarithms).exp()) || !shows_another_unit(scaled);
    let furthest = if is_usual { FURTHEST } else { 1.0 };
    for (given, used) in given.joints.iter().zip(&mut scaled.joints) {
        if factor(given, used).is_some_and(|factor| !is_within(furthest, factor)) {
            (used.motor, used.constant_accuracy) = (given.motor, given.constant_accuracy);
        }
    }
}

/// Whether the constants that were found are of currents in a smaller unit, or of torques in their place, of which one unit is one newton metre. Otherwise
/// guesses that are all far off follow from effort limits that nobody set.
fn shows_another_unit(scaled: &Model) -> bool {
    let of_joint = |joint: &JointModel| Some([joint.motor?.torque_constant, joint.torque_per_ampere()]);
    let found = scaled.joints.iter().filter(|joint| joint.constant_accuracy.is_some());
    let found: Vec<[f64; 2]> = found.filter_map(of_joint).collect();
    let are_one = |side: usize| found.iter().all(|constants| is_within(SIZE_FACTOR, constants[side]));
    are_one(0) || are_one(1) || median(found.iter().map(|[of_motor, _]| *of_motor).collect()) < LEAST_CONSTANT
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

/// Whether a mistake is no more than a guessed torque constant: its scale, or a torque in place of its current that these data do not distinguish from
/// another scale, as its constant would only be another one.
pub fn is_of_guess(model: &Model, sessions: &[&TimeSeries], mistake: &Mistake) -> bool {
    let as_current = mistake.mistake == "torque_recorded_as_current" && mistake.alternatives.contains(&"torque_scale");
    let is_scale = as_current || scale_of_guess(mistake).is_some();
    let of_joint = |name: &String| has_current(sessions, name);
    is_scale && model.accuracy.guesses_torque_constants() && mistake.joints.iter().all(of_joint)
}

/// The factor on a constant that a mistake asks for, if it is a scale that a guess may be off by.
fn scale_of_guess(mistake: &Mistake) -> Option<f64> {
    mistake.factor.filter(|factor| mistake.mistake == "torque_scale" && is_within(COMMON, *factor))
}

/// Whether something is off by this factor at most.
fn is_within(most: f64, factor: f64) -> bool {
    (most.recip()..most).contains(&factor)
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

    /// What the joint shows where the shared coefficients have these values.
    fn at(&self, beta: &DVector<f64>) -> Shown {
        let across = &self.of_shared + &self.shared * beta;
        let power = (self.rigid + beta.dot(&self.of_shared) + beta.dot(&across)).max(f64::MIN_POSITIVE);
        let by_torque = self.by_rigid + beta.dot(&self.of_torque);
        let g = by_torque / power;
        let left = (self.torque - g * by_torque).max(g * g * self.least).max(f64::MIN_POSITIVE);
        Shown { g, across, power, left }
    }
}

/// What a joint shows of a constant beside a load and a tilt.
struct Shown {
    /// `g = zᵀy/zᵀz`
    g: f64,
    /// `Sᵀz`
    across: DVector<f64>,
    /// `zᵀz`
    power: f64,
    /// Sum of squares of `y − g z`.
    left: f64,
}

/// True constant over the guess, and its error.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Factor {
    /// `f`
    f: f64,
    /// [1] One standard deviation, relative to `f`.
    error: f64,
}

/// `f` of each joint where a residual does not hide it. A spring and an offset count where it is determined better than by a guess of the accuracy `stated`
/// nevertheless. `limits`: bounds of the balance's coefficients.
fn factors(normals: &[Normal], limits: &[[f64; 2]; COLUMNS], stated: f64) -> Vec<Option<Factor>> {
    let usual: Vec<f64> = limits[SHARED].iter().map(|[_, high]| *high).collect();
    let solved = |reduced: &[Option<Reduced>]| Load::new(reduced, &usual).factors(reduced);
    let mut reduced: Vec<Option<Reduced>> = normals.iter().map(|normal| Reduced::new(normal, true)).collect();
    let found = solved(&reduced);
    let is_open = |index: &usize| found[*index].is_none_or(|found| found.error >= stated);
    // Over a short way the weight is a spring and an offset.
    for index in (0..normals.len()).filter(is_open) {
        reduced[index] = Reduced::new(&normals[index], false);
    }
    solved(&reduced)
}

/// Tilt and payload.
struct Load {
    /// `β = (δ, μ)`
    beta: DVector<f64>,
    /// Inverse squares of their usual sizes.
    prior: DVector<f64>,
}

impl Load {
    /// Least squares of all joints: steps of Gauss and Newton, each no longer than the loss falls.
    fn new(reduced: &[Option<Reduced>], usual: &[f64]) -> Self {
        let prior = DVector::from_iterator(usual.len(), usual.iter().map(|usual| usual.max(1e-9).powi(-2)));
        let mut load = Self { beta: DVector::zeros(usual.len()), prior };
        for _ in 0..STEPS {
            let loss = load.loss(reduced);
            let Some(step) = load.step(reduced) else { break };
            let tried = |halvings: usize| {
                let moved = &load.beta + &step * 0.5_f64.powi(halvings as i32);
                let beta = DVector::from_fn(moved.len(), |k, _| if k < TILT { moved[k] } else { moved[k].max(0.0) });
                Self { beta, prior: load.prior.clone() }
            };
            let Some(better) = (0..STEPS).map(tried).find(|tried| tried.loss(reduced) < loss - ENDED) else { break };
            load = better;
        }
        load
    }

    /// `−ln` of the likelihood and the prior, up to a constant.
    fn loss(&self, reduced: &[Option<Reduced>]) -> f64 {
        let of_joint = |joint: &Reduced| 0.5 * joint.rows * joint.at(&self.beta).left.ln();
        let of_prior = 0.5 * self.prior.dot(&self.beta.component_mul(&self.beta));
        reduced.iter().flatten().map(of_joint).sum::<f64>() + of_prior
    }

    /// The change that the linear equations ask for. A mass at zero that would become negative stays.
    fn step(&self, reduced: &[Option<Reduced>]) -> Option<DVector<f64>> {
        let mut b = -self.prior.component_mul(&self.beta);
        for joint in reduced.iter().flatten() {
            let Shown { g, across, left, .. } = joint.at(&self.beta);
            b += joint.rows / left * g * (&joint.of_torque - g * across);
        }
        let is_free = |k: &usize| *k < TILT || self.beta[*k] > 0.0 || b[*k] > 0.0;
        let free: Vec<usize> = (0..b.len()).filter(is_free).collect();
        let information = self.information(reduced, &|joint| joint.rows);
        let factor = Equilibrated::new(&information.select_rows(&free).select_columns(&free))?;
        let mut step = DVector::zeros(b.len());
        free.iter().zip(&factor.solve(&b.select_rows(&free))).for_each(|(k, change)| step[*k] = *change);
        Some(step)
    }

    /// Precision of `β` where the constants are free; `rows`: independent ones of a joint.
    fn information(&self, reduced: &[Option<Reduced>], rows: &dyn Fn(&Reduced) -> f64) -> DMatrix<f64> {
        let mut a = DMatrix::from_diagonal(&self.prior);
        for joint in reduced.iter().flatten() {
            let Shown { g, across, power, left } = joint.at(&self.beta);
            a += rows(joint) / left * g * g * (&joint.shared - &across * across.transpose() / power);
        }
        a
    }

    /// `f` where a residual does not hide it. What a model leaves out is the same in all rows, so a joint says what a single row would: it may look like a
    /// load or a tilt entirely, and what that moves `f` by is its error.
    fn factors(&self, reduced: &[Option<Reduced>]) -> Vec<Option<Factor>> {
        let covariance = Equilibrated::new(&self.information(reduced, &|_| 1.0));
        let of_joint = |joint: &Option<Reduced>| {
            let joint = joint.as_ref()?;
            let Shown { g, across, power, left } = joint.at(&self.beta);
            let slope = across / power;
            let error = slope.dot(&covariance.as_ref()?.solve(&slope)).max(0.0).sqrt();
            let is_known = (left / joint.torque).sqrt() < DETERMINED;
            Some(Factor { f: g.recip(), error }).filter(|found| is_known && is_within(FURTHEST, found.f))
        };
        reduced.iter().map(of_joint).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::effects::drawn::{MODEL, ROBOT};
    use crate::timeseries::JointSeries;

    /// A joint with `I + G = (1, 0)`, one shared column `S = (p, q)`, and `y = (I + G + β S)/f` with noise of a mean square `u` across both. Columns before
    /// the last are those of a tilt that does not show.
    fn joint(f: f64, [p, q]: [f64; 2], [beta, u]: [f64; 2], columns: usize) -> Option<Reduced> {
        let last = |value: f64| DVector::from_fn(columns, |k, _| if k + 1 == columns { value } else { 0.0 });
        let [z, s] = [[1.0 + beta * p, beta * q], [p, q]];
        Some(Reduced {
            torque: (z[0] * z[0] + z[1] * z[1]) / (f * f) + u,
            of_torque: last((z[0] * s[0] + z[1] * s[1]) / f),
            shared: DMatrix::from_diagonal(&last(p * p + q * q)),
            of_shared: last(p),
            rigid: 1.0,
            by_rigid: z[0] / f,
            rows: 1e6,
            least: LEAST * LEAST,
        })
    }

    /// What the shared column moves `f` by, relative to `f`, is `p/√(q²/u + 1/usual²)`, and the joint alone leaves the least `u`. So a load of up to
    /// twice the own torque leaves a constant less known than a guess. A column of another form, `q`, is seen and does no harm; nor does one that is known to
    /// be small.
    #[test]
    fn analytic_a_constant_is_unknown_where_a_load_may_be_most_of_the_torque() {
        let found = |form, usual| {
            let joints = [joint(0.5, form, [0.0, 0.0], 1)];
            Load::new(&joints, &[usual]).factors(&joints)
        };
        for (form, usual) in [([2.0, 0.0], 1.0), ([2.0, 2.0], 1.0), ([2.0, 0.0], 0.4)] {
            let [Some(Factor { f, error })] = *found(form, usual) else { panic!("{form:?}") };
            let [p, q] = form;
            let expected = p / ((q / LEAST).powi(2) + 1.0 / (usual * usual)).sqrt();
            // Rounding.
            assert!((f / 0.5 - 1.0).abs() < 1e-9 && (error / expected - 1.0).abs() < 1e-9, "{form:?}: {f} ± {error}");
        }
    }

    /// A load that looks like the own weight, all but a tenth, in a torque with noise of 10 %: constant and load are found. Least squares of `f y − z` lose
    /// most of the load, `1/(1 + u/v)` with `v` what of `y` is not like the load. A mass is not negative: torque that is lacking is one of the
    /// constant.
    #[test]
    fn recover_a_constant_beside_a_load_in_noise() {
        let form = [0.9, 0.1];
        for (f, mass) in [(0.5, 0.5), (3.0, 0.2), (2.0, -0.2)] {
            let y = (1.0 + mass * form[0]) / f;
            let joints = [joint(f, form, [mass, 0.01 * y * y], TILT + 1)];
            let load = Load::new(&joints, &[0.3, 0.3, 1.0]);
            let [Some(found)] = *load.factors(&joints) else { panic!("{f}") };
            if mass > 0.0 {
                // What the prior of the load takes of a million rows.
                assert!((load.beta[TILT] / mass - 1.0).abs() < 0.01, "{} {mass}", load.beta[TILT]);
                assert!((found.f / f - 1.0).abs() < 0.01, "{found:?}");
            } else {
                assert_eq!(load.beta[TILT], 0.0);
                // `y` for a mass of zero.
                assert!((found.f * y - 1.0).abs() < 1e-9, "{found:?}");
            }
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
        let as_current =
            |alternatives: Vec<&'static str>| Mistake { alternatives, ..mistake("torque_recorded_as_current", 50.0) };
        assert!(is_of_guess(&guesses, &[&current], &as_current(vec!["torque_scale"])));
        assert!(is_of_guess(&guesses, &[&current], &mistake("torque_scale", 8.0)));
        // The first of so many joints is off.
        let scaled = |joints: usize, factor: f64| {
            let mut given = guesses.clone();
            given.joints = vec![given.joints[0].clone(); joints];
            let mut used = given.clone();
            scale(&mut used, &name, factor);
            restore_far_ones(&given, &mut used);
            let [used, given] = [used, given].map(|model| model.joints[0].motor.expect("a motor").torque_constant);
            used / given
        };
        // Alone, it may have currents in another unit; one of three has a motor of its own kind.
        assert_eq!([8.0, 64.0, 1.0 / 64.0].map(|factor| scaled(1, factor)), [8.0, 1.0, 1.0]);
        assert_eq!([8.0, 512.0, 1.0 / 512.0, 1024.0].map(|factor| scaled(3, factor)), [8.0, 512.0, 1.0 / 512.0, 1.0]);
        for (model, session, told) in [
            (&model(0.05), &current, mistake("torque_scale", 8.0)),
            (&guesses, &torque, mistake("torque_scale", 8.0)),
            (&guesses, &current, mistake("torque_scale", 100.0)),
            (&guesses, &current, mistake("milliampere_for_ampere", 8.0)),
            (&guesses, &current, as_current(Vec::new())),
            (&model(0.05), &current, as_current(vec!["torque_scale"])),
        ] {
            assert!(!is_of_guess(model, &[session], &told), "{}", told.mistake);
        }
    }

    /// Guesses that are a hundred times too large: what was found is used where it is that of motors, and not where it is that of another unit.
    #[test]
    fn property_guesses_that_are_all_far_off_are_replaced_unless_the_unit_is_another() {
        let is_used = |constants: [f64; 3]| {
            let mut used = Model::from_texts(MODEL, ROBOT, Path::new("model.toml")).expect("a model");
            used.joints = vec![used.joints[0].clone(); constants.len()];
            let mut given = used.clone();
            for (place, constant) in constants.into_iter().enumerate() {
                let [found, guess] = [&mut used, &mut given].map(|model| &mut model.joints[place]);
                found.motor.as_mut().expect("a motor").torque_constant = constant;
                found.constant_accuracy = Some(0.1);
                guess.motor.as_mut().expect("a motor").torque_constant = 100.0 * constant;
            }
            let found = used.clone();
            restore_far_ones(&given, &mut used);
            used.joints == found.joints
        };
        // Joints have a ratio of 45: `1/45` is a joint's torque, one a motor's. Thousandths are currents in mA.
        assert!(is_used([0.04, 0.01, 0.07]));
        assert!(!is_used([0.02, 0.03, 0.025]) && !is_used([0.7, 1.1, 1.3]) && !is_used([4e-5, 1e-5, 3e-3]));
    }

    /// The nearest joints along the arm that are known, whichever side they are on.
    #[test]
    fn property_a_constant_that_nothing_shows_is_off_as_those_of_its_neighbours() {
        let known = |f: f64| Some(Factor { f, error: 0.1 });
        let arm = [known(0.5), None, known(0.02), None, None, None];
        let found: Vec<f64> = (0..arm.len()).map(|joint| factor_of_nearest(&arm, joint)).collect();
        // The mean of both of the second joint is that of the logarithms. Rounding.
        for (found, expected) in found.iter().zip([0.02, 0.1, 0.5, 0.02, 0.02, 0.02]) {
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
        assert_eq!(factor_of_nearest(&[None, None], 1), 1.0);
    }
}

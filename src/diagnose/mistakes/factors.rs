//! What the true torque constants are over their guesses, from the balance of all joints.
//!
//! With `f` the true constant over the guess and `y` the torque that follows from the guess, the [balance](super::balance) of a joint is
//!
//! ```text
//!   y = g z + friction + k q + c + noise      z = I + G + δ₁ G₁ + δ₂ G₂ + Σ μ_k P_k,  g = 1/f,  μ_k ≥ 0
//! ```
//! Tilt `δ` and payload `μ` are the same on all joints, so all are solved at once: a load on a wrist would be taken for a small constant there. The sum of
//! squares of `y` is what is least, with the weight `1/u` of its mean square in each joint. The balance is linear in `f`, too, but least squares of `f y − z`
//! make `f` and the load smaller than they are, by the noise in `y`: beside loads of 5 to 20 % of an arm's mass, constants of all joints came out as 0.5 to
//! 0.9 of what they are. `u` is not taken to be smaller than what a model of usual accuracy leaves. Spring `k` and offset `c` are left out of a joint whose
//! constant they would leave undetermined, as over a short way they are the weight.
//! References: W. A. Fuller (1987), Measurement Error Models, ch. 1.1 (attenuation); G. H. Golub, V. Pereyra (1973), SIAM J. Numer. Anal. 10, 413-432
//! (`g` projected out of the step).

use nalgebra::{DMatrix, DVector};

use super::balance::{COLUMNS, FULL, Normal};
use crate::linear::Equilibrated;

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
/// Largest number of steps of the fit, and of halvings of a step.
const STEPS: usize = 50;
/// [1] Fall of the loss with which a fit ends: a thousandth of what one standard deviation is worth.
const ENDED: f64 = 5e-4;
/// [1] The guess of a single joint that is off by more is another mistake. It follows from an effort limit, for which robot files may have one number on all
/// joints, and motors of one arm differ by factors of a hundred.
pub const FURTHEST: f64 = 1000.0;

/// Whether something is off by this factor at most.
pub fn is_within(most: f64, factor: f64) -> bool {
    (most.recip()..most).contains(&factor)
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
pub struct Factor {
    /// `f`
    pub f: f64,
    /// [1] One standard deviation, relative to `f`.
    pub error: f64,
}

/// `f` of each joint where a residual does not hide it. A spring and an offset count where it is determined better than by a guess of the accuracy `stated`
/// nevertheless. `limits`: bounds of the balance's coefficients.
pub fn factors(normals: &[Normal], limits: &[[f64; 2]; COLUMNS], stated: f64) -> Vec<Option<Factor>> {
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
    use super::*;

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
}

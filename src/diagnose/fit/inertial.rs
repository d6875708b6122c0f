//! Errors of the nominal inertias and scales, within the accuracy that the model states for them.
//!
//! `τ = Y(q, q̇, q̈) (π̄ + D u) + J_r (1 + s_J u) a − s_K u τ_rigid + …`, every `u ~ N(0, 1)`. `Y` is the regressor of the bodies' ten parameters `π`
//! and `D` their change by one standard deviation of each nominal value ([`Accuracy`]); `J_r` the rotor on the joint side. A torque constant
//! larger by `s_K u` makes the torque computed from a current too small.
//! What the motion shows of `u` are the directions `z = Vᵀ u` with the largest torque: `V` are eigenvectors of the Gram matrix of the
//! torques, each divided by the RMS torque of its joint. Their prior is `N(0, 1)` again; all other directions are left out.
//!
//! A fit of all joints has the columns of all directions. A fit of one joint sees what its own rows can still decide: the rows of the other
//! joints say `z ~ N(m, C Cᵀ)`, `(C Cᵀ)⁻¹ = 1 + Σ Q_i`, `m = C Cᵀ Σ b_i`, with `Q_i` and `b_i` the information of joint `i` after its own baseline, and
//! `z = m + C U y`, `y ~ N(0, 1)`. Rows are correlated: each joint counts with its number of independent samples.
//! References: M. Gautier (1997), Dynamic identification of robots with power model; G. A. F. Seber, A. J. Lee (2003), Linear Regression
//! Analysis, ch. 12 (priors as ridges).

use nalgebra::{DMatrix, DVector};

use super::problem::{Fitted, Part, Problem, Term};
use super::regression::Block;
use crate::diagnose::rows::observe::root_mean_square;
use crate::effects::Motion;
use crate::linear::Equilibrated;
use crate::robot::{Accuracy, Model};

/// [1] Torque of one standard deviation, as a share of the RMS torque, below which a direction is left out: no friction law is as accurate.
const LEAST_TORQUE: f64 = 1e-3;
/// Number of rows from which the directions are computed.
const ROWS: usize = 2000;
/// [1] Information of a joint's own rows, relative to what is known without them, below which a direction stays where it is.
const LEAST_INFORMATION: f64 = 0.01;
/// Parameters of a body.
pub const NUMBERS: usize = 10;

/// Unknown deviations of the nominal model, and what is known of them.
#[derive(Debug, Clone)]
pub struct Inertial {
    /// `V`: one row per nominal value (ten a body, then rotors, then torque constants), one column per direction.
    directions: DMatrix<f64>,
    /// `columns[joint][direction][row]` [N·m or N]: torque of one standard deviation.
    columns: Vec<Vec<Vec<f64>>>,
    /// What each joint can still decide; `None` before the first fit.
    views: Vec<Option<View>>,
    /// The deviations of the last fit that was held.
    last: Option<Deviations>,
    /// Whether they are no longer fitted.
    fixed: bool,
    /// Factor of the standard deviations of each body, above 1 where its stated accuracy does not hold.
    widened: Vec<f64>,
}

/// A body whose deviation is improbable at its stated accuracy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surprise {
    /// Index of the body.
    pub body: usize,
    /// [nats] By how much a wider accuracy is likelier: `½ (|u|² − r) − ½ r ln(|u|²/r)`.
    pub nats: f64,
    /// `√(|u|²/r)` The likeliest factor of its standard deviations.
    pub factor: f64,
}

/// Deviations `z` and their torque.
#[derive(Debug, Clone)]
struct Deviations {
    z: DVector<f64>,
    /// `torque[joint][row]`
    torque: Vec<Vec<f64>>,
}

/// The deviations as the rows of one joint see them: `z = offset + basis · y`.
#[derive(Debug, Clone)]
struct View {
    offset: DVector<f64>,
    basis: DMatrix<f64>,
    /// Torque of the offset.
    shift: Vec<f64>,
    /// Torque of each `y`.
    columns: Vec<Vec<f64>>,
}

/// How a fit treats the deviations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Treated {
    /// There are none, or they are held at their estimate.
    Fixed,
    /// Fitted over all joints, `count` coefficients from `at`.
    Shared {
        /// First coefficient.
        at: usize,
        /// Number of coefficients.
        count: usize,
    },
    /// Fitted to one joint, beside what the others say.
    Seen {
        /// The joint.
        joint: usize,
        /// First coefficient.
        at: usize,
        /// Number of coefficients.
        count: usize,
    },
}

impl Treated {
    /// Coefficients of the deviations in a fit.
    pub fn range(self) -> std::ops::Range<usize> {
        match self {
            Self::Fixed => 0..0,
            Self::Shared { at, count } | Self::Seen { at, count, .. } => at..at + count,
        }
    }
}

impl Inertial {
    /// The directions that a motion shows; `None` where the stated accuracy leaves nothing that it shows.
    ///
    /// `widened` are factors of the standard deviations of each body.
    pub fn new(motion: &Motion, widened: Vec<f64>) -> Option<Self> {
        let accuracy = motion.model.accuracy;
        let mut deviations = accuracy.inertial_deviations(&motion.model.robot);
        for (body, factor) in widened.iter().enumerate() {
            deviations.columns_mut(NUMBERS * body, NUMBERS).scale_mut(*factor);
        }
        let rows: Vec<usize> = (0..motion.rows()).step_by(motion.rows().div_ceil(ROWS).max(1)).collect();
        let few = motion.at_rows(&rows);
        let unit = DMatrix::identity(
            deviations.ncols() + 2 * motion.joints.len(),
            deviations.ncols() + 2 * motion.joints.len(),
        );
        let torques = torques(&few, &accuracy, &deviations, &unit);
        let mut gram = DMatrix::zeros(unit.nrows(), unit.nrows());
        for (joint, torques) in torques.iter().enumerate() {
            let size = root_mean_square(&few.joints[joint].torque).max(1e-300) * (rows.len().max(1) as f64).sqrt();
            let shown: Vec<usize> = (0..torques.len()).filter(|k| torques[*k].iter().any(|x| *x != 0.0)).collect();
            for a in &shown {
                for b in shown.iter().take_while(|b| *b <= a) {
                    let sum: f64 =
                        torques[*a].iter().zip(&torques[*b]).map(|(x, y)| x * y).sum::<f64>() / (size * size);
                    gram[(*a, *b)] += sum;
                    if a != b {
                        gram[(*b, *a)] += sum;
                    }
                }
            }
        }
        let eigen = gram.symmetric_eigen();
        let shown: Vec<usize> =
            (0..eigen.eigenvalues.len()).filter(|k| eigen.eigenvalues[*k] > LEAST_TORQUE * LEAST_TORQUE).collect();
        if shown.is_empty() {
            return None;
        }
        let directions = eigen.eigenvectors.select_columns(&shown);
        let columns = self::torques(motion, &accuracy, &deviations, &directions);
        Some(Self { directions, columns, views: vec![None; motion.joints.len()], last: None, fixed: false, widened })
    }

    /// Number of directions.
    pub fn count(&self) -> usize {
        self.directions.ncols()
    }

    /// `u`: deviations of the nominal values, in standard deviations, widened where they were.
    fn values(&self, z: &DVector<f64>) -> DVector<f64> {
        &self.directions * z
    }

    /// The body with the most surprising deviation. Of its ten values the motion shows `r = Σ V²`, and `|u|²` is expected to be `r`.
    fn surprise(&self, z: &DVector<f64>) -> Option<Surprise> {
        let u = self.values(z);
        let of_body = |body: usize| {
            let own = NUMBERS * body..NUMBERS * (body + 1);
            let size: f64 = own.clone().map(|k| u[k] * u[k]).sum();
            let shown: f64 = own.map(|k| self.directions.row(k).norm_squared()).sum();
            let ratio = size / shown.max(1e-12);
            let nats = 0.5 * (size - shown) - 0.5 * shown * ratio.max(1e-12).ln();
            (ratio > 1.0 && shown > 0.0 && self.widened[body] == 1.0).then_some(Surprise {
                body,
                nats,
                factor: ratio.sqrt(),
            })
        };
        (0..self.widened.len()).filter_map(of_body).max_by(|a, b| a.nats.total_cmp(&b.nats))
    }

    /// Bodies whose stated accuracy does not hold.
    fn surprising(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.widened.len()).filter(|body| self.widened[*body] > 1.0)
    }

    fn held(&self) -> Option<&Deviations> {
        self.last.as_ref().filter(|_| self.fixed)
    }

    fn torque_of(&self, joint: usize, z: &DVector<f64>) -> Vec<f64> {
        combined(&self.columns[joint], z)
    }

    /// `z` of a fit; for the fit of one joint, what its rows and those of the other joints say together.
    fn estimate(&self, fitted: &Fitted) -> DVector<f64> {
        let own =
            |treated: Treated| DVector::from_column_slice(&fitted.solution.coefficients.as_slice()[treated.range()]);
        match (fitted.inertial, self.held()) {
            (Treated::Fixed, Some(held)) => held.z.clone(),
            (Treated::Fixed, None) => DVector::zeros(self.count()),
            (treated @ Treated::Shared { .. }, _) => own(treated),
            (treated @ Treated::Seen { joint, .. }, _) => match &self.views[joint] {
                Some(view) => &view.offset + &view.basis * own(treated),
                None => own(treated),
            },
        }
    }

    fn seen(&self, joint: usize) -> (&[Vec<f64>], Option<&[f64]>) {
        match &self.views[joint] {
            Some(view) => (&view.columns, Some(&view.shift)),
            None => (&self.columns[joint], None),
        }
    }
}

/// `Σ c_k column_k`.
fn combined<'c>(columns: &[Vec<f64>], coefficients: impl IntoIterator<Item = &'c f64>) -> Vec<f64> {
    let mut sum = vec![0.0; columns.first().map_or(0, Vec::len)];
    for (column, c) in columns.iter().zip(coefficients) {
        sum.iter_mut().zip(column).for_each(|(sum, x)| *sum += c * x);
    }
    sum
}

/// Torque of each direction on each joint.
fn torques(
    motion: &Motion,
    accuracy: &Accuracy,
    deviations: &DMatrix<f64>,
    directions: &DMatrix<f64>,
) -> Vec<Vec<Vec<f64>>> {
    let (of_bodies, dof) = (deviations.ncols(), motion.joints.len());
    let mut torques = motion.regressed(&(deviations * directions.rows(0, of_bodies)));
    for (joint, torques) in torques.iter_mut().enumerate() {
        let m = &motion.joints[joint];
        let rotor = accuracy.rotor_inertias * motion.model.joints[joint].reflected_inertia();
        let scale = if m.has_current { -accuracy.torque_constants } else { 0.0 };
        for (torque, direction) in torques.iter_mut().zip(directions.column_iter()) {
            let (rotor, scale) = (rotor * direction[of_bodies + joint], scale * direction[of_bodies + dof + joint]);
            if rotor != 0.0 || scale != 0.0 {
                torque.iter_mut().enumerate().for_each(|(row, x)| *x += rotor * m.a[row] + scale * m.rigid[row]);
            }
        }
    }
    torques
}

impl Problem<'_> {
    /// From now on the nominal model may deviate within its stated accuracy.
    pub fn deviate(&mut self) {
        self.inertial = Inertial::new(&self.motion, vec![1.0; self.baseline.len()]);
    }

    /// The joints that a fit of some joints has to include: all, where deviations of the model couple several.
    pub fn within(&self, joints: Vec<usize>) -> Vec<usize> {
        let free = self.inertial.as_ref().is_some_and(|inertial| inertial.held().is_none());
        if free && joints.len() > 1 { self.joints() } else { joints }
    }

    /// How a fit of these joints treats the deviations, with the first coefficient that is free.
    pub fn treated(&self, joints: &[usize], at: usize) -> Treated {
        match (self.inertial.as_ref().filter(|inertial| !inertial.fixed), joints) {
            (None, _) => Treated::Fixed,
            (Some(inertial), [joint]) => Treated::Seen { joint: *joint, at, count: inertial.seen(*joint).0.len() },
            (Some(inertial), _) => Treated::Shared { at, count: inertial.count() },
        }
    }

    /// Columns of the deviations for a joint, and the torque that is known of them.
    pub fn deviations(&self, joint: usize, treated: Treated) -> (&[Vec<f64>], Option<&[f64]>) {
        let Some(inertial) = &self.inertial else { return (&[], None) };
        match (treated, inertial.held()) {
            (Treated::Fixed, Some(held)) => (&[], Some(&held.torque[joint])),
            (Treated::Fixed, None) => (&[], None),
            (Treated::Shared { .. }, _) => (&inertial.columns[joint], None),
            (Treated::Seen { .. }, _) => inertial.seen(joint),
        }
    }

    /// Torque of the deviations of a fit on a joint in all rows; `None` where there are none.
    pub fn deviating_torque(&self, fitted: &Fitted, joint: usize) -> Option<Vec<f64>> {
        let inertial = self.inertial.as_ref()?;
        match (fitted.inertial, inertial.held()) {
            (Treated::Fixed, Some(held)) => Some(held.torque[joint].clone()),
            (Treated::Fixed, None) => None,
            _ => Some(inertial.torque_of(joint, &inertial.estimate(fitted))),
        }
    }

    /// From now on the deviations have the values of this fit.
    pub fn hold(&mut self, fitted: &Fitted) {
        if let Some(inertial) = &mut self.inertial {
            let z = inertial.estimate(fitted);
            let torque = (0..inertial.columns.len()).map(|joint| inertial.torque_of(joint, &z)).collect();
            (inertial.last, inertial.fixed) = (Some(Deviations { z, torque }), true);
        }
    }

    /// From now on the deviations are fitted.
    pub fn free(&mut self) {
        if let Some(inertial) = &mut self.inertial {
            inertial.fixed = false;
        }
    }

    /// From now on the deviations have the values that were held before.
    pub fn hold_again(&mut self) {
        if let Some(inertial) = &mut self.inertial {
            inertial.fixed = inertial.last.is_some();
        }
    }

    /// The nominal model with the deviations that are held, except those of bodies whose stated accuracy does not hold; and the true torque of
    /// each joint relative to that of the nominal model.
    pub fn deviating_model(&self) -> (Model, Vec<f64>) {
        let (model, dof) = (self.motion.model, self.baseline.len());
        let held = self.inertial.as_ref().and_then(|inertial| Some((inertial, inertial.values(&inertial.held()?.z))));
        let Some((inertial, mut u)) = held else { return (model.clone(), vec![1.0; dof]) };
        inertial.surprising().for_each(|body| u.rows_mut(NUMBERS * body, NUMBERS).fill(0.0));
        let factor = |joint: usize| model.accuracy.torque_factor(u[u.len() - dof + joint]);
        (model.deviating(u.as_slice()), (0..dof).map(factor).collect())
    }

    /// The body with the most surprising deviation in a fit of all joints.
    pub fn surprise(&self, fitted: &Fitted) -> Option<Surprise> {
        let inertial = self.inertial.as_ref()?;
        inertial.surprise(&inertial.estimate(fitted))
    }

    /// Takes a body for less accurate than stated.
    pub fn widen(&mut self, surprise: Surprise) {
        if let Some(mut widened) = self.inertial.take().map(|inertial| inertial.widened) {
            widened[surprise.body] = surprise.factor;
            self.inertial = Inertial::new(&self.motion, widened);
        }
    }

    /// Change of a body's ten parameters per unit of each deviation: ten rows, a column for each.
    pub fn changes_of(&self, body: usize) -> Option<DMatrix<f64>> {
        let inertial = self.inertial.as_ref()?;
        let nominal = self.motion.model.accuracy.inertial_deviations(&self.motion.model.robot);
        let own = nominal.view((NUMBERS * body, NUMBERS * body), (NUMBERS, NUMBERS)) * inertial.widened[body];
        Some(own * inertial.directions.rows(NUMBERS * body, NUMBERS))
    }

    /// The deviations that are held.
    pub fn held(&self) -> Option<&DVector<f64>> {
        Some(&self.inertial.as_ref()?.held()?.z)
    }

    /// Adds a torque to that of the deviations that are held: `torque[joint][0][row]`, times `factor`.
    pub fn add_held(&mut self, torque: &[Vec<Vec<f64>>], factor: f64) {
        let Some(last) = self.inertial.as_mut().and_then(|inertial| inertial.last.as_mut()) else { return };
        for (sum, torque) in last.torque.iter_mut().zip(torque) {
            sum.iter_mut().zip(&torque[0]).for_each(|(sum, x)| *sum += factor * x);
        }
    }

    /// Updates what each joint can decide of the deviations, from a fit of all joints with these terms.
    pub fn look(&mut self, terms: &[&Term], fitted: &Fitted) {
        let (Some(inertial), Treated::Shared { at, count }) = (&self.inertial, fitted.inertial) else { return };
        if self.baseline.len() < 2 {
            return;
        }
        let system = self.system(terms, Part::Train, false).system;
        let z = inertial.estimate(fitted);
        let of_joint = |joint: usize| {
            let solution = &fitted.solution;
            let trust = self.independence[joint] / solution.scale[joint].powi(2);
            let weights: Vec<f64> = solution.weights[joint].iter().map(|w| w * trust).collect();
            Information::new(&system.blocks[joint], &weights, &solution.residual[joint], at..at + count, &z)
        };
        let known: Vec<Information> = (0..self.baseline.len()).map(of_joint).collect();
        let views = (0..known.len()).map(|joint| view(inertial, &known, joint)).collect();
        if let Some(inertial) = &mut self.inertial {
            inertial.views = views;
        }
    }
}

/// What one joint's rows say about the deviations: `−½ zᵀ Q z + bᵀ z`.
struct Information {
    q: DMatrix<f64>,
    b: DVector<f64>,
}

impl Information {
    /// From the columns of a joint, with the columns `at` for the deviations and all others fitted beside them.
    fn new(block: &Block, weights: &[f64], residual: &[f64], at: std::ops::Range<usize>, z: &DVector<f64>) -> Self {
        let (ours, others): (Vec<_>, Vec<_>) = block.columns.iter().partition(|(index, _)| at.contains(index));
        let product = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).zip(weights).map(|((x, y), w)| x * y * w).sum() };
        let gram = |one: &[&(usize, Vec<f64>)], other: &[&(usize, Vec<f64>)]| {
            DMatrix::from_fn(one.len(), other.len(), |i, j| product(&one[i].1, &other[j].1))
        };
        let mut q = gram(&ours, &ours);
        let mut g = DVector::from_fn(ours.len(), |i, _| product(&ours[i].1, residual));
        let cross = gram(&others, &ours);
        if let Some(factor) = Equilibrated::new(&gram(&others, &others)) {
            let score = DVector::from_fn(others.len(), |i, _| product(&others[i].1, residual));
            g -= cross.tr_mul(&factor.solve(&score));
            for k in 0..cross.ncols() {
                let taken = cross.tr_mul(&factor.solve(&cross.column(k).into_owned()));
                q.column_mut(k).zip_apply(&taken, |q, taken| *q -= taken);
            }
        }
        let b = &q * z + g;
        Self { q, b }
    }
}

/// What a joint can decide, where the others say what they know.
fn view(inertial: &Inertial, known: &[Information], joint: usize) -> Option<View> {
    let n = inertial.count();
    let (mut precision, mut b) = (DMatrix::identity(n, n), DVector::zeros(n));
    for (_, other) in known.iter().enumerate().filter(|(other, _)| *other != joint) {
        precision += &other.q;
        b += &other.b;
    }
    // Rounding may leave the sum a little unsymmetric.
    let precision = (&precision + precision.transpose()) * 0.5;
    let factor = precision.cholesky()?;
    let offset = factor.solve(&b);
    // C = L⁻ᵀ, with L Lᵀ the precision.
    let root = factor.l().transpose().solve_upper_triangular(&DMatrix::identity(n, n))?;
    let own = root.transpose() * &known[joint].q * &root;
    let eigen = ((&own + own.transpose()) * 0.5).symmetric_eigen();
    let shown: Vec<usize> = (0..n).filter(|k| eigen.eigenvalues[*k] > LEAST_INFORMATION).collect();
    let basis = root * eigen.eigenvectors.select_columns(&shown);
    let shift = inertial.torque_of(joint, &offset);
    let columns = basis.column_iter().map(|c| combined(&inertial.columns[joint], c.iter())).collect();
    Some(View { offset, basis, shift, columns })
}

//! What one joint's rows can still decide of what all joints share: the deviations of the nominal model, and effects of the whole machine.
//!
//! The rows of the other joints say of the shared coefficients `x ~ N(m, C Cᵀ)`, `(C Cᵀ)⁻¹ = P + Σ Q_i`, `m = C Cᵀ Σ b_i`. `P` is the precision of
//! the prior, `−½ xᵀ Q_i x + b_iᵀ x` the logarithm of the likelihood of joint `i` near the present fit, beside its own coefficients. So
//! `x = m + C U y` with `y ~ N(0, 1)`, and `U` are the directions that the joint's own rows can decide. Rows are correlated: each joint counts
//! with its number of independent samples. A fit of one joint with the columns of `y` then is what a fit of all joints would give, as far as the
//! likelihood of the others is parabolic.
//! Reference: A. Gelman et al. (2013), Bayesian Data Analysis, ch. 4.1 (normal approximation of a likelihood).

use nalgebra::{DMatrix, DVector};

use super::cause::Cause;
use super::regression::Block;
use super::term::Term;
use crate::linear::Equilibrated;

/// [1] Information of a joint's own rows, relative to what is known without them, below which a direction stays where it is.
const LEAST_INFORMATION: f64 = 0.01;

/// The shared coefficients as the rows of one joint see them.
#[derive(Debug, Clone)]
pub struct View {
    /// Effects of the whole machine whose coefficients are shared, and their shapes.
    beside: Vec<(Cause, Vec<f64>)>,
    offset: DVector<f64>,
    basis: DMatrix<f64>,
    /// Torque of the offset, and what else is known.
    pub shift: Vec<f64>,
    /// Torque of each `y`.
    pub columns: Vec<Vec<f64>>,
}

impl View {
    /// What a joint can decide of the coefficients of these `columns`, where the others say what they know; `beside` are the effects among them.
    pub fn new(
        beside: Vec<(Cause, Vec<f64>)>,
        columns: &[&Vec<f64>],
        prior: &DVector<f64>,
        known: &[Information],
        joint: usize,
    ) -> Option<Self> {
        let n = prior.len();
        let (mut precision, mut b) = (DMatrix::from_diagonal(prior), DVector::zeros(n));
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
        let owned: Vec<Vec<f64>> = columns.iter().map(|column| (*column).clone()).collect();
        let shift = combined(&owned, offset.iter());
        let columns = basis.column_iter().map(|c| combined(&owned, c.iter())).collect();
        Some(Self { beside, offset, basis, shift, columns })
    }

    /// Adds a torque that is known.
    pub fn shifted(mut self, torque: &[f64]) -> Self {
        self.shift.iter_mut().zip(torque).for_each(|(sum, x)| *sum += x);
        self
    }

    /// Whether exactly these effects of the machine are shared.
    pub fn is_beside(&self, terms: &[&Term]) -> bool {
        let mut machine = terms.iter().filter(|term| term.is_machine());
        let same = |known: &(Cause, Vec<f64>), term: &&Term| known.0 == term.effect && known.1 == term.shape;
        self.beside.iter().all(|known| machine.next().is_some_and(|term| same(known, term))) && machine.next().is_none()
    }

    /// The first `count` shared coefficients.
    pub fn deviations(&self, y: &DVector<f64>, count: usize) -> DVector<f64> {
        (&self.offset + &self.basis * y).rows(0, count).into_owned()
    }

    /// Torque of all that is shared.
    pub fn torque(&self, y: &[f64]) -> Vec<f64> {
        let mut torque = combined(&self.columns, y);
        if torque.is_empty() {
            return self.shift.clone();
        }
        torque.iter_mut().zip(&self.shift).for_each(|(sum, x)| *sum += x);
        torque
    }
}

/// What one joint's rows say about the shared coefficients: `−½ xᵀ Q x + bᵀ x`.
pub struct Information {
    /// `Q`
    pub q: DMatrix<f64>,
    b: DVector<f64>,
}

impl Information {
    /// From the columns of a joint at the coefficients `x`; all columns that are not shared are fitted beside them.
    pub fn new(block: &Block, weights: &[f64], residual: &[f64], shared: &[usize], x: &DVector<f64>) -> Self {
        let of = |index: &usize| block.columns.iter().find(|(own, _)| own == index).map(|(_, column)| column);
        let ours: Vec<Option<&Vec<f64>>> = shared.iter().map(of).collect();
        let others: Vec<Option<&Vec<f64>>> =
            block.columns.iter().filter(|(index, _)| !shared.contains(index)).map(|(_, column)| Some(column)).collect();
        let product = |x: Option<&Vec<f64>>, y: Option<&Vec<f64>>| -> f64 {
            let (Some(x), Some(y)) = (x, y) else { return 0.0 };
            x.iter().zip(y).zip(weights).map(|((x, y), w)| x * y * w).sum()
        };
        let gram = |one: &[Option<&Vec<f64>>], other: &[Option<&Vec<f64>>]| {
            DMatrix::from_fn(one.len(), other.len(), |i, j| product(one[i], other[j]))
        };
        let residual = residual.to_vec();
        let mut q = gram(&ours, &ours);
        let mut g = DVector::from_fn(ours.len(), |i, _| product(ours[i], Some(&residual)));
        let cross = gram(&others, &ours);
        if let Some(factor) = Equilibrated::new(&gram(&others, &others)) {
            let score = DVector::from_fn(others.len(), |i, _| product(others[i], Some(&residual)));
            g -= cross.tr_mul(&factor.solve(&score));
            for k in 0..cross.ncols() {
                let taken = cross.tr_mul(&factor.solve(&cross.column(k).into_owned()));
                q.column_mut(k).zip_apply(&taken, |q, taken| *q -= taken);
            }
        }
        let b = &q * x + g;
        Self { q, b }
    }
}

/// `Σ c_k column_k`.
pub fn combined<'c>(columns: &[Vec<f64>], coefficients: impl IntoIterator<Item = &'c f64>) -> Vec<f64> {
    let mut sum = vec![0.0; columns.first().map_or(0, Vec::len)];
    for (column, c) in columns.iter().zip(coefficients) {
        sum.iter_mut().zip(column).for_each(|(sum, x)| *sum += c * x);
    }
    sum
}

//! Linear algebra of least squares whose unknowns have very different units.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Ratio of the smallest to the largest diagonal of `R` below which columns count as dependent: half of the digits.
const DEPENDENT: f64 = 1e-8;

/// `ρ`: so small that the columns determine the first ten of sixteen digits.
pub const RIDGE: f64 = 1e-10;

/// The Cholesky factor of `S A S + ρ 1`, `S = diag(A)^(−1/2)`: the scaling keeps precision where unknowns have very different units.
///
/// `A` is symmetric and positive. The ridge `ρ`, [`RIDGE`], leaves an unknown unchanged if the data do not determine it, or if a
/// combination of others equals it to ten digits.
pub struct Equilibrated {
    cholesky: Cholesky<f64, Dyn>,
    size: DVector<f64>,
}

impl Equilibrated {
    /// Factors `A`; `None` where it is not positive.
    pub fn new(a: &DMatrix<f64>) -> Option<Self> {
        let size = a.diagonal().map(|d: f64| 1.0 / d.max(1e-300).sqrt());
        let mut scaled = scale(a, &size);
        (0..a.nrows()).for_each(|i| scaled[(i, i)] += RIDGE);
        Some(Self { cholesky: Cholesky::new(scaled)?, size })
    }

    /// `x` with `A x = b`.
    pub fn solve(&self, b: &DVector<f64>) -> DVector<f64> {
        self.cholesky.solve(&b.component_mul(&self.size)).component_mul(&self.size)
    }

    /// `A⁻¹`.
    pub fn inverse(&self) -> DMatrix<f64> {
        scale(&self.cholesky.inverse(), &self.size)
    }

    /// `L` of the scaled matrix, `L Lᵀ = S A S + ρ 1`.
    pub fn lower(&self) -> DMatrix<f64> {
        self.cholesky.l()
    }

    /// The diagonal of `S`.
    pub const fn size(&self) -> &DVector<f64> {
        &self.size
    }
}

/// `S A S` with `S = diag(size)`.
pub fn scale(a: &DMatrix<f64>, size: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * size[i] * size[j])
}

/// Parameters and covariance of `min |X θ − y|²` by a QR decomposition. Rows are already divided by their errors. `None` if the columns
/// are linearly dependent.
///
/// `X S = Q R`, `θ = S R⁻¹ Qᵀ y`, covariance `S R⁻¹ R⁻ᵀ S`, `S` the inverse lengths of the columns.
pub fn least_squares(x: &DMatrix<f64>, y: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let size = DVector::from_iterator(x.ncols(), x.column_iter().map(|column| 1.0 / column.norm()));
    if x.nrows() < x.ncols() || size.iter().any(|size| !size.is_finite()) {
        return None;
    }
    let qr = (x * DMatrix::from_diagonal(&size)).qr();
    let r = qr.r();
    let (least, most) = (r.diagonal().abs().min(), r.diagonal().abs().max());
    if least.is_nan() || least <= DEPENDENT * most {
        return None;
    }
    let inverse = r.solve_upper_triangular(&DMatrix::identity(x.ncols(), x.ncols()))?;
    let theta = (&inverse * (qr.q().transpose() * y)).component_mul(&size);
    Some((theta, scale(&(&inverse * inverse.transpose()), &size)))
}

/// Covariance `A⁻¹ (Σ g gᵀ) A⁻¹ m/(m − k)` for errors that are correlated within each of `m` clusters. `scores` are the `g`, one per
/// cluster; `taken` is `k`, the number of them that are not free.
///
/// Reference: K.-Y. Liang, S. L. Zeger (1986), Longitudinal data analysis using generalized linear models.
pub fn sandwich<'g>(
    inverse: &DMatrix<f64>,
    scores: impl ExactSizeIterator<Item = &'g DVector<f64>>,
    taken: usize,
) -> DMatrix<f64> {
    let clusters = scores.len();
    let mut filling = DMatrix::zeros(inverse.nrows(), inverse.nrows());
    scores.for_each(|g| filling += g * g.transpose());
    filling *= clusters as f64 / clusters.saturating_sub(taken).max(1) as f64;
    inverse * filling * inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns whose units differ by twelve orders of magnitude.
    fn columns() -> DMatrix<f64> {
        DMatrix::from_fn(50, 3, |row, k| (0.1 * row as f64).powi(k as i32) * [1e-6, 1.0, 1e6][k])
    }

    #[test]
    fn recover_parameters_of_perfect_rows() {
        let theta = DVector::from_vec(vec![3e6, -2.0, 5e-7]);
        let x = columns();
        let (found, covariance) = least_squares(&x, &(&x * &theta)).expect("the columns differ");
        // The scaled columns have a condition number of 16: fourteen digits are left.
        assert!((found - &theta).component_div(&theta).amax() < 1e-12);
        let normal = x.transpose() * &x;
        let unit = &normal * covariance;
        assert!((unit.diagonal() - DVector::from_element(3, 1.0)).amax() < 1e-10, "{unit}");
    }

    #[test]
    fn property_columns_that_depend_on_each_other_are_refused() {
        let mut x = columns();
        let sum = x.column(0) * 1e6 + x.column(1);
        x.set_column(2, &sum);
        assert!(least_squares(&x, &DVector::zeros(50)).is_none());
    }

    #[test]
    fn equivalent_equilibrated_factor_solves_as_its_inverse_does() {
        let x = columns();
        let normal = x.transpose() * &x;
        let factor = Equilibrated::new(&normal).expect("positive");
        let b = &normal * DVector::from_vec(vec![3e6, -2.0, 5e-7]);
        let (one, other) = (factor.solve(&b), factor.inverse() * &b);
        // The condition number of the scaled matrix is 270: thirteen digits are left.
        assert!((&one - other).component_div(&one).amax() < 1e-12);
    }

    /// One row per cluster, unit weights: the sandwich of White, `A⁻¹ (Σ e² x xᵀ) A⁻¹`.
    #[test]
    fn closed_form_sandwich_of_a_mean() {
        let errors = [1.0, -2.0, 3.0, -2.0];
        let scores: Vec<DVector<f64>> = errors.iter().map(|e| DVector::from_element(1, *e)).collect();
        let found = sandwich(&DMatrix::from_element(1, 1, 0.25), scores.iter(), 1);
        // Σ e²/n² · n/(n − 1) = 18/16 · 4/3, the variance of the mean.
        assert!((found[(0, 0)] - 1.5).abs() < 1e-15);
    }
}

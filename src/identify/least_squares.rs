//! Weighted least squares, linear and non-linear.
//!
//! `min_θ Σ r_k(θ)²`, residuals already divided by their standard errors. Non-linear: Levenberg and Marquardt with Marquardt's
//! scaling, `(JᵀJ + μ diag JᵀJ) δ = −Jᵀ r`, central differences for `J`. Reference: K. Madsen, H. B. Nielsen, O. Tingleff (2004).

use nalgebra::{DMatrix, DVector};

use crate::linear::least_squares;

/// Result of a least-squares fit.
#[derive(Debug, Clone)]
pub struct Fit {
    /// `θ` estimated parameters.
    pub parameters: Vec<f64>,
    /// `(JᵀJ)⁻¹` covariance if the residuals have unit variance.
    pub covariance: DMatrix<f64>,
    /// Covariance by leaving out one residual at a time ([`jackknife`]).
    pub left_out: DMatrix<f64>,
    /// `Σ r²` at the minimum.
    pub chi_squared: f64,
    /// Number of residuals minus number of parameters.
    pub degrees_of_freedom: usize,
}

/// Least part of a residual that the fit leaves: a residual of which less is left determines a parameter alone, and does not show its error.
const LEAST_LEFT: f64 = 1e-3;

impl Fit {
    /// `χ²/ν (JᵀJ)⁻¹`: the covariance where only the residuals show how large the errors are.
    pub fn scattered(&self) -> DMatrix<f64> {
        &self.covariance * self.inflation()
    }

    /// The covariance where the errors of the residuals are known, but not all that they have in common.
    ///
    /// ```text
    ///   ½ (max(1, χ²/ν) (JᵀJ)⁻¹ + Σ δ δᵀ)
    /// ```
    /// Few residuals may determine a parameter, as the slowest windows do breakaway friction. Many others with smaller errors than assumed
    /// do not make those smaller, so that `χ²/ν` below 1 does not count. What the parameters change by if one residual is left out shows errors that
    /// are larger than assumed where they are. The first is too small where assumed errors are, the second scatters where few residuals matter: their mean.
    pub fn robust(&self) -> DMatrix<f64> {
        0.5 * (&self.covariance * self.inflation().max(1.0) + &self.left_out)
    }

    /// `χ²/ν`.
    fn inflation(&self) -> f64 {
        self.chi_squared / self.degrees_of_freedom.max(1) as f64
    }
}

/// Covariance of the parameters by leaving out one residual at a time, to first order:
///
/// ```text
///   Σ δ δᵀ,   δ = (JᵀJ)⁻¹ g r/(1 − h),   h = gᵀ (JᵀJ)⁻¹ g        g: row of J
/// ```
/// Reference: J. G. MacKinnon, H. White (1985), Some heteroskedasticity-consistent covariance matrix estimators (HC3).
fn jackknife(j: &DMatrix<f64>, r: &DVector<f64>, inverse: &DMatrix<f64>) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(inverse.nrows(), inverse.nrows());
    for (row, r) in j.row_iter().zip(r.iter()) {
        let per_residual = inverse * row.transpose();
        let left = 1.0 - (row * &per_residual)[(0, 0)];
        let delta = per_residual * (r / left.max(LEAST_LEFT));
        sum += &delta * delta.transpose();
    }
    sum
}

/// Linear fit `min |X θ − y|²` of rows already divided by their errors; `None` where the columns depend on each other.
pub fn linear(x: &DMatrix<f64>, y: &DVector<f64>) -> Option<Fit> {
    let (parameters, covariance) = least_squares(x, y)?;
    let residuals = x * &parameters - y;
    Some(Fit {
        parameters: parameters.as_slice().to_vec(),
        left_out: jackknife(x, &residuals, &covariance),
        covariance,
        chi_squared: residuals.norm_squared(),
        degrees_of_freedom: y.len().saturating_sub(x.ncols()),
    })
}

/// How a non-linear fit is carried out.
#[derive(Debug, Clone, Copy)]
pub struct Search<'a> {
    /// One per parameter: the size over which the residuals are nearly linear. A parameter of size zero is held at its start.
    pub step: &'a [f64],
    /// Differences are taken over this part of `step`.
    pub part: f64,
    /// Largest number of iterations.
    pub iterations: usize,
    /// Relative gain in the sum of squares below which the search ends.
    pub tolerance: f64,
}

/// Non-linear fit from `start`. `residuals` yields `None` where the parameters are not allowed.
/// Returns `None` if the start is not allowed or the residuals do not determine the parameters.
pub fn levenberg_marquardt(
    start: &[f64],
    search: Search,
    residuals: impl Fn(&[f64]) -> Option<Vec<f64>>,
) -> Option<Fit> {
    let free: Vec<usize> = (0..start.len()).filter(|&k| search.step[k] > 0.0).collect();
    let mut parameters = start.to_vec();
    let mut r = DVector::from_vec(residuals(&parameters)?);
    let mut damping = 1e-3;
    let mut iterations = 0;
    while iterations < search.iterations {
        iterations += 1;
        let j = jacobian(&parameters, &free, search, &residuals, r.len())?;
        let normal = j.transpose() * &j;
        let gradient = j.transpose() * &r;
        let mut gain = None;
        while damping < 1e10 {
            let mut damped = normal.clone();
            for k in 0..free.len() {
                damped[(k, k)] *= 1.0 + damping;
            }
            let trial = damped.cholesky().map(|factor| factor.solve(&-&gradient)).and_then(|delta| {
                let mut next = parameters.clone();
                for (&k, d) in free.iter().zip(delta.iter()) {
                    next[k] += d;
                }
                let after = DVector::from_vec(residuals(&next)?);
                (after.norm_squared() < r.norm_squared()).then_some((next, after))
            });
            match trial {
                Some((next, after)) => {
                    gain = Some(r.norm_squared() - after.norm_squared());
                    (parameters, r) = (next, after);
                    damping = (damping / 9.0).max(1e-12);
                    break;
                }
                None => damping *= 11.0,
            }
        }
        if gain.is_none_or(|gain| gain <= search.tolerance * r.norm_squared() + 1e-15) {
            break;
        }
    }
    let j = jacobian(&parameters, &free, search, &residuals, r.len())?;
    let (_, of_free) = least_squares(&j, &r)?;
    let of_all = |of_free: &DMatrix<f64>| {
        let mut all = DMatrix::zeros(start.len(), start.len());
        for (i, &k) in free.iter().enumerate() {
            for (j, &l) in free.iter().enumerate() {
                all[(k, l)] = of_free[(i, j)];
            }
        }
        all
    };
    let (covariance, left_out) = (of_all(&of_free), of_all(&jackknife(&j, &r, &of_free)));
    let degrees_of_freedom = r.len().saturating_sub(free.len());
    Some(Fit { parameters, covariance, left_out, chi_squared: r.norm_squared(), degrees_of_freedom })
}

/// Central differences, one column per free parameter.
fn jacobian(
    at: &[f64],
    free: &[usize],
    search: Search,
    residuals: &impl Fn(&[f64]) -> Option<Vec<f64>>,
    rows: usize,
) -> Option<DMatrix<f64>> {
    let mut j = DMatrix::zeros(rows, free.len());
    let mut p = at.to_vec();
    for (column, &k) in free.iter().enumerate() {
        let h = search.part * search.step[k];
        p[k] = at[k] + h;
        let above = residuals(&p)?;
        p[k] = at[k] - h;
        let below = residuals(&p)?;
        p[k] = at[k];
        for i in 0..rows {
            j[(i, column)] = (above[i] - below[i]) / (2.0 * h);
        }
    }
    Some(j)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mean of `n` values: `(JᵀJ)⁻¹ = 1/n`, and leaving out the value `i` moves it by `r_i/(n − 1)`.
    #[test]
    fn analytic_errors_of_a_mean() {
        let values = [0.5, -0.5, 0.25, -0.25];
        let fit = linear(&DMatrix::from_element(4, 1, 1.0), &DVector::from_column_slice(&values)).unwrap();
        let squares: f64 = values.iter().map(|value| value * value).sum();
        assert!((fit.left_out[(0, 0)] - squares / 9.0).abs() < 1e-15);
        assert!((fit.scattered()[(0, 0)] - squares / 3.0 / 4.0).abs() < 1e-15);
        // Residuals below their assumed errors of 1 do not shrink the first half.
        assert!((fit.robust()[(0, 0)] - 0.5 * (0.25 + squares / 9.0)).abs() < 1e-15);
    }
}

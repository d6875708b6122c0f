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
    /// `Σ r²` at the minimum.
    pub chi_squared: f64,
    /// Number of residuals minus number of parameters.
    pub degrees_of_freedom: usize,
}

impl Fit {
    /// `χ²/ν`: factor on the covariance, because the residuals show their size better than the errors assumed for them.
    pub fn inflation(&self) -> f64 {
        self.chi_squared / self.degrees_of_freedom.max(1) as f64
    }

    /// Standard error of a parameter.
    pub fn std_error(&self, index: usize) -> f64 {
        (self.covariance[(index, index)] * self.inflation()).sqrt()
    }
}

/// Linear fit `min |X θ − y|²` of rows already divided by their errors; `None` where the columns depend on each other.
pub fn linear(x: &DMatrix<f64>, y: &DVector<f64>) -> Option<Fit> {
    let (parameters, covariance) = least_squares(x, y)?;
    let chi_squared = (x * &parameters - y).norm_squared();
    Some(Fit {
        parameters: parameters.as_slice().to_vec(),
        covariance,
        chi_squared,
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
    let mut covariance = DMatrix::zeros(start.len(), start.len());
    for (i, &k) in free.iter().enumerate() {
        for (j, &l) in free.iter().enumerate() {
            covariance[(k, l)] = of_free[(i, j)];
        }
    }
    let degrees_of_freedom = r.len().saturating_sub(free.len());
    Some(Fit { parameters, covariance, chi_squared: r.norm_squared(), degrees_of_freedom })
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

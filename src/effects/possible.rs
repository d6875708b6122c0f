//! The changes of a body next to those that a fit found which leave it possible.
//!
//! The ten parameters `π̄ + D c` of a body have the pseudo-inertia `P(c) = P̄ + Σ c_k P_k`, which is positive semidefinite for every body and for nothing else.
//! Which changes a motion distinguishes, and which it does not, is in a metric `M`. With the estimate `ĉ` they are at the minimum of
//!
//! ```text
//!   f = (c − ĉ)ᵀ M (c − ĉ)    subject to  P(c) ⪰ 0
//! ```
//! The problem is convex. `t f(c) − ln det P(c)` is self-concordant: Newton steps of the length `1/(1 + λ)`, with their decrement `λ`, stay where `P` is
//! positive and end at its minimum, and `f` there exceeds the least by at most `4/t`.
//! References: P. Wensing, S. Kim, J.-J. Slotine (2018), Linear matrix inequalities for physically consistent inertial parameter identification; S. Boyd,
//! L. Vandenberghe (2004), Convex Optimization, sections 9.6 and 11.3.

use nalgebra::{Cholesky, DMatrix, DVector, Matrix4};

use crate::robot::Inertia;

/// `t`, from where the barrier alone counts to an error of 0.004 in `f`.
const WEIGHTS: [f64; 7] = [1e-3, 1e-2, 1e-1, 1.0, 1e1, 1e2, 1e3];
/// Steps for one weight. Each gains at least `λ − ln(1 + λ)`, which is 0.02 as long as λ exceeds [`NEAR`].
const STEPS: usize = 200;
/// `λ` at which the minimum of one weight is near enough to begin the next.
const NEAR: f64 = 0.2;

/// `P_k` of columns of ten parameters.
fn pseudo_of(changes: &DMatrix<f64>) -> Vec<Matrix4<f64>> {
    let of_column = |column: nalgebra::DVectorView<f64>| Inertia::pseudo(&std::array::from_fn(|row| column[row]));
    changes.column_iter().map(of_column).collect()
}

/// Whether a body has these parameters, its pseudo-inertia positive definite.
pub(super) fn is_possible(inertia: &Inertia, changes: &DMatrix<f64>, estimate: &DVector<f64>) -> bool {
    let mut parameters = inertia.parameters();
    parameters.iter_mut().zip((changes * estimate).iter()).for_each(|(value, change)| *value += change);
    Cholesky::new(Inertia::pseudo(&parameters)).is_some()
}

/// `c − ĉ` for a body, the columns `D` of ten rows, `ĉ`, and `M`, which is positive.
pub(super) fn missing(
    inertia: &Inertia,
    changes: &DMatrix<f64>,
    estimate: &DVector<f64>,
    metric: &DMatrix<f64>,
) -> DVector<f64> {
    // A flat body or a point has a pseudo-inertia on the boundary.
    let own = Inertia::pseudo(&Inertia::nearest(&inertia.parameters()).parameters());
    let slopes = pseudo_of(changes);
    let mut c = DVector::zeros(estimate.len());
    for weight in WEIGHTS {
        for _ in 0..STEPS {
            let pseudo = slopes.iter().zip(c.iter()).fold(own, |sum, (slope, c)| sum + slope * *c);
            let Some(factor) = Cholesky::new(pseudo) else { break };
            let relative: Vec<Matrix4<f64>> = slopes.iter().map(|slope| factor.solve(slope)).collect();
            let barrier = DVector::from_iterator(c.len(), relative.iter().map(Matrix4::trace));
            let curvature = DMatrix::from_fn(c.len(), c.len(), |i, j| (relative[i] * relative[j]).trace());
            let gradient = metric * (&c - estimate) * (2.0 * weight) - barrier;
            let Some(hessian) = Cholesky::new(metric * (2.0 * weight) + curvature) else { break };
            let step = hessian.solve(&gradient);
            let decrement = gradient.dot(&step).max(0.0).sqrt();
            c -= step / (1.0 + decrement);
            if decrement < NEAR {
                break;
            }
        }
    }
    c - estimate
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    fn body() -> Inertia {
        Inertia { mass: 2.0, com: Vector3::new(0.1, 0.0, 0.0), tensor: Matrix3::identity() * 0.02 }
    }

    /// A column that changes one of the ten parameters.
    fn column(parameter: usize) -> DMatrix<f64> {
        DMatrix::from_fn(Inertia::NUMBERS, 1, |row, _| f64::from(u8::from(row == parameter)))
    }

    /// `det P` is 0 where the first moment is that of the whole mass at its radius of gyration: `h² = m Σ_xx`.
    #[test]
    fn analytic_a_first_moment_is_limited_by_the_mass_and_its_extent() {
        let body = body();
        let sigma = Inertia::pseudo(&body.parameters())[(0, 0)];
        let most = (body.mass * sigma).sqrt() - body.mass * body.com.x;
        let of = |estimate: f64| {
            let metric = DMatrix::from_element(1, 1, 1e4);
            1e4 * missing(&body, &column(1), &DVector::from_element(1, estimate), &metric).norm_squared()
        };
        // The barrier leaves an error of up to 4/t = 0.004; rounding is far below it.
        assert!(of(0.9 * most) < 0.004);
        for beyond in [0.02, 0.1] {
            let expected = 1e4 * beyond * beyond;
            assert!((of(most + beyond) - expected).abs() < 0.004 + 1e-9, "{}", of(most + beyond) - expected);
        }
    }
}

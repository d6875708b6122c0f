//! The normal, Student's t and the chi-squared distribution, and the moments of its logarithm. The only module that names statrs.

use std::f64::consts::FRAC_1_SQRT_2;

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};
use statrs::function::erf::erfc;
pub use statrs::function::gamma::digamma;

/// `z`: 97.5 % quantile of the standard normal distribution.
pub const NORMAL_975: f64 = 1.959_963_984_540_054;

/// `1 − Φ(x)`: probability that a standard normal variable exceeds `x`.
pub fn normal_upper_tail(x: f64) -> f64 {
    0.5 * erfc(x * FRAC_1_SQRT_2)
}

/// `t_{0.975}(f)`: 97.5 % quantile of Student's t with `f` degrees of freedom; an `f` below one, and NaN, count as one.
/// From `f` = 1e5 on, the quantile of the normal distribution is used, which differs by 2.4e-5 there. The reason: the
/// numerical inverse loses digits as `f` grows, 1e-6 at `f` = 1e5.
pub fn student_975(freedom: f64) -> f64 {
    const NORMAL: f64 = 1e5;
    if freedom >= NORMAL {
        return NORMAL_975;
    }
    StudentsT::new(0.0, 1.0, freedom.max(1.0)).map_or(NORMAL_975, |student| student.inverse_cdf(0.975))
}

/// Probability that a variable of Student's t distribution with `f` degrees of freedom exceeds `|t|` in magnitude; an `f` below one, and
/// NaN, count as one. A NaN in `t` gives one.
pub fn student_two_sided(t: f64, freedom: f64) -> f64 {
    // statrs panics on NaN.
    if t.is_nan() {
        return 1.0;
    }
    let tail = |student: StudentsT| 2.0 * student.cdf(-t.abs());
    StudentsT::new(0.0, 1.0, freedom.max(1.0)).map_or_else(|_| 2.0 * normal_upper_tail(t.abs()), tail).min(1.0)
}

/// Probability that a chi-squared variable with `f` degrees of freedom exceeds `x`; an `f` below one counts as one, a negative `x` or a NaN as zero.
pub fn chi_squared_upper_tail(x: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom.max(1.0)).map_or(1.0, |chi_squared| chi_squared.sf(x.max(0.0)))
}

/// `ψ'(x)`, `x > 0`: the variance of the logarithm of a chi-squared variable with `2 x` degrees of freedom.
///
/// `ψ'(x) = ψ'(x + 1) + 1/x²` up to the range of the asymptotic series, whose first term left out is below 1e-12 there.
/// Source: M. Abramowitz, I. Stegun (1964), eqs. 6.4.6 and 6.4.12.
pub fn trigamma(x: f64) -> f64 {
    const ASYMPTOTIC: f64 = 12.0;
    let (mut x, mut sum) = (x, 0.0);
    while x < ASYMPTOTIC {
        sum += 1.0 / (x * x);
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    sum + 1.0 / x + 0.5 * y + y / x * (1.0 / 6.0 - y * (1.0 / 30.0 - y * (1.0 / 42.0 - y / 30.0)))
}

/// `x > 0` with `ψ'(x) = y`, `y > 0`: bisection of its logarithm between `1/√y`, where `ψ'` is larger, and that plus `1/y + 1`, where it is smaller.
pub fn inverse_trigamma(y: f64) -> f64 {
    let (mut low, mut high) = (1.0 / y.sqrt(), 1.0 / y.sqrt() + 1.0 / y + 1.0);
    while high / low > 1.0 + 1e-12 {
        let middle = (low * high).sqrt();
        if trigamma(middle) > y { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With two degrees of freedom it is `e^(−x/2)`.
    #[test]
    fn analytic_tail_of_chi_squared_with_two_degrees_of_freedom() {
        for x in [0.0, 0.3, 5.0, 60.0] {
            let tail = chi_squared_upper_tail(x, 2.0);
            // A series of the incomplete gamma function, to ten digits or more.
            assert!((tail / (-0.5 * x).exp() - 1.0).abs() < 1e-9, "{x}: {tail}");
        }
        assert_eq!([f64::NAN, -1.0].map(|x| chi_squared_upper_tail(x, 3.0)), [1.0; 2]);
    }

    #[test]
    fn published_quantiles_of_students_t() {
        // Values from tables, to their last digit.
        let table = [(1.0, 12.7062), (2.0, 4.3027), (3.0, 3.1824), (5.0, 2.5706), (10.0, 2.2281), (30.0, 2.0423)];
        for (f, expected) in table {
            assert!((student_975(f) - expected).abs() < 5.1e-5, "{f}: {}", student_975(f));
        }
    }

    /// With two degrees of freedom `t = (2p − 1) √(2/(4p(1 − p)))`, with one it is the tangent of `π(p − ½)`.
    #[test]
    fn analytic_quantiles_of_one_and_two_degrees_of_freedom() {
        let p: f64 = 0.975;
        let two = (2.0 * p - 1.0) * (2.0 / (4.0 * p * (1.0 - p))).sqrt();
        let one = (std::f64::consts::PI * (p - 0.5)).tan();
        // Computed by iteration, to at least nine digits.
        assert!((student_975(2.0) / two - 1.0).abs() < 1e-9, "{}", student_975(2.0));
        assert!((student_975(1.0) / one - 1.0).abs() < 1e-9, "{}", student_975(1.0));
    }

    /// With one degree of freedom the two-sided tail is `1 − 2 atan(t)/π`, with two it is `1 − t/√(2 + t²)`.
    #[test]
    fn analytic_two_sided_tails_of_one_and_two_degrees_of_freedom() {
        for t in [0.0_f64, 0.3, 2.0, 30.0, 1000.0] {
            let one = 2.0 / std::f64::consts::PI * 1f64.atan2(t);
            // The difference 1 − t/√(2 + t²), without cancellation.
            let root = (2.0 + t * t).sqrt();
            let two = 2.0 / (root * (root + t));
            for (f, expected) in [(1.0, one), (2.0, two)] {
                for sign in [1.0, -1.0] {
                    let found = student_two_sided(sign * t, f);
                    // Computed by a continued fraction, to at least nine digits.
                    assert!((found / expected - 1.0).abs() < 1e-9, "t {t}, f {f}: {found} for {expected}");
                }
            }
        }
        assert_eq!(student_two_sided(f64::NAN, 3.0), 1.0);
        assert_eq!(student_two_sided(f64::INFINITY, 3.0), 0.0);
    }

    #[test]
    fn property_quantiles_fall_towards_the_normal_ones_and_stay_finite() {
        let freedoms = [f64::NAN, -1.0, 0.0, 1.0, 1.5, 2.0, 7.3, 50.0, 1e3, 9.9e4, 1.1e5, f64::INFINITY];
        let quantiles = freedoms.map(student_975);
        assert!(quantiles.iter().all(|t| t.is_finite()), "{quantiles:?}");
        assert!(quantiles[3..].windows(2).all(|pair| pair[0] >= pair[1] - 1e-9), "{quantiles:?}");
        assert!((student_975(9.9e4) - NORMAL_975).abs() < 3e-5);
    }

    #[test]
    fn published_tails_of_the_normal_distribution() {
        // Abramowitz and Stegun, table 26.2, and symmetry.
        for (x, tail) in
            [(0.0, 0.5), (1.0, 0.158_655_253_931_457), (3.0, 1.349_898_031_630_1e-3), (6.0, 9.865_876_450_377e-10)]
        {
            assert!((normal_upper_tail(x) / tail - 1.0).abs() < 1e-10, "{x}: {}", normal_upper_tail(x));
            assert!((normal_upper_tail(x) + normal_upper_tail(-x) - 1.0).abs() < 1e-15);
        }
        assert!((normal_upper_tail(NORMAL_975) / 0.025 - 1.0).abs() < 1e-10);
    }

    #[test]
    fn published_values_of_the_trigamma_function() {
        // Abramowitz and Stegun, 6.4.4 and 6.4.5: ψ'(1) = π²/6, ψ'(1/2) = π²/2, ψ'(n + 1) = π²/6 − Σ 1/k².
        let pi = std::f64::consts::PI.powi(2);
        for (x, value) in [(1.0, pi / 6.0), (0.5, pi / 2.0), (3.0, pi / 6.0 - 1.25), (2.5, pi / 2.0 - 4.0 - 4.0 / 9.0)]
        {
            // The series to 1e-12, and rounding of values up to 5.
            assert!((trigamma(x) - value).abs() < 1e-11, "{x}: {}", trigamma(x));
        }
        for x in [1e-3, 0.22, 1.0, 7.5, 300.0] {
            // The bisection ends at 1e-12; the relative error of ψ' carries over about once.
            assert!((inverse_trigamma(trigamma(x)) / x - 1.0).abs() < 1e-8, "{x}");
        }
    }
}

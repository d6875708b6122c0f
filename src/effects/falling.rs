//! The falling part of friction in a row: averaged over the kernel of the row, with a velocity that changes linearly.
//!
//! `φ(v_S) = ∫ K(s) sgn v(s) e^{−|v(s)|/v_S} ds`, `v(s) = v + a s`. If the direction does not change, this is
//! `e^{−|v|/v_S} M(x)`, `M(x) = 15 ((3 + x²) sinh x − 3 x cosh x)/x⁵`, `x = a w/v_S`: the mean of a falling exponential is larger than its
//! value at the mean velocity. For a joint that starts or stops with 1 rad/s², `w` = 0.08 s gives `x` = 2 and `M` = 1.3. A fit that
//! uses the row's velocity for every sample finds `v_S` 10 % too large.

use super::Motion;

/// Number of samples of a kernel.
const SAMPLES: usize = 16;
/// `|a| w/v_S` below which the velocity counts as constant: `M − 1 = x²/14 < 10⁻³`.
const STEADY: f64 = 0.1;
/// `(|v| − |a| w)/v_S` above which the falling part is neglected.
const FAST: f64 = 8.0;

/// `sgn v · e^{−|v|/v_S}` of each row, averaged over its kernel; 0 at rest.
pub fn falling(motion: &Motion, joint: usize, v_s: f64) -> Vec<f64> {
    averaged(motion, joint, v_s, |y| (-y).exp(), mean)
}

/// Derivative of [`falling`] by `v_S`.
pub fn falling_slope(motion: &Motion, joint: usize, v_s: f64) -> Vec<f64> {
    averaged(motion, joint, v_s, |y| y / v_s * (-y).exp(), |y, x| mean_slope(y, x) / v_s)
}

/// `sgn v · f(|v|/v_S)` of each row over its kernel; if the direction does not change, its mean is `one_way(y, x)` with `y = |v|/v_S`.
fn averaged(
    motion: &Motion,
    joint: usize,
    v_s: f64,
    f: impl Fn(f64) -> f64,
    one_way: impl Fn(f64, f64) -> f64,
) -> Vec<f64> {
    motion.column(joint, |m, row| {
        if m.direction[row] == 0.0 {
            return 0.0;
        }
        let change = m.a.get(row).map_or(0.0, |a| a.abs() * motion.half_width[row]);
        let speed = m.v[row].abs();
        if change < STEADY * v_s || speed - change > FAST * v_s {
            return m.direction[row] * f(speed / v_s);
        }
        if speed > change {
            return m.v[row].signum() * one_way(speed / v_s, change / v_s);
        }
        over_kernel(|u| {
            let v = m.v[row] + change * u;
            v.signum() * f(v.abs() / v_s)
        })
    })
}

/// `e^{−y} sinh x` and `e^{−y} cosh x`, finite for all `y > x`.
fn hyperbolic(y: f64, x: f64) -> [f64; 2] {
    let (plus, minus) = ((x - y).exp(), (-x - y).exp());
    [0.5 * (plus - minus), 0.5 * (plus + minus)]
}

/// `e^{−y} M(x)`.
fn mean(y: f64, x: f64) -> f64 {
    let [sinh, cosh] = hyperbolic(y, x);
    15.0 * ((3.0 + x * x) * sinh - 3.0 * x * cosh) / x.powi(5)
}

/// Derivative of [`mean`] by `ln v_S`; both `y` and `x` are inversely proportional to `v_S`.
fn mean_slope(y: f64, x: f64) -> f64 {
    let [sinh, cosh] = hyperbolic(y, x);
    (y + 5.0) * mean(y, x) - 15.0 * (x * cosh - sinh) / x.powi(3)
}

/// `∫ 15/16 (1 − u²)² f(u) du` over −1 to 1, by the midpoint rule.
pub(super) fn over_kernel(f: impl Fn(f64) -> f64) -> f64 {
    let sample = |k: usize| (2.0 * k as f64 + 1.0) / SAMPLES as f64 - 1.0;
    let weight = |u: f64| (1.0 - u * u).powi(2);
    let (sum, total) = (0..SAMPLES).map(sample).fold((0.0, 0.0), |(sum, total), u| {
        let w = weight(u);
        (sum + w * f(u), total + w)
    });
    sum / total
}

#[cfg(test)]
mod tests {
    use super::{mean, mean_slope, over_kernel};

    #[test]
    fn equivalent_mean_of_an_exponential_over_the_kernel() {
        for (y, x) in [(0.35, 0.3_f64), (3.0, 1.0), (2.5, 2.0), (4.1, 4.0)] {
            let sampled = over_kernel(|u| (-y - x * u).exp());
            // The midpoint rule with a kernel that ends with slope zero has an error of fourth order: 10⁻³ at x = 4.
            assert!((sampled / mean(y, x) - 1.0).abs() < 1e-3, "{y} {x}");
        }
    }

    #[test]
    fn equivalent_the_slope_is_that_of_the_mean() {
        for (y, x) in [(0.35, 0.3_f64), (3.0, 1.0), (2.5, 2.0), (800.0, 795.0)] {
            let (more, less) = (mean(y / 1.001, x / 1.001), mean(y / 0.999, x / 0.999));
            let slope = (more - less) / (1.001_f64.ln() - 0.999_f64.ln());
            // Differences over 0.1 % have an error of the square, 10⁻⁶, times the third derivative by ln v_S: a polynomial in y − x and 1.
            let tolerance = 1e-6 * (1.0 + (y - x).powi(2)) * mean(y, x);
            assert!(
                (slope - mean_slope(y, x)).abs() < 3.0 * tolerance.max(1e-9),
                "{y} {x}: {slope} {}",
                mean_slope(y, x)
            );
        }
    }

    #[test]
    fn property_a_kernel_centred_on_a_reversal_sees_no_direction() {
        assert!(over_kernel(|u| u.signum() * (-3.0 * u.abs()).exp()).abs() < 1e-12);
    }
}

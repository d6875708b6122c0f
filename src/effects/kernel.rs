//! What the kernel that makes rows of samples leaves of a harmonic.

/// Fourier transform of the kernel at `x = ω w`: `15 j₂(x)/x² = Σ (−x²/2)^k/(k! · 7 · 9 · … · (2k + 5))`.
///
/// The closed form loses digits towards `x = 0`; up to `x = 2` nine terms of the series leave 5e-16.
pub fn kernel_gain(x: f64) -> f64 {
    let x2 = x * x;
    if x2 < 4.0 {
        return RATIOS.iter().rev().fold(1.0, |sum, ratio| 1.0 - sum * x2 * ratio);
    }
    closed_form(x)
}

/// Ratio of each term of the series to the one before, divided by `−x²`.
const RATIOS: [f64; 9] = {
    let mut ratios = [0.0; 9];
    let mut k = 1;
    while k <= ratios.len() {
        ratios[k - 1] = 1.0 / (2 * k * (2 * k + 5)) as f64;
        k += 1;
    }
    ratios
};

fn closed_form(x: f64) -> f64 {
    let (x2, (sin, cos)) = (x * x, x.sin_cos());
    15.0 * ((3.0 - x2) * sin - 3.0 * x * cos) / (x2 * x2 * x)
}

/// Gains of the kernel at `x = n v w` for `e^{inθ}` and its derivatives, where `θ` moves with `v` and `a`. Within the kernel,
/// `θ(t + s) = θ + v s + a s²/2`, so that its mean is `E = e^{inθ} (K̂ − i n a w² K̂″/2)`, and to first order in `a`
///
/// ```text
///   Ė = e^{inθ} ( i n v K̂ + n a w (K̂′ + x K̂″/2) )
///   Ë = e^{inθ} ( −(n v)² K̂ + i n a (K̂ + 2 x K̂′ + x² K̂″/2) )
/// ```
/// With the spherical Bessel functions, `K̂ = 15 j₂/x²`, `K̂′ = −15 j₃/x²` and `K̂″ = −15 (j₃/x³ − j₄/x²)`.
pub(super) struct Gains {
    /// `K̂`
    pub(super) value: f64,
    /// `K̂′ + x K̂″/2 = 30 j₃/x² − 7.5 j₂/x`
    pub(super) rate: f64,
    /// `K̂ + 2 x K̂′ + x² K̂″/2 = (15/x² − 7.5) j₂ + 15 j₃/x`
    pub(super) curvature: f64,
}

impl Gains {
    /// At `x`.
    pub(super) fn at(x: f64) -> Self {
        let x2 = x * x;
        let value = kernel_gain(x);
        if x2 < 0.01 {
            return Self { value, rate: -3.0 / 14.0 * x, curvature: 1.0 - 3.0 / 7.0 * x2 };
        }
        let (sin, cos) = x.sin_cos();
        let j2 = value * x2 / 15.0;
        let j3 = ((15.0 - 6.0 * x2) * sin - (15.0 - x2) * x * cos) / (x2 * x2);
        Self { value, rate: 30.0 * j3 / x2 - 7.5 * j2 / x, curvature: (15.0 / x2 - 7.5) * j2 + 15.0 * j3 / x }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the series ends it is as good as the closed form, whose rounding error there is a few units of `15 · 6/x⁵`.
    #[test]
    fn equivalent_series_and_closed_form() {
        for x in [1.0, 1.5, 1.999] {
            assert!((kernel_gain(x) - closed_form(x)).abs() < 3.0 * f64::EPSILON * 90.0 / x.powi(5), "{x}");
        }
        assert_eq!(kernel_gain(0.0), 1.0);
    }

    /// The mean over a kernel of `e^{inθ}` and of its derivatives, for a motion that accelerates, by a fine sum.
    #[test]
    fn equivalent_rates_of_a_ripple_are_means_over_the_kernel() {
        let (w, n) = (0.02, 80.0);
        for (v, a) in [(0.02, 1.0), (0.4, 3.0), (1.0, -3.0), (2.5, 3.0)] {
            let theta = |s: f64| v * s + 0.5 * a * s * s;
            let mean = |of: &dyn Fn(f64) -> f64| -> f64 {
                const STEPS: i32 = 4000;
                let at = |k: i32| {
                    let u = f64::from(k) / f64::from(STEPS);
                    15.0 / 16.0 * (1.0 - u * u).powi(2) * of(w * u) / f64::from(STEPS)
                };
                (-STEPS..=STEPS).map(at).sum()
            };
            let speed = |s: f64| n * (v + a * s);
            let rate = [mean(&|s| -speed(s) * (n * theta(s)).sin()), mean(&|s| speed(s) * (n * theta(s)).cos())];
            let curvature = [
                mean(&|s| -n * a * (n * theta(s)).sin() - speed(s).powi(2) * (n * theta(s)).cos()),
                mean(&|s| n * a * (n * theta(s)).cos() - speed(s).powi(2) * (n * theta(s)).sin()),
            ];
            let Gains { value, rate: drift, curvature: chirp } = Gains::at(n * v * w);
            // Terms of second order remain, (n a w)² K̂″ and those of the phase, with K̂″ = −1/7 at most.
            let second = 0.3 * (n * a * w).powi(2);
            let close = |found: f64, mean: f64, tolerance: f64| {
                assert!((found - mean).abs() < tolerance, "{v} {a}: {found}, {mean}")
            };
            // Those of the rates are smaller by n v, and with the signs of both ends of the kernel they nearly cancel.
            let fast = n * (v.abs() + a.abs() * w);
            close(drift * n * a * w, rate[0], 2e-3 * fast);
            close(value * n * v, rate[1], 2e-3 * fast);
            close(-value * (n * v).powi(2), curvature[0], second);
            close(chirp * n * a, curvature[1], second);
        }
    }
}

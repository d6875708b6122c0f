//! Fisher information of an experiment about friction and gap: what the model says before anything is recorded.
//!
//! **Friction.** A window of length `T` at the speed `v` gives the mean friction `F(v)`, equation 6, with the variance
//!
//! ```text
//!   F(v) = F_C + (F_S − F_C) e^{−v/v_S} + F_V v
//!
//!   σ²(v, T) = σ_τ² Δt/T  +  J² · 720 σ_x²/(n T⁴)         σ_τ² = (K σ_i)² + (K δ_i)²/12 + (ε F)²
//!                                                          σ_x² = (v Δt)²/12 + (e δ)²,   n = v T/δ
//! ```
//! First term: the mean of `T/Δt` samples of torque, each with the noise `σ_i` and the resolution `δ_i` of the current sensor, and with
//! what the identification assumes that its model lacks from sample to sample, `ε F`. Second term: torque that accelerates `J` is not
//! friction. `n` encoder edges, each placed to `σ_x` (anywhere in its sample interval, and the encoder's own error `e` of a count `δ`),
//! give a constant acceleration with the variance `720 σ_x²/(n T⁴)`: that of the second coefficient of a parabola through `n` equidistant
//! points. These are the errors that the filter of the torque balance assumes (`identify::motion`); errors of different windows are
//! independent there, and here. Left out: what windows have in common, ripple and friction that depends on position.
//!
//! ```text
//!   M = Σ_w g_w g_wᵀ/σ_w² + I         g = θ ∂F/∂θ = (F_C (1 − e), F_S e, (F_S − F_C) e v/v_S, F_V v, F_C (v/v_N)²),   e = e^{−v/v_S}
//! ```
//! `M⁻¹` is the covariance of the relative errors of the four coefficients, and of `C_ii v²` of equation 11 in units of `F_C` at the fastest
//! speed `v_N`; the unit matrix says that each is known within 100 %, so that an experiment that does not determine one of them has a
//! finite value. `C_ii` is zero for a joint that moves alone, but the identification keeps it where its estimate differs from zero, by chance
//! in one of some fifty runs. Then the other coefficients have the errors that they have beside a free `C_ii`: with only two fast speeds `F_V`
//! would be lost. So a plan is judged by the mean of both cases, `C_ii` zero and free.
//!
//! **Gap.** A reversal gives the gap as the distance between two contacts of the flanks, and the encoder shows either of them within a
//! count, with the variance `δ²/12`:
//!
//! ```text
//!   σ_b² = (2 · δ²/12)/n
//! ```
//! for `n` reversals at different phases of a count. It depends neither on speed nor on deceleration, as long as the link stays on its flank.
//! Where the friction is not known well enough to place the rotor inside a count, simulated reversals from 1 to 3 deg/s scatter by 0.35 to
//! 0.45 counts, and `1/√6` is 0.41. Where it is, they scatter by less than half of that: the plan reckons with the worse case.
//!
//! **Criterion.** The mean of `ln var` over the coefficients: a per cent gained in one of them counts as a per cent in any other.
//! Their errors differ by a factor of twenty (0.05 % of `F_S`, 1 % of `v_S`), so that the sum of variances, or the worst, would spend all time on one.
//! It is averaged over the laws that are possible: both directions, and other `v_S` than the model's, so that the plan does not rely on it.

use nalgebra::{Matrix5, Vector4, Vector5};

use crate::gearhead::{Exponential, FrictionLaw};
use crate::identify::{EDGE, SMALL_MODEL_ERROR};
use crate::robot::JointModel;

/// Factors on `v_S` that are considered where the model has friction: an earlier identification is right within them.
const KNOWN: [f64; 3] = [0.6, 1.0, 1.6];
/// The same where the friction is a guess.
const GUESSED: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];

/// Sensors and inertia of a joint, as far as they decide the error of a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensing {
    /// Standard deviation of the torque of a sample by the current sensor [N·m or N].
    pub torque_noise: f64,
    /// `Δt` [s] between two samples.
    pub interval: f64,
    /// `J` [kg·m² or kg] of rotor and link.
    pub inertia: f64,
    /// `δ` [rad or m] size of an encoder count; 0 for an exact encoder.
    pub count: f64,
}

impl Sensing {
    /// Of a joint that moves an inertia [kg·m² or kg] and is read every `interval` [s].
    pub fn of(joint: &JointModel, inertia: f64, interval: f64) -> Self {
        let noise = joint.current_sensor.map_or(0.0, |sensor| sensor.noise.hypot(sensor.resolution / 12f64.sqrt()));
        Self { torque_noise: joint.torque_per_ampere() * noise, interval, inertia, count: joint.encoder_step() }
    }

    /// `σ²(v, T)` [N²·m² or N²] of the mean friction over a window of `time` [s] at a `speed` [rad/s or m/s] with a friction [N·m or N].
    pub fn variance(&self, speed: f64, time: f64, friction: f64) -> f64 {
        let of_sample = self.torque_noise.powi(2) + (SMALL_MODEL_ERROR * friction).powi(2);
        let edge = (speed * self.interval).powi(2) / 12.0 + (EDGE * self.count).powi(2);
        let edges = if self.count > 0.0 { speed * time / self.count } else { time / self.interval };
        of_sample * self.interval / time + self.inertia.powi(2) * 720.0 * edge / (edges.max(1.0) * time.powi(4))
    }

    /// `σ_b` [rad or m] of the gap from `reversals`; 0 for an exact encoder.
    pub fn gap_error(&self, reversals: usize) -> f64 {
        self.count / (6.0 * reversals as f64).sqrt()
    }
}

/// A window: speed [rad/s or m/s] and length [s].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteadyWindow {
    /// `v` [rad/s or m/s] > 0.
    pub speed: f64,
    /// `T` [s] > 0.
    pub time: f64,
}

/// Coefficients of equation 6 in the order of the vectors here.
const fn coefficients(law: &Exponential) -> [f64; 4] {
    [law.coulomb, law.breakaway, law.stribeck_velocity, law.viscous]
}

/// Relative covariance of `(F_C, F_S, v_S, F_V, C_ii)` from windows in one direction, each `repeats` times. If `C_ii` is not free, its variance is
/// that of its prior, and it affects no other.
pub fn covariance(
    law: &Exponential,
    sensing: &Sensing,
    windows: &[SteadyWindow],
    repeats: f64,
    free_centrifugal: bool,
) -> Matrix5<f64> {
    let mut information = Matrix5::identity();
    let [coulomb, breakaway, stribeck, viscous] = coefficients(law);
    let fastest = windows.iter().map(|window| window.speed).fold(f64::MIN_POSITIVE, f64::max);
    for window in windows {
        let v = window.speed;
        let e = (-v / stribeck).exp();
        let centrifugal = if free_centrifugal { coulomb * (v / fastest).powi(2) } else { 0.0 };
        let of_fall = (breakaway - coulomb) * e * v / stribeck;
        let g = Vector5::new(coulomb * (1.0 - e), breakaway * e, of_fall, viscous * v, centrifugal);
        let friction = coulomb + (breakaway - coulomb) * e + viscous * v;
        information += g * g.transpose() * (repeats / sensing.variance(v, window.time, friction));
    }
    // Symmetric and at least the unit matrix: it has a Cholesky factor.
    information.cholesky().map_or_else(Matrix5::identity, |factor| factor.inverse())
}

/// Variances of the four coefficients of equation 6.
fn variances(covariance: &Matrix5<f64>) -> Vector4<f64> {
    covariance.diagonal().fixed_rows::<4>(0).into_owned()
}

/// The laws that a plan has to measure well.
#[derive(Debug, Clone, PartialEq)]
pub struct Possible {
    /// As the model has them, or as they are guessed: positive and negative direction.
    pub nominal: [Exponential; 2],
    /// With other `v_S` as well.
    laws: Vec<Exponential>,
}

impl Possible {
    /// About the law of a model, or about a guess.
    pub fn about(law: &FrictionLaw, known: bool) -> Self {
        let nominal = match law {
            FrictionLaw::Exponential(law) => *law,
            // The exponential law whose tangents at rest and at high speed are the two lines.
            FrictionLaw::TwoLines(lines) => lines.map(|line| Exponential {
                coulomb: line.a2,
                breakaway: line.a1,
                stribeck_velocity: line.switch_velocity(),
                viscous: line.b2,
            }),
        };
        let factors: &[f64] = if known { &KNOWN } else { &GUESSED };
        let with =
            |law: &Exponential, factor: &f64| Exponential { stribeck_velocity: factor * law.stribeck_velocity, ..*law };
        let laws = nominal.iter().flat_map(|law| factors.iter().map(|factor| with(law, factor))).collect();
        Self { nominal, laws }
    }

    /// Mean of `ln var` over coefficients and laws, `C_ii` zero and free.
    pub fn criterion(&self, sensing: &Sensing, windows: &[SteadyWindow], repeats: f64) -> f64 {
        let of =
            |law: &Exponential, free| variances(&covariance(law, sensing, windows, repeats, free)).map(f64::ln).mean();
        let sum: f64 = self.laws.iter().map(|law| 0.5 * (of(law, false) + of(law, true))).sum();
        sum / self.laws.len() as f64
    }

    /// [1] Relative standard errors of `(F_C, F_S, v_S, F_V)` in the positive and the negative direction, under the nominal laws.
    pub fn errors(&self, sensing: &Sensing, windows: &[SteadyWindow], repeats: f64) -> [[f64; 4]; 2] {
        let of = |law| variances(&covariance(&law, sensing, windows, repeats, false)).map(f64::sqrt).into();
        self.nominal.map(of)
    }

    /// [N·m or N] Largest friction at a speed.
    pub fn largest(&self, speed: f64) -> f64 {
        let at = |law: &Exponential| law.dry(speed) + law.viscous * speed;
        at(&self.nominal[0]).max(at(&self.nominal[1]))
    }

    /// [N·m or N] Smallest Coulomb friction.
    pub fn smallest_coulomb(&self) -> f64 {
        self.nominal[0].coulomb.min(self.nominal[1].coulomb)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, Matrix5, Vector5};

    use super::*;

    const LAW: Exponential = Exponential { coulomb: 0.27, breakaway: 0.46, stribeck_velocity: 0.026, viscous: 0.6 };
    const SENSING: Sensing = Sensing { torque_noise: 3.7e-3, interval: 1e-3, inertia: 2.0, count: 5.8e-4 };

    /// `(I + g gᵀ/σ²)⁻¹ = I − g gᵀ/(σ² + |g|²)` (J. Sherman, W. Morrison 1950), with `g` from differences of the law itself.
    #[test]
    fn analytic_information_of_a_single_window() {
        let window = SteadyWindow { speed: 0.05, time: 2.0 };
        let friction = |p: [f64; 4]| {
            let law = Exponential { coulomb: p[0], breakaway: p[1], stribeck_velocity: p[2], viscous: p[3] };
            law.dry(window.speed) + law.viscous * window.speed
        };
        let theta = coefficients(&LAW);
        let g = Vector5::from_fn(|k, _| {
            if k == 4 {
                return LAW.coulomb;
            }
            let changed = |sign: f64| std::array::from_fn(|i| theta[i] * if i == k { 1.0 + sign * 1e-5 } else { 1.0 });
            (friction(changed(1.0)) - friction(changed(-1.0))) / 2e-5
        });
        let sigma_2 = SENSING.variance(window.speed, window.time, friction(theta));
        let expected = Matrix5::identity() - g * g.transpose() / (sigma_2 + g.norm_squared());
        let found = covariance(&LAW, &SENSING, &[window], 1.0, true);
        // Central differences of a smooth function over 1e-5 are good to 1e-10 of its curvature, of the order of one; g²/σ² is 1e8, which the
        // inversion loses of its sixteen digits.
        assert!((found - expected).norm() < 1e-6, "{found} for {expected}");
    }

    #[test]
    fn analytic_error_of_an_acceleration_is_that_of_a_parabola_through_the_edges() {
        let exact = Sensing { torque_noise: 0.0, ..SENSING };
        let (speed, time) = (0.1, 2.0);
        let variance = exact.variance(speed, time, 0.0);
        let edges = (speed * time / exact.count).round() as usize;
        let t = |k: usize| time * k as f64 / (edges - 1) as f64;
        let x = DMatrix::from_fn(edges, 3, |k, j| [1.0, t(k), 0.5 * t(k) * t(k)][j]);
        let edge = (speed * exact.interval).powi(2) / 12.0 + (EDGE * exact.count).powi(2);
        let fitted = (x.transpose() * &x).try_inverse().expect("three columns")[(2, 2)] * edge * exact.inertia.powi(2);
        // 720/n is the limit of many points; with n = 345 the next term is 3/n.
        assert!((variance / fitted - 1.0).abs() < 0.02, "{variance:e} for {fitted:e}");
    }

    #[test]
    fn property_more_time_and_more_windows_tell_more() {
        let possible = Possible::about(&FrictionLaw::Exponential([LAW; 2]), true);
        // More speeds than the five quantities, so that none rests on its prior.
        let windows = |time: f64| [0.003, 0.01, 0.03, 0.08, 0.12, 0.17].map(|speed| SteadyWindow { speed, time });
        let [short, long] = [1.0, 2.0].map(|time| possible.criterion(&SENSING, &windows(time), 1.0));
        assert!(long < short, "{long} after {short}");
        assert!(possible.criterion(&SENSING, &windows(1.0)[1..], 1.0) > short);
        // Where the white noise of the torque decides, twice the time halves the variances: ln 2.
        let quiet = Sensing { inertia: 0.0, ..SENSING };
        let [short, long] = [10.0, 20.0].map(|time| possible.criterion(&quiet, &windows(time), 1.0));
        // The prior of 100 % takes 1e-4 of a coefficient that is known to 1 %.
        assert!((short - long - 2f64.ln()).abs() < 1e-3, "{}", short - long);
    }
}

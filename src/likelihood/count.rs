//! One reading of an encoder: its probability, and what it says of the angle.
//!
//! ```text
//!   count: θ ∈ [a, b)      Z = Φ((b − m)/s) − Φ((a − m)/s)          ℓ = ln[(1 − ε) Z + ε ((1 − η) Z_w + η Z_0)]
//!   exact: θ = y ± r       Z = r √(2π) N(y; m, s² + r²)                s_w² = 36 s² + δ²
//! ```
//! `m`, `s²`: mean and variance that the filter predicts. `Z_w` is the same with `s_w`: one reading in a thousand may be an outlier, and a
//! wrong model then loses nats but not its track. `δ` is the size of a count, for an exact reading `r`, the sensor's floor. `Z_0 = δ/R`, of an exact reading
//! `r √(2π)/R`, is the same of an even chance over all the way `R` that was recorded: a share `η` of outliers may be anywhere. A machine that loses its track
//! then pays some 20 nats, however far it went, so that a score says how often a model fails and not how badly it failed once.
//! The angle that has been read is a normal variable truncated to the count, with mean `m*` and variance `V*`:
//!
//! ```text
//!   m* − m = s (φ(α) − φ(β))/Z       V*/s² = 1 + (α φ(α) − β φ(β))/Z − ((m* − m)/s)²       α, β: a and b in units of s from m
//! ```
//! References: S. Särkkä, L. Svensson (2023), Bayesian filtering and smoothing, chapter 6, for the update by moments; R. Curry (1970), Estimation and control
//! with quantized measurements, chapter 2, for counts.

use super::Settings;
use crate::distributions::normal_upper_tail;

/// What was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Read {
    /// [rad or m] Middle of the count, or the reading.
    pub middle: f64,
    /// `δ/2` [rad or m] half a count; 0 for an exact reading.
    pub half: f64,
    /// `r` [rad or m] standard deviation of an exact reading; of an encoder, how sharp its edges are.
    pub floor: f64,
    /// `R` [rad or m] way over which readings were recorded.
    pub range: f64,
}

/// What a reading says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Said {
    /// `ℓ` [nat].
    pub nats: f64,
    /// [1] Probability, given the reading, that it is no outlier.
    pub regular: f64,
    /// `m* − m` [rad or m].
    pub shift: f64,
    /// `V*/s²` [1].
    pub share: f64,
    /// `s²` [rad² or m²], edges included.
    pub variance: f64,
    /// [1] Predicted probability of a lower reading, and of this one (0 for an exact reading).
    pub below: f64,
    /// See [`below`](Self::below).
    pub inside: f64,
}

/// `Z`, `m* − m` in units of `s`, `V*/s²`.
struct Truncated {
    probability: f64,
    shift: f64,
    share: f64,
}

impl Read {
    /// What the reading says of an angle whose predicted mean is `m` and variance `p`, with the shares `ε` and `η` of the settings.
    pub fn says(&self, m: f64, p: f64, settings: &Settings) -> Said {
        let variance = p + self.floor * self.floor;
        let s = variance.sqrt();
        let away = self.middle - m;
        let wide = (36.0 * variance + 4.0 * self.half * self.half + self.floor * self.floor).sqrt();
        if self.half == 0.0 {
            return self.exact(away, p, s, wide, settings);
        }
        let (alpha, beta) = ((away - self.half) / s, (away + self.half) / s);
        let Truncated { probability, shift, share } = truncated(alpha, beta);
        let other = inside((away - self.half) / wide, (away + self.half) / wide);
        let (regular, all) = mixed(probability, other, 2.0 * self.half / self.range, settings);
        let below = normal_upper_tail(-alpha);
        Said { nats: all.ln(), regular, shift: s * shift, share, variance, below, inside: probability }
    }

    /// An exact reading, whose density is taken in units of its own floor.
    fn exact(&self, away: f64, p: f64, s: f64, wide: f64, settings: &Settings) -> Said {
        let density = |s: f64| self.floor / s * (-0.5 * (away / s).powi(2)).exp();
        let anywhere = self.floor * (2.0 * std::f64::consts::PI).sqrt() / self.range;
        let (regular, all) = mixed(density(s), density(wide), anywhere, settings);
        let share = self.floor * self.floor / (s * s);
        let shift = away * p / (s * s);
        Said {
            nats: all.ln(),
            regular,
            shift,
            share,
            variance: s * s,
            below: normal_upper_tail(-away / s),
            inside: 0.0,
        }
    }
}

/// Share of the regular part, and the sum; a probability never falls below the smallest number.
fn mixed(regular: f64, wide: f64, anywhere: f64, settings: &Settings) -> (f64, f64) {
    let regular = (1.0 - settings.outliers) * regular;
    let outlier = (1.0 - settings.anywhere) * wide + settings.anywhere * anywhere;
    let all = (regular + settings.outliers * outlier).max(f64::MIN_POSITIVE);
    (regular / all, all)
}

/// `Φ(β) − Φ(α)`, from the tail that is smaller.
fn inside(alpha: f64, beta: f64) -> f64 {
    if alpha + beta >= 0.0 {
        normal_upper_tail(alpha) - normal_upper_tail(beta)
    } else {
        normal_upper_tail(-beta) - normal_upper_tail(-alpha)
    }
}

/// A standard normal variable between two bounds.
fn truncated(alpha: f64, beta: f64) -> Truncated {
    /// Beyond so many standard deviations nothing is cut off, to rounding.
    const FAR: f64 = 8.3;
    /// Less probable counts: mean and variance by the first terms of the tail's expansion, right within `1/α²`, 3 %.
    const RARE: f64 = 1e-9;
    if alpha < -FAR && beta > FAR {
        return Truncated { probability: 1.0, shift: 0.0, share: 1.0 };
    }
    let probability = inside(alpha, beta);
    if probability < RARE {
        let near = if alpha + beta >= 0.0 { alpha } else { beta };
        let width = (beta - alpha).min(1.0 / near.abs());
        return Truncated { probability, shift: near + 0.5 * width.copysign(near), share: (width * width).min(1.0) };
    }
    let density = |x: f64| (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let shift = (density(alpha) - density(beta)) / probability;
    let share = 1.0 + (alpha * density(alpha) - beta * density(beta)) / probability - shift * shift;
    Truncated { probability, shift, share: share.clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums over the density.
    #[test]
    fn analytic_moments_of_a_truncated_normal_variable() {
        for (alpha, beta) in [(-1.0_f64, 0.5_f64), (0.7, 1.9), (-3.0, -2.0), (-9.0, 9.0), (4.0, 7.0)] {
            let cells = 200_000;
            let h = (beta - alpha) / f64::from(cells);
            let (mut z, mut first, mut second) = (0.0, 0.0, 0.0);
            for k in 0..cells {
                let x = alpha + (f64::from(k) + 0.5) * h;
                let p = h * (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
                (z, first, second) = (z + p, first + p * x, second + p * x * x);
            }
            let (mean, square) = (first / z, second / z);
            let found = truncated(alpha, beta);
            // The rule's error is h²/24 of the second derivative, 1e-9; sums of 2e5 terms round to 1e-11. The tail loses four digits.
            assert!((found.probability / z - 1.0).abs() < 1e-7, "{alpha} {beta}");
            assert!((found.shift - mean).abs() < 1e-6, "{alpha} {beta}: {} {mean}", found.shift);
            assert!((found.share - (square - mean * mean)).abs() < 1e-5, "{alpha} {beta}");
        }
    }

    #[test]
    fn property_what_all_counts_say_sums_to_one() {
        let (m, p) = (0.013, 4e-4);
        let half = 0.01;
        let count = |k: i32| Read { middle: 2.0 * half * f64::from(k), half, floor: 1e-6, range: 401.0 * 2.0 * half };
        let sum: f64 = (-200..=200).map(|k| count(k).says(m, p, &Settings::default()).nats.exp()).sum();
        // Tails beyond 30 standard deviations of the wide part are left out.
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }
}

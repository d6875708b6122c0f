//! How much repeats scatter in comparison with their stated errors, by all parameters together.
//!
//! The residuals of `n` repeats of a parameter give the ratio `φ = Σ r²/s²/f` of its scatter to the errors stated, with `f = n − 2` degrees of freedom: few.
//! The true ratios `σ²` of all parameters are taken as drawn from one distribution:
//!
//! ```text
//!   f φ/σ² ~ χ²(f),   d₀ φ₀/σ² ~ χ²(d₀)             e = ln φ − ψ(f/2) + ln(f/2)
//!   ψ'(d₀/2) = var e − mean ψ'(f/2)                 ln φ₀ = mean e + ψ(d₀/2) − ln(d₀/2)         (equal ratios: d₀ = ∞)
//!   φ̃ = (d φ₀ + f φ)/(d + f)  with d + f degrees of freedom,  d = min(d₀, f/4)
//! ```
//! Equal ratios thus support each other, and where they differ, each stands for itself. The limit of `d` is for one parameter that scatters more than all
//! others: it does so by chance too little in few repeats, and a large `d` would then believe the others.
//! Reference: G. K. Smyth (2004), Linear models and empirical Bayes methods for assessing differential expression, eqs. 4 to 8.

use crate::distributions::{digamma, inverse_trigamma, trigamma};

/// [1] Least ratio, so that it has a logarithm: of values that were written with few digits.
const LEAST: f64 = 1e-12;
/// [1] Degrees of freedom that the other parameters may add, in those of a parameter itself: the most with which sets of 2 to 18 parameters, one or a third of which
/// scatter three times as much as stated, keep the level (`benches/trend`; with 0.5 it was exceeded by a third).
const FROM_OTHERS: f64 = 0.25;

/// Variance of a parameter's repeats, relative to that stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratio {
    /// `φ` [1] ≥ 0
    pub value: f64,
    /// `f` ≥ 1
    pub freedom: f64,
}

/// The distribution of the ratios of all parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pool(Option<Ratio>);

impl Pool {
    /// Of at least two ratios; a single one has no others.
    pub fn of(ratios: &[Ratio]) -> Self {
        let count = ratios.len() as f64;
        if ratios.len() < 2 {
            return Self(None);
        }
        let mean = |of: &dyn Fn(&Ratio) -> f64| ratios.iter().map(of).sum::<f64>() / count;
        let e = |one: &Ratio| one.value.max(LEAST).ln() - digamma(0.5 * one.freedom) + (0.5 * one.freedom).ln();
        let middle = mean(&e);
        let variance = mean(&|one| (e(one) - middle).powi(2)) * count / (count - 1.0);
        let of_chance = mean(&|one| trigamma(0.5 * one.freedom));
        let (value, freedom) = match variance - of_chance {
            more if more > 0.0 => {
                let half = inverse_trigamma(more);
                ((middle + digamma(half) - half.ln()).exp(), 2.0 * half)
            }
            _ => (middle.exp(), f64::INFINITY),
        };
        Self(Some(Ratio { value, freedom }))
    }

    /// `φ̃` of one of the parameters, and its degrees of freedom.
    pub fn beside(self, own: Ratio) -> Ratio {
        let Some(others) = self.0 else { return own };
        let d = others.freedom.min(FROM_OTHERS * own.freedom);
        let freedom = d + own.freedom;
        Ratio { value: (d * others.value + own.freedom * own.value) / freedom, freedom }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratios(values: &[f64], freedom: f64) -> Vec<Ratio> {
        values.iter().map(|value| Ratio { value: *value, freedom }).collect()
    }

    #[test]
    fn analytic_equal_ratios_support_each_other_as_far_as_they_may() {
        // ln φ of equal ratios has no variance: d₀ = ∞, ln φ₀ = ln φ − ψ(2.5) + ln 2.5.
        let pool = Pool::of(&ratios(&[2.0; 6], 5.0));
        let found = pool.beside(Ratio { value: 2.0, freedom: 5.0 });
        let others = 2.0 * (2.5f64.ln() - digamma(2.5)).exp();
        assert_eq!(found.freedom, 6.25);
        // Rounding.
        assert!((found.value - (1.25 * others + 10.0) / 6.25).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn property_ratios_that_differ_stand_for_themselves() {
        let pool = Pool::of(&ratios(&[1e-4, 1.0, 1e4], 5.0));
        let found = pool.beside(Ratio { value: 3.0, freedom: 5.0 });
        // var e = ln(1e4)² = 85, so d₀/2 = 1/√85 to first order: 0.22 degrees of freedom beside five; the second order is some hundredths of that.
        assert!((found.freedom - 5.22).abs() < 0.01, "{found:?}");
        let alone = Ratio { value: 3.0, freedom: 5.0 };
        assert_eq!(Pool::of(&[alone]).beside(alone), alone);
    }

    #[test]
    fn property_ratios_of_zero_give_finite_values() {
        let zero = Ratio { value: 0.0, freedom: 1.0 };
        let found = Pool::of(&[zero; 3]).beside(zero);
        assert!(found.value.is_finite() && found.freedom.is_finite(), "{found:?}");
    }
}

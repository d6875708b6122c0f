//! The coefficients that are fitted, in one vector: four of each direction, then the centrifugal one.
//!
//! Equation 6: `(F_C, F_S, v_S, F_V)⁺ (F_C, F_S, v_S, F_V)⁻ C_ii`; equation 9: `(a1, b1, a2, b2)⁺ (a1, b1, a2, b2)⁻ C_ii`.

use super::result::LawKind;
use crate::gearhead::{Exponential, FrictionLaw, Lines};

/// Coefficients of a direction.
pub const PER_DIRECTION: usize = 4;
/// Index of `C_ii`.
pub const CENTRIFUGAL: usize = 2 * PER_DIRECTION;
/// Length of the vector.
pub const COUNT: usize = CENTRIFUGAL + 1;

/// The law with these coefficients; `None` where they do not make one.
pub fn of(kind: LawKind, theta: &[f64]) -> Option<FrictionLaw> {
    let half = |k: usize| &theta[k * PER_DIRECTION..(k + 1) * PER_DIRECTION];
    match kind {
        LawKind::Exponential => {
            let law = [0, 1].map(|k| {
                let [coulomb, breakaway, stribeck_velocity, viscous] = [half(k)[0], half(k)[1], half(k)[2], half(k)[3]];
                Exponential { coulomb, breakaway, stribeck_velocity, viscous }
            });
            law.iter()
                .all(|one| one.stribeck_velocity > 0.0 && one.breakaway > 0.0 && one.coulomb > 0.0)
                .then_some(FrictionLaw::Exponential(law))
        }
        LawKind::TwoLines => {
            let law = [0, 1].map(|k| Lines { a1: half(k)[0], b1: half(k)[1], a2: half(k)[2], b2: half(k)[3] });
            law.iter()
                .all(|one| one.a1 > 0.0 && one.b2 > one.b1 && one.switch_velocity() > 0.0)
                .then_some(FrictionLaw::TwoLines(law))
        }
    }
}

/// Sizes over which the residuals are nearly linear, one per coefficient.
pub fn steps(kind: LawKind, theta: &[f64], fastest: f64) -> Vec<f64> {
    let mut steps = vec![0.0; COUNT];
    for k in 0..2 {
        let at = k * PER_DIRECTION;
        let level = theta[at].abs().max(theta[at + 1].abs().min(theta[at].abs() + theta[at + 2].abs()));
        let sizes = match kind {
            LawKind::Exponential => [level, level, theta[at + 2], level / fastest],
            LawKind::TwoLines => [theta[at], theta[at + 1].abs() + theta[at] / fastest, theta[at], theta[at] / fastest],
        };
        steps[at..at + PER_DIRECTION].copy_from_slice(&sizes);
    }
    steps[CENTRIFUGAL] = theta[0].abs() / (fastest * fastest);
    steps
}

//! The scale of the torque that a model computes from a current.
//!
//! A fit takes torque constants at their nominal values, so that every fitted torque is one of the nominal model. The true torque is
//!
//! ```text
//!   τ = f τ̄,  f = 1/(1 − s_K u),  u = V_K z          σ_f² = f⁴ (var(s_K V_K z) + s_K² (1 − |V_K|²))
//! ```
//! with `z` the deviations of the nominal model and `V_K` the row of a joint's torque constant ([`inertial`](super::inertial)). What the
//! directions leave out of `u` is as uncertain as its prior. An amplitude, a stiffness or a level of friction is as uncertain as the scale in
//! which it was measured: of a torque constant known to 5 % it is 5 %, however well rows agree.

use super::problem::Problem;
use super::uncertainty::Uncertainty;
use crate::diagnose::result::Measured;

/// True torque of a joint per torque of the nominal model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueScale {
    /// `f`
    pub factor: f64,
    /// `σ_f`
    pub std_error: f64,
}

impl TorqueScale {
    /// The scale of a joint as the fit found it; 1 where torque constants are exact or a torque was recorded.
    pub fn of(problem: &Problem, joint: usize, uncertainty: &Uncertainty) -> Self {
        let exact = Self { factor: 1.0, std_error: 0.0 };
        let (model, has_current) = (problem.motion.model, problem.motion.joints[joint].has_current);
        let Some((row, u)) = problem.constant(joint).filter(|_| has_current) else { return exact };
        let s = model.constant_accuracy(joint);
        let slopes: Vec<(usize, f64)> =
            row.iter().enumerate().map(|(k, v)| (uncertainty.deviations_at + k, s * v)).collect();
        let unseen = s * (1.0 - row.iter().map(|v| v * v).sum::<f64>()).max(0.0).sqrt();
        let factor = model.torque_factor(joint, u);
        Self { factor, std_error: factor * factor * uncertainty.std_error(&slopes).hypot(unseen) }
    }

    /// A parameter in true torque, where its unit is one of torque or force.
    pub fn correct(&self, measured: &mut Measured) {
        if measured.unit.starts_with('N') {
            let by_scale = measured.value * self.std_error;
            measured.value *= self.factor;
            measured.std_error = (measured.std_error * self.factor).hypot(by_scale);
        }
    }
}

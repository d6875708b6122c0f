//! The motion of a rotor while its current approaches the command, added exactly to a Runge-Kutta step.
//!
//! ```text
//!   i(t) = i_cmd + e r(t),  r = e^{−t/T_i}        of this, e r accelerates the rotor by κ e r, κ = K/J:
//!   u(t) = κ T_i (1 − r)                           velocity per ampere of e
//!   x(t) = κ T_i (t − T_i (1 − r))                 angle per ampere of e
//! ```
//! The four stages would integrate the exponential by Simpson's rule, with an error of `(h/T_i)⁵/2880`: at half a millisecond the
//! largest error of the whole step. What is stored here is the difference between `u`, `x` and the results of the stages.

use crate::drive::PowerStage;

/// The course of one current within a step, per ampere of its distance `e` from the command at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transient {
    /// `r` [1] at half the step and at its end.
    pub remainder: [f64; 2],
    /// [rad/A or m/A] to be added to the angle of the stages 2, 3, 4 and of the end.
    pub theta: [f64; 4],
    /// [rad/s/A or m/s/A] to be added to the velocity there.
    pub omega: [f64; 4],
}

/// For a current that is not a state: there is no transient.
impl Default for Transient {
    fn default() -> Self {
        Self { remainder: [1.0; 2], theta: [0.0; 4], omega: [0.0; 4] }
    }
}

impl Transient {
    /// The transient of a drive on a rotor `J`, in a step of `h` [s].
    pub fn new(power: &PowerStage, rotor_inertia: f64, h: f64) -> Self {
        let Some(time_constant) = power.time_constant() else { return Self::default() };
        let kappa = power.torque_per_ampere / rotor_inertia;
        let half = (-0.5 * h / time_constant).exp();
        let r = [1.0, half, half * half];
        let u = r.map(|r| kappa * time_constant * (1.0 - r));
        let x = |t: f64, u: f64| time_constant * (kappa * t - u);
        let (x_half, x_end) = (x(0.5 * h, u[1]), x(h, u[2]));
        Self {
            remainder: [r[1], r[2]],
            theta: [x_half, x_half - 0.5 * h * u[1], x_end - h * u[1], x_end - h / 6.0 * (4.0 * u[1] + u[2])],
            omega: [
                u[1] - 0.5 * h * kappa,
                u[1] - 0.5 * h * kappa * r[1],
                u[2] - h * kappa * r[1],
                u[2] - h / 6.0 * kappa * (1.0 + 4.0 * r[1] + r[2]),
            ],
        }
    }
}

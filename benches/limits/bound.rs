//! The Cramér-Rao bound of the friction of equation 6 from the steady windows alone.
//!
//! A window of `N` samples within `T` tells the mean friction with the variance of the mean current and that of the mean acceleration, which only
//! the encoder shows: a parabola through `N` positions with white errors `σ_θ` has a second derivative with the variance `720 σ_θ²/(N T⁴)`.
//!
//! ```text
//!   σ² = (n K_t)² (σ_i² + r²/12)/N + J² 720 (Δ²/12)/(N T⁴)
//!   cov ≥ (Σ g gᵀ/σ²)⁻¹,   g = ∂F/∂(F_C, F_S, v_S, F_V) = (1 − e, e, (F_S − F_C) e v/v_S², v),   e = exp(−v/v_S)
//! ```
//! `r` is the resolution of the current, `Δ` a count. A quantisation error is taken as white noise. Accelerated motion tells something too, so that
//! an estimate that uses it can be better than this bound.
//! References: C. R. Rao (1945); A. Savitzky, M. Golay (1964) for the derivative.

use lostmotion::dynamics::Dynamics;
use lostmotion::gearhead::{Exponential, FrictionLaw};
use lostmotion::identify::Point;
use lostmotion::robot::JointModel;
use lostmotion::scenario::Scenario;
use nalgebra::{DMatrix, Matrix4, Vector4};

use crate::settings::JOINTS;

/// Angle of joint 2 while either joint moves [deg], as in the scenario.
const POSTURE: [f64; 2] = [90.0, 130.0];

/// Standard errors of the positive direction's coefficients [%]; `None` where the truth is another law or the windows do not determine it.
pub fn of(scenario: &Scenario, index: usize, points: &[Point]) -> Option<[f64; 4]> {
    let model = scenario.model.joints.iter().find(|joint| joint.name == JOINTS[index])?;
    let FrictionLaw::Exponential([law, _]) = scenario.truth.friction(JOINTS[index])? else { return None };
    let inertia = inertia(scenario, index)? + model.reflected_inertia();
    let mut information = Matrix4::zeros();
    for point in points.iter().filter(|point| point.velocity > 0.0) {
        let g = gradient(&law, point.velocity);
        let time = point.window[1] - point.window[0];
        information += g * g.transpose() / variance(model, scenario.control_period, time, inertia);
    }
    let bound = information.try_inverse()?;
    let truth = [law.coulomb, law.breakaway, law.stribeck_velocity, law.viscous];
    Some([0, 1, 2, 3].map(|k| 100.0 * bound[(k, k)].sqrt() / truth[k]))
}

fn gradient(law: &Exponential, v: f64) -> Vector4<f64> {
    let e = (-v / law.stribeck_velocity).exp();
    Vector4::new(1.0 - e, e, (law.breakaway - law.coulomb) * e * v / law.stribeck_velocity.powi(2), v)
}

fn variance(model: &JointModel, period: f64, time: f64, inertia: f64) -> f64 {
    let samples = time / period;
    let of_sensor = model.current_sensor.as_ref().map(|one| one.noise.powi(2) + one.resolution.powi(2) / 12.0);
    let current = of_sensor.unwrap_or(0.0);
    let angle = model.encoder_step().powi(2) / 12.0;
    (model.torque_per_ampere().powi(2) * current + inertia.powi(2) * 720.0 * angle / time.powi(4)) / samples
}

/// [kg·m²] Inertia of the links about a joint.
fn inertia(scenario: &Scenario, index: usize) -> Option<f64> {
    let mut dynamics = Dynamics::new(&scenario.model.robot);
    let n = dynamics.dof();
    let mut q = vec![0.0; n];
    *q.get_mut(1)? = POSTURE[index].to_radians();
    let mut h = DMatrix::zeros(n, n);
    dynamics.mass_matrix(&q, &mut h);
    Some(h[(index, index)])
}

//! The floor: the error that the sensors alone cause in a row, by current noise and resolution and by quantisation of the encoder.
//!
//! `σ² = (ratio K_t)² (σ_i² + δ_i²/12) g₀ + (H + J)² (δ²/12) g₂ · max(Δt, δ/|v|)/Δt`, `g₀ = Σ value²`, `g₂ = Σ curvature²` of the row's kernel:
//! Current samples are independent; encoder errors are independent once a count has passed.
//! If the model file gives no current sensor, its noise is taken from the recording: the median of third differences.

use crate::diagnose::fit::problem::Problem;
use crate::diagnose::rows::kernel::Kernel;
use crate::diagnose::rows::sampling::Sampling;
use crate::diagnose::rows::signals::motor_torque;
use crate::timeseries::{TimeSeries, white_noise};

/// RMS error of each row, `floor[joint][row]`.
pub fn floor(problem: &Problem, sessions: &[&TimeSeries], inertia: &[f64]) -> Vec<Vec<f64>> {
    let motion = &problem.motion;
    // The mean distance of samples decides how many a kernel averages. It needs all samples: compute it once, not in every row.
    let mean = |session: &&TimeSeries| Sampling::new(&session.time, session.sample_interval()).mean();
    let interval: Vec<f64> = sessions.iter().map(mean).collect();
    let mut floors = Vec::new();
    for (joint, model) in motion.model.joints.iter().enumerate() {
        let count = model.encoder_step();
        let noise: Vec<f64> = (0..sessions.len())
            .map(|session| match model.current_sensor {
                Some(sensor) if motion.joints[joint].has_current => {
                    model.torque_per_ampere() * (sensor.noise.powi(2) + sensor.resolution.powi(2) / 12.0).sqrt()
                }
                _ => {
                    let series = sessions[session].joint(&model.name);
                    let torque = series.and_then(|series| motor_torque(motion.model, joint, series, None));
                    white_noise(&torque.unwrap_or_default().0)
                }
            })
            .collect();
        let mut last: Option<(f64, f64, f64, f64)> = None;
        let row_floor = |row: usize| {
            let session = motion.session[row];
            let dt = interval[session];
            let w = motion.half_width[row];
            let gains = match last {
                Some((width, step, value, curvature)) if width == w && step == dt => (value, curvature),
                _ => {
                    let (value, curvature) = Kernel::new(((w / dt - 0.5).round() as usize).max(1), dt).noise_gain();
                    last = Some((w, dt, value, curvature));
                    (value, curvature)
                }
            };
            let speed = motion.joints[joint].v[row].abs().max(1e-12);
            let encoder = inertia[joint].powi(2) * count * count / 12.0 * gains.1 * (count / speed / dt).max(1.0);
            let widest = (2.0 * w / dt).max(1.0) * inertia[joint].powi(2) * count * count / 12.0 * gains.1;
            (noise[session].powi(2) * gains.0 + encoder.min(widest)).sqrt()
        };
        floors.push((0..motion.rows()).map(row_floor).collect());
    }
    floors
}

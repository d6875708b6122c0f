//! Motion that is too fast for links to follow their rotors.
//!
//! ```text
//!   a_link/a_rotor = 1/(1 − (ω/ω_r)²),   ω_r = √(k/M)        link of inertia M on a gear of stiffness k
//!   K̂(ω w) = 15 j₂(ω w)/(ω w)²                               gain of the kernel of half width w; its first zero is ω w = 5.763
//! ```
//! Rows take the acceleration of a link from its rotor. Around `ω_r` and above, that is wrong by more than itself, and the torque that it
//! leaves is proportional to accelerations, like an error of a mass. Motion that follows a reference is slower. But a ripple or a
//! disturbance may shake a rotor faster than that. Then rows are as wide as `5.763/ω_r`, which leaves at most 4 % of what is faster.
//! Left out: the shape of the resonance below `ω_r`, and that other joints change `M`.

use super::kernel::Kernel;
use super::sampling::Sampling;
use super::widths::NOISE_SHARE;
use crate::timeseries::root_mean_square;

/// `ω w` [1] First zero of the kernel's gain.
const FIRST_ZERO: f64 = 5.763;
/// Samples between those that are looked at: a mean over hundreds does not need all.
const STRIDE: usize = 16;

/// [s] Half width that filters out motion faster than a resonance [rad/s].
pub fn half_width(resonance: f64) -> f64 {
    FIRST_ZERO / resonance
}

/// Whether a joint moves faster than its link can follow: most of the power of its acceleration is in rows of the `narrow` kernel only, not in
/// those of the `wide` one, and with the inertia of the link it is more torque than noise may cause in a row. `edge` [s] is the reach of the
/// widest kernel, `torque` [N·m or N] the RMS torque of the joint.
pub fn is_too_fast(
    position: &[f64],
    sampling: &Sampling,
    [narrow, wide]: [&Kernel; 2],
    edge: f64,
    (link_inertia, torque): (f64, f64),
) -> bool {
    let (mut slow, mut fast) = (Vec::new(), Vec::new());
    for (number, part) in sampling.parts.iter().enumerate() {
        for centre in sampling.inner(part, edge).step_by(STRIDE) {
            let [all, below] =
                [narrow, wide].map(|kernel| sampling.window(kernel, centre, number).averages(position).curvature);
            slow.push(below);
            fast.push(all - below);
        }
    }
    let (slow, fast) = (root_mean_square(&slow), root_mean_square(&fast));
    torque > 0.0 && fast > slow && link_inertia * fast > NOISE_SHARE * torque
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const DT: f64 = 1e-3;
    const RESONANCE: f64 = 20.0 * TAU;

    fn kernel(half_width: f64) -> Kernel {
        Kernel::new((half_width / DT).round() as usize, DT)
    }

    /// `j₂(x)` at the half width is zero, and `15 j₂(x)/x²` beyond it is at least −0.0411, at `x = 6.99`.
    #[test]
    fn closed_form_the_kernel_filters_out_what_is_faster() {
        let kernel = kernel(half_width(RESONANCE));
        let gain = |frequency: f64| {
            let wave: Vec<f64> = (0..401).map(|k| (TAU * frequency * DT * f64::from(k - 200)).cos()).collect();
            kernel.averages(&wave, 200).value
        };
        // Of 46 samples and half a sample, 1.4 % wider than the zero: −0.0057.
        assert!(gain(20.0).abs() < 0.006, "{}", gain(20.0));
        for tenths in 200..2000 {
            let gain = gain(f64::from(tenths) / 10.0);
            assert!(gain.abs() < 0.0412, "{tenths}: {gain}");
        }
    }

    /// A motion of 1 Hz, with and without a wave of 40 Hz that is 0.3 % of its size and five times its acceleration.
    #[test]
    fn property_a_shaken_rotor_is_too_fast_and_a_moving_one_is_not() {
        let time: Vec<f64> = (0..8000).map(|k| f64::from(k) * DT).collect();
        let sampling = Sampling::new(&time, DT);
        let (narrow, wide) = (kernel(0.006), kernel(half_width(RESONANCE)));
        let too_fast = |size: f64, torque: f64| {
            let q: Vec<f64> = time.iter().map(|t| (TAU * t).sin() + size * (40.0 * TAU * t).sin()).collect();
            is_too_fast(&q, &sampling, [&narrow, &wide], 0.1, (1.0, torque))
        };
        assert!(!too_fast(0.0, 30.0));
        assert!(too_fast(0.003, 30.0));
        // No more torque than noise: 0.003 (2π 40)²/√2 = 134 N·m of 15,000 N·m.
        assert!(!too_fast(0.003, 15_000.0));
        // Less acceleration than that of the motion: a wave of 0.05 %.
        assert!(!too_fast(0.0005, 30.0));
    }
}

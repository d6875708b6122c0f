//! How fast the gears of a machine oscillate, or come to rest: what its steps have to resolve.
//!
//! ```text
//!   ẍ + A D ẋ + A K x = 0,  A = J⁻¹ + W          wind-ups x of all gears with all flanks touching
//!   ω² = λ_max(K^½ A K^½)                         links couple the gears: at least the largest k_i A_ii
//!   δ = λ_max(C^½ W C^½)                          links that dampers c_i of their joints bring to rest
//!   δ > ω_max:  M_ii + c_i/ω_max,  so that δ becomes δ/(1 + δ/ω_max) < ω_max
//! ```
//! Files give light links dampers that bring them to rest in less than a microsecond: joint damping of a motor and its gear, on a wheel or a
//! finger. No step follows that, nor does anything depend on it. Such a machine's joints bear an inertia beside their links: the torque
//! `c q̇` of a motion of ω rad/s is then wrong by the share `ω/ω_max`, 1e-3 at 100 rad/s, and at constant speed not at all.
//! Left out: coupling by the dampers of gears; their damping is considered one gear at a time.

use nalgebra::DMatrix;

use super::build::FASTEST;
use super::machine::Machine;

/// How fast the gears of a machine are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fastest {
    /// [rad/s] Fastest oscillation.
    pub oscillation: f64,
    /// [1/s] Fastest decay of gears that come to rest without oscillation.
    pub decay: f64,
}

impl Fastest {
    /// [rad/s] Whichever is faster.
    pub fn pole(&self) -> f64 {
        self.oscillation.max(self.decay)
    }
}

impl Machine {
    /// Fastest motion of the gears at the newest evaluation, and the joint that takes part in it most.
    pub fn fastest(&mut self) -> (usize, Fastest) {
        self.mobility.newest(&mut self.response);
        let Self { coupled, response, .. } = self;
        let laws = &coupled.laws;
        let a = |i: usize, j: usize| response.w(i, j) + if i == j { 1.0 / laws[i].rotor_inertia } else { 0.0 };
        let (mut joint, mut fastest) = (0, Fastest { oscillation: 0.0, decay: 0.0 });
        for (i, law) in laws.iter().enumerate() {
            let (gear, (sigma_0, sigma_1)) = (&law.gearhead.dead_zone, law.bristles());
            let omega_squared = gear.stiffness * a(i, i) + sigma_0 / law.rotor_inertia;
            let delta = 0.5 * (gear.damping * a(i, i) + sigma_1 / law.rotor_inertia);
            let before = fastest.pole();
            if delta * delta > omega_squared {
                fastest.decay = fastest.decay.max(delta + (delta * delta - omega_squared).sqrt());
            } else {
                fastest.oscillation = fastest.oscillation.max(omega_squared.sqrt());
            }
            if fastest.pole() > before || !a(i, i).is_finite() {
                joint = i;
            }
            if !a(i, i).is_finite() {
                fastest.oscillation = f64::INFINITY;
            }
        }
        if fastest.pole().is_finite() {
            let n = laws.len();
            let k = |i: usize| laws[i].gearhead.dead_zone.stiffness;
            let squared = DMatrix::from_fn(n, n, |i, j| (k(i) * k(j)).sqrt() * a(i, j));
            fastest.oscillation = squared.symmetric_eigenvalues().max().max(0.0).sqrt().max(fastest.oscillation);
            fastest.decay = fastest.decay.max(self.fastest_damper());
        }
        (joint, fastest)
    }

    /// `δ` [1/s] of the dampers of joints, under the response found last; 0 without dampers.
    fn fastest_damper(&self) -> f64 {
        let Self { coupled, response, .. } = self;
        let n = coupled.laws.len();
        let c = |i: usize| coupled.laws[i].link_damping;
        let damped = DMatrix::from_fn(n, n, |i, j| (c(i) * c(j)).sqrt() * response.w(i, j));
        let finite = damped.iter().all(|value| value.is_finite());
        if finite { damped.symmetric_eigenvalues().max() } else { 0.0 }
    }

    /// Gives every joint with a damper the inertia `c/ω_max`, where one of them is too fast; returns whether one is.
    pub fn slow_dampers(&mut self) -> bool {
        self.mobility.newest(&mut self.response);
        let too_fast = self.fastest_damper() > FASTEST;
        if too_fast {
            let laws = &self.coupled.laws;
            self.borne.iter_mut().zip(laws).for_each(|(borne, law)| *borne = law.link_damping / FASTEST);
        }
        too_fast
    }
}

//! Reference and state to command.
//!
//! All quantities are on the joint side, SI. `q_d q̇_d q̈_d` is the target from a [`Profile`], `q q̇` the reading of
//! the sensors or of an [`EdgeObserver`], `τ` the torque command to the motors. A [`Controller`] knows neither gear friction nor gap;
//! a [`Compensation`] adds what they take.
//! Rigid-body terms are passed as matrices and vectors.

mod compensation;
mod excitation;
mod independent;
mod observer;
mod pi;
mod profile;
mod sliding_mode;
mod speeds;
mod staircase;
mod torque_wave;

pub use compensation::{Compensation, Feedforward, FrictionCurve, KnownGear};
pub use excitation::{Excitation, JointRange, TooManyMoves};
pub use independent::Independent;
pub use observer::{EdgeObserver, ObserverNoise};
pub use pi::{Pi, PiGains};
pub use profile::{Profile, Target, Track};
pub use sliding_mode::{SlidingGains, SlidingMode, sat};
pub use speeds::{SpeedSequence, SpeedStep};
pub use staircase::{Gentle, Staircase, Steps};
pub use torque_wave::{Shape, TorqueWave};

use nalgebra::DMatrix;

/// The measured motion that a controller uses.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// `q` [rad or m].
    pub q: &'a [f64],
    /// `q̇` [rad/s or m/s].
    pub v: &'a [f64],
}

/// Rigid-body terms of equation 17 at a motion.
#[derive(Debug, Clone, Copy)]
pub struct Terms<'a> {
    /// `H(q)`, rotors included.
    pub h: &'a DMatrix<f64>,
    /// `C(q, q̇)` with `Ḣ − 2 C` skew-symmetric.
    pub c: &'a DMatrix<f64>,
    /// `G(q)` [N·m or N].
    pub g: &'a [f64],
}

/// A law from reference and motion to the motors' torques on the joint side.
pub trait Controller: Send {
    /// Writes `τ` [N·m or N], one per joint.
    fn torque(&mut self, target: &[Target], motion: Motion, terms: &Terms, tau: &mut [f64]);
}

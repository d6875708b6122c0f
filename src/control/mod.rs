//! Reference and state to command.
//!
//! All on the joint side, SI. `q_d q̇_d q̈_d` is what a [`Profile`] wants, `q q̇` what the sensors or an [`EdgeObserver`] say,
//! `τ` what the motors are to drive with, friction of the gears not known. Rigid-body terms come in as matrices and vectors.

mod excitation;
mod observer;
mod pi;
mod profile;
mod sliding_mode;
mod staircase;

pub use excitation::{Excitation, JointRange, TooManyMoves};
pub use observer::{EdgeObserver, ObserverNoise};
pub use pi::{Pi, PiGains};
pub use profile::{Profile, Target, Track};
pub use sliding_mode::{SlidingGains, SlidingMode, sat};
pub use staircase::{Gentle, Staircase, Steps};

use nalgebra::DMatrix;

/// How a machine moves: what it is controlled by.
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
    /// Writes `τ` [N·m or N], one a joint.
    fn torque(&mut self, target: &[Target], motion: Motion, terms: &Terms, tau: &mut [f64]);
}

//! What keeps a replayed machine beside its recording.
//!
//! ```text
//!   τ(k) = τ_rec(k) + c(q_rec, k) − c(q_sim, k)          c(q, k) = −k_v (k_p q(k) + (q(k) − q(k−n))/(n T))
//! ```
//! Where `c` is the machine's own controller (the manifest gives it), this **is** its closed loop: reference, pulses and
//! feedforward stand in `τ_rec − c(q_rec)`, whatever they are, and the noise of the recorded position cancels.
//! Else `c` is a tracking controller of a given bandwidth `ω` on the inertia `J` that the joint moves, both poles at `ω`:
//! `k_v = 2 ω J`, `k_p = ω/2`, along the recorded motion after a low-pass.

use nalgebra::DMatrix;

use super::inputs::Input;
use super::low_pass::low_pass;
use crate::dataset::{Controller, Session};
use crate::dynamics::Dynamics;
use crate::effects::JointState;
use crate::robot::Model;

/// One feedback a joint: the machine's own where the session gives it.
pub(super) fn of_joints(model: &Model, session: &Session, inputs: &[Input], bandwidth: f64) -> Vec<Feedback> {
    let interval = session.series.sample_interval();
    let start: Vec<f64> = inputs.iter().map(|input| input.position[0]).collect();
    let mut mass = DMatrix::zeros(model.robot.dof(), model.robot.dof());
    Dynamics::new(&model.robot).mass_matrix(&start, &mut mass);
    let own = |name: &str| {
        let index = session.series.joints.iter().position(|joint| joint.name == name)?;
        session.controllers.get(index).copied().flatten()
    };
    let joints = model.joints.iter().zip(inputs).enumerate();
    let feedback = joints.map(|(i, (joint, input))| match own(&joint.name) {
        Some(controller) => Feedback::machine(controller, &input.position, interval),
        None => {
            let inertia = joint.reflected_inertia() + mass[(i, i)];
            Feedback::tracking(&input.position, interval, bandwidth, inertia)
        }
    });
    feedback.collect()
}

/// The correction of one joint.
#[derive(Debug)]
pub(super) struct Feedback {
    controller: Controller,
    interval: f64,
    recorded: Vec<f64>,
    simulated: Vec<f64>,
}

impl Feedback {
    /// The machine's own controller on the recorded positions as they are.
    pub(super) fn machine(controller: Controller, recorded: &[f64], interval: f64) -> Self {
        Self { controller, interval, recorded: recorded.to_vec(), simulated: Vec::with_capacity(recorded.len()) }
    }

    /// A tracking controller of bandwidth `bandwidth` [Hz] for an inertia [kg·m² or kg].
    pub(super) fn tracking(recorded: &[f64], interval: f64, bandwidth: f64, inertia: f64) -> Self {
        /// Cut-off of the recorded motion against the bandwidth of the loop.
        const MARGIN: f64 = 5.0;
        let omega = 2.0 * std::f64::consts::PI * bandwidth;
        let controller =
            Controller { position_gain: omega / 2.0, velocity_gain: 2.0 * omega * inertia, velocity_samples: 1 };
        Self::machine(controller, &low_pass(recorded, interval, MARGIN * bandwidth), interval)
    }

    /// The motion that the recording begins with, the link in the middle of the gap.
    pub(super) fn start(&self) -> JointState {
        let last = self.controller.velocity_samples.min(self.recorded.len() - 1);
        let velocity = (self.recorded[last] - self.recorded[0]) / (last.max(1) as f64 * self.interval);
        let position = self.recorded[0];
        JointState {
            motor_position: position,
            motor_velocity: velocity,
            link_position: position,
            link_velocity: velocity,
            ..JointState::default()
        }
    }

    /// `c(q_rec, k) − c(q_sim, k)` [N·m or N] at the next sample `k`, where the simulated position is `position`.
    pub(super) fn correction(&mut self, position: f64) -> f64 {
        self.simulated.push(position);
        let Controller { position_gain, velocity_gain, velocity_samples } = self.controller;
        let k = self.simulated.len() - 1;
        let before = k.saturating_sub(velocity_samples);
        let behind = |at: usize| self.recorded[at] - self.simulated[at];
        let rate = (behind(k) - behind(before)) / (velocity_samples as f64 * self.interval);
        velocity_gain * (position_gain * behind(k) + rate)
    }
}

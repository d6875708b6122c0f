//! The machine's controller: readings and targets in, command currents out.
//!
//! ```text
//!   reading ──► q, q̇ (sensor or observer) ──► q̇ held within q̇_d ± limit ──► law ──► τ ──► i = τ / (ratio K_t)
//!                                              H + rotors, C, G at (q, q̇) ──┘
//! ```
//! The limit on the velocity error is for the gap: there the rotor is alone and has a hundredth of the inertia that the
//! gains are tuned for, and the law would throw it back for an error of a few counts. If no limit is given it is
//! infinite, and the law is equation 18.

use nalgebra::DMatrix;

use super::known_gears::KnownGears;
use crate::control::{
    Controller, EdgeObserver, Feedforward, Independent, Motion, ObserverNoise, Pi, PiGains, SlidingGains, SlidingMode,
    Target, Terms,
};
use crate::dynamics::Dynamics;
use crate::effects::Reading;
use crate::robot::Model;

/// Source of the velocity of a joint's controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Feedback {
    /// The velocity sensor, with the position read from the encoder.
    Sensor,
    /// An observer on the encoder's edges and the commanded torque.
    Observer(ObserverNoise),
}

/// The control law, with gains per joint.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// Equations 16 to 18.
    SlidingMode(Vec<SlidingGains>),
    /// Independent feedback of each joint.
    Independent(Vec<SlidingGains>),
    /// Proportional-integral.
    Pi(Vec<PiGains>),
}

/// A controller's settings.
#[derive(Debug, Clone, PartialEq)]
pub struct ControllerSettings {
    /// The law.
    pub law: Law,
    /// Velocity sources, one per joint.
    pub feedback: Vec<Feedback>,
    /// [rad/s or m/s] Largest velocity error passed to the law, > 0, one per joint.
    pub velocity_error_limit: Vec<f64>,
}

/// A running controller.
pub struct Regulator {
    controller: Box<dyn Controller>,
    feedback: Vec<Feedback>,
    limit: Vec<f64>,
    observers: Vec<Option<EdgeObserver>>,
    dynamics: Dynamics,
    /// Per joint: `ratio K_t` [N·m/A or N/A], reflected rotor inertia, encoder count, largest current [A].
    drives: Vec<Drive>,
    q: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
    commands: Vec<f64>,
    h: DMatrix<f64>,
    c: DMatrix<f64>,
    g: Vec<f64>,
    /// [N·m·s/rad or N·s/m] Damping of joints whose torque at the planned velocity is fed forward.
    damping: Vec<f64>,
    gears: KnownGears,
    period: f64,
}

#[derive(Debug, Clone, Copy)]
struct Drive {
    torque_per_ampere: f64,
    reflected_inertia: f64,
    count: f64,
    current_limit: f64,
}

impl Regulator {
    /// The controller of a machine, called every `period` [s]. It uses the rigid body and the drives of the model, but
    /// neither friction nor gap.
    pub fn new(model: &Model, settings: &ControllerSettings, period: f64) -> Self {
        let n = model.joints.len();
        let controller: Box<dyn Controller> = match &settings.law {
            Law::SlidingMode(gains) => Box::new(SlidingMode::new(gains.clone())),
            Law::Independent(gains) => Box::new(Independent::new(gains.clone())),
            Law::Pi(gains) => Box::new(Pi::new(gains.clone())),
        };
        let drive = |joint: &crate::robot::JointModel| Drive {
            torque_per_ampere: joint.torque_per_ampere(),
            reflected_inertia: joint.reflected_inertia(),
            count: joint.encoder_step(),
            current_limit: joint.amplifier.current_limit,
        };
        let zero = vec![0.0; n];
        Self {
            controller,
            feedback: settings.feedback.clone(),
            limit: settings.velocity_error_limit.clone(),
            observers: vec![None; n],
            dynamics: Dynamics::new(&model.robot),
            drives: model.joints.iter().map(drive).collect(),
            q: zero.clone(),
            v: zero.clone(),
            tau: zero.clone(),
            commands: zero.clone(),
            h: DMatrix::zeros(n, n),
            c: DMatrix::zeros(n, n),
            g: zero.clone(),
            damping: zero,
            gears: KnownGears::none(n),
            period,
        }
    }

    /// From now on commands the torque `c q̇_d` beside that of the controller.
    pub fn feed_damping_forward(&mut self, damping: Vec<f64>) {
        self.damping = damping;
    }

    /// From now on compensates friction and gaps as this model of the same machine has them, and crosses each gap in a time [s] > 0. Joints
    /// without friction in the model are left alone.
    pub fn compensate(&mut self, known: &Model, crossing_time: f64) {
        self.gears = KnownGears::of(known, crossing_time);
    }

    /// Command currents [A] for the present readings and targets. A torque that is imposed takes the place of the controller's.
    pub fn command(&mut self, readings: &[Reading], targets: &[Target]) -> &[f64] {
        self.gears.advance(targets, &mut self.dynamics, self.period);
        self.observe(readings);
        self.dynamics.mass_matrix(&self.q, &mut self.h);
        self.dynamics.coriolis_matrix(&self.q, &self.v, &mut self.c);
        self.dynamics.gravity(&self.q, &mut self.g);
        for (i, drive) in self.drives.iter().enumerate() {
            self.h[(i, i)] += drive.reflected_inertia;
            let error = (self.v[i] - targets[i].velocity).clamp(-self.limit[i], self.limit[i]);
            self.v[i] = targets[i].velocity + error;
        }
        let terms = Terms { h: &self.h, c: &self.c, g: &self.g };
        self.controller.torque(targets, Motion { q: &self.q, v: &self.v }, &terms, &mut self.tau);
        for (i, drive) in self.drives.iter().enumerate() {
            let controlled = self.tau[i] + self.damping[i] * targets[i].velocity + self.gears.now(i).torque;
            let current = targets[i].torque.unwrap_or(controlled) / drive.torque_per_ampere;
            self.commands[i] = current.clamp(-drive.current_limit, drive.current_limit);
        }
        &self.commands
    }

    /// Position and velocity of every joint. With a compensation they are those of the link as far as the motor knows them: without the
    /// motor's lead through the gap. `before` is what the compensations added to the last command.
    fn observe(&mut self, readings: &[Reading]) {
        for (i, reading) in readings.iter().enumerate() {
            let drive = self.drives[i];
            let (before, Feedforward { shift, shift_velocity, .. }) = (self.gears.before(i), self.gears.now(i));
            (self.q[i], self.v[i]) = match self.feedback[i] {
                Feedback::Observer(noise) if drive.count > 0.0 => {
                    let observer = self.observers[i]
                        .get_or_insert_with(|| EdgeObserver::new(drive.count, noise, reading.position));
                    // What is known is not for the observer: gravity, compensated friction, the motor's lead through the gap.
                    let tau = drive.torque_per_ampere * self.commands[i] - self.g[i] - before.torque;
                    observer.displace(shift - before.shift);
                    let inertia = self.h[(i, i)];
                    if inertia > 0.0 {
                        observer.update(reading.position, tau, inertia, self.period);
                    }
                    (observer.position() - shift, observer.velocity())
                }
                _ => (reading.position - shift, reading.velocity - shift_velocity),
            };
        }
    }
}

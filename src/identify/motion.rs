//! The motion between encoder edges, reconstructed, and equation 11 averaged over it.
//!
//! At low speed a joint with falling friction does not move evenly: it creeps, sticks and slips between two edges of its encoder, and
//! the average torque is not the friction at the average velocity. So the averages of equation 11 are taken over the motion itself:
//!
//! ```text
//!   J θ̈ = τ − T − F_r(θ̇)      H_ii q̈ = T − G − C_ii q̇² − F_l(q̇)      T: dead zone of the gear
//!   residual = (1/t) Σ J δθ̇
//! ```
//!
//! Rotor and link follow the measured torque; every encoder edge corrects position and velocity with the gain of a Kalman filter, and a
//! position that leaves the count that was read is held back. The momentum `J δθ̇` of all corrections of a window, over its time, is the
//! torque that the friction law lacks there: zero on average for the true law, whatever the motion was, standstill included.

use super::rigid_body::RigidBody;
use super::signals::Signals;
use super::windows::Window;
use crate::gearhead::{DeadZone, Direction, Friction};
use crate::robot::JointModel;

/// [s] Longest step of the mechanics.
const STEP: f64 = 2e-4;
/// [s] Motion before a window in which the filter settles.
const LEAD: f64 = 0.25;
/// Standard deviation of what the model's torque lacks from sample to sample, as a part of the torque.
const MODEL_ERROR: f64 = 0.05;
/// Residuals of a window, averages over its parts.
pub const PARTS: usize = 16;

/// One window with what does not depend on the friction law.
#[derive(Debug, Clone)]
pub struct Track {
    /// [s] sample interval.
    interval: f64,
    /// [N·m or N] motor torque, one a sample, lead-in first.
    torque: Vec<f64>,
    /// [N·m or N] gravity on the link, one a sample.
    gravity: Vec<f64>,
    /// [rad or m] encoder readings.
    position: Vec<f64>,
    /// Samples of the lead-in.
    lead: usize,
    /// [rad/s or m/s] velocity at the start of the lead-in.
    start_velocity: f64,
    /// `H_ii` [kg·m² or kg] of the link over the window.
    link: f64,
    /// `J` [kg·m² or kg] rotor on the joint side.
    rotor: f64,
    /// Size of a count [rad or m].
    count: f64,
    /// Variance of the torque's noise [N²·m² or N²].
    noise_variance: f64,
    /// Variance of what the model's torque lacks in one sample, noise included [N²·m² or N²].
    torque_variance: f64,
    /// Gear without its gap.
    gear: DeadZone,
}

impl Track {
    /// The track of a window.
    pub fn of(signals: &Signals, rigid: &RigidBody, joint: &JointModel, window: Window) -> Self {
        let lead = ((LEAD / signals.interval) as usize).min(window.start);
        let from = window.start - lead;
        let samples = from..window.end + 1;
        let gravity = rigid.gravity_along(samples.clone());
        let torque = signals.torque[samples.clone()].to_vec();
        let position = signals.position[samples].to_vec();
        let head = (lead / 2).max(1).min(position.len() - 1);
        let level = torque.iter().sum::<f64>() / torque.len() as f64;
        Self {
            interval: signals.interval,
            start_velocity: (position[head] - position[0]) / (head as f64 * signals.interval),
            noise_variance: signals.torque_noise.powi(2),
            torque_variance: signals.torque_noise.powi(2) + (MODEL_ERROR * level).powi(2),
            torque,
            gravity,
            position,
            lead,
            link: rigid.link_inertia(window),
            rotor: joint.reflected_inertia(),
            count: signals.count,
            gear: DeadZone {
                backlash: joint.backlash.unwrap_or(0.0),
                stiffness: joint.gear_stiffness,
                damping: joint.gear_damping,
            },
        }
    }

    /// Standard error of the mean torque by the sensor's noise alone [N·m or N].
    pub fn mean_torque_error(&self) -> f64 {
        (self.noise_variance / (self.position.len() - self.lead) as f64).sqrt()
    }

    /// Mean torque that the law lacks over each of [`PARTS`] parts of the window [N·m or N], positive drives positively.
    pub fn lacking(&self, friction: &Friction, centrifugal: f64) -> [f64; PARTS] {
        let mut state = State::start(self);
        let samples = self.position.len() - 1;
        let (mut momentum, mut parts) = (0.0, [0.0; PARTS]);
        let mut part = 0;
        let window = samples - self.lead;
        for k in 0..samples {
            state.advance(self, k, friction, centrifugal);
            let correction = state.correct(self, self.position[k], self.position[k + 1]);
            if k >= self.lead {
                momentum += correction;
                if (k + 1 - self.lead) * PARTS >= (part + 1) * window {
                    parts[part] = momentum;
                    momentum = 0.0;
                    part += 1;
                }
            }
        }
        let time = window as f64 * self.interval / PARTS as f64;
        parts.map(|momentum| momentum / time)
    }
}

/// Rotor, link and the filter's covariance of the rotor's position and velocity.
#[derive(Debug, Clone, Copy)]
struct State {
    theta: f64,
    omega: f64,
    q: f64,
    q_dot: f64,
    in_contact: bool,
    p00: f64,
    p01: f64,
    p11: f64,
}

impl State {
    /// In contact, in the middle of its count, at the velocity of the lead-in.
    fn start(track: &Track) -> Self {
        let omega = track.start_velocity;
        let theta = track.position[0] + 0.5 * track.count;
        let q = theta - 0.5 * track.gear.backlash * omega.signum();
        let p00 = track.count * track.count / 12.0;
        Self { theta, omega, q, q_dot: omega, in_contact: true, p00, p01: 0.0, p11: omega * omega }
    }

    /// Over one sample interval, with the mean of the torques read at both of its ends.
    fn advance(&mut self, track: &Track, sample: usize, friction: &Friction, centrifugal: f64) {
        let torque = 0.5 * (track.torque[sample] + track.torque[sample + 1]);
        let weight = track.gravity[sample];
        let substeps = (track.interval / STEP).ceil().max(1.0);
        let dt = track.interval / substeps;
        let before = self.omega;
        for _ in 0..substeps as usize {
            let gear = track.gear.torque(self.theta - self.q, self.omega - self.q_dot);
            self.in_contact = gear != 0.0;
            self.omega = slide(self.omega, torque - gear, track.rotor, dt, friction, 1.0 - friction.link_share);
            let load = gear - weight - centrifugal * self.q_dot * self.q_dot;
            self.q_dot = slide(self.q_dot, load, track.link, dt, friction, friction.link_share);
            self.theta += dt * self.omega;
            self.q += dt * self.q_dot;
        }
        self.spread(track, friction, before);
    }

    /// Covariance over one sample interval.
    fn spread(&mut self, track: &Track, friction: &Friction, before: f64) {
        let dt = track.interval;
        let inertia = self.inertia(track);
        let speed = before.abs();
        let small = 0.05 * speed + 1e-6;
        let direction = Direction::of(before);
        let slope = (friction.law.magnitude(direction, speed + small)
            - friction.law.magnitude(direction, (speed - small).max(0.0)))
            / (speed + small - (speed - small).max(0.0));
        let growth = (-slope * dt / inertia).clamp(-0.5, 0.5).exp();
        let noise = track.torque_variance * (dt / inertia).powi(2);
        self.p00 += dt * (2.0 * self.p01 + dt * self.p11);
        self.p01 = growth * (self.p01 + dt * self.p11);
        self.p11 = growth * growth * self.p11 + noise;
    }

    /// What moves with the rotor.
    fn inertia(&self, track: &Track) -> f64 {
        if self.in_contact { track.rotor + track.link } else { track.rotor }
    }

    /// Takes the new reading in; returns the momentum of the correction [N·m·s or N·s].
    fn correct(&mut self, track: &Track, before: f64, now: f64) -> f64 {
        let dt = track.interval;
        let (low, high) = (now, now + track.count);
        let (innovation, variance) = if now == before {
            let held = self.theta.clamp(low, high);
            if held == self.theta {
                return 0.0;
            }
            (held - self.theta, (0.02 * track.count).powi(2))
        } else {
            let boundary = if now > before { low } else { high };
            let speed = self.omega.abs();
            let travel = (0.5 * speed * dt).min(0.5 * track.count).copysign(now - before);
            (boundary + travel - self.theta, (speed * dt).powi(2) / 12.0 + (0.005 * track.count).powi(2))
        };
        let total = self.p00 + variance;
        let (k0, k1) = (self.p00 / total, self.p01 / total);
        let (delta_theta, delta_omega) = (k0 * innovation, k1 * innovation);
        self.theta += delta_theta;
        self.omega += delta_omega;
        if self.in_contact {
            self.q += delta_theta;
            self.q_dot += delta_omega;
        }
        self.p11 -= k1 * self.p01;
        self.p01 *= 1.0 - k0;
        self.p00 *= 1.0 - k0;
        self.inertia(track) * delta_omega
    }
}

/// Velocity of one mass after a step under its share of the dry friction, which holds it where it can stop it within the step.
fn slide(velocity: f64, torque: f64, inertia: f64, dt: f64, friction: &Friction, share: f64) -> f64 {
    let free = velocity + dt * torque / inertia;
    let speed = if velocity * free > 0.0 { velocity.abs() } else { 0.0 };
    let drop = dt * share * friction.law.magnitude(Direction::of(free), speed) / inertia;
    if free.abs() <= drop { 0.0 } else { free - drop.copysign(free) }
}

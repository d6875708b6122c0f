//! The motion between encoder edges, reconstructed, and equation 11 averaged over it.
//!
//! At low speed a joint with falling friction does not move evenly: it creeps, sticks and slips between two edges of its encoder, and
//! the average torque is not the friction at the average velocity. So the averages of equation 11 are taken over the motion itself:
//!
//! ```text
//!   (J + H_ii) θ̈ = τ − G − C_ii θ̇² − F(θ̇)          residual = (1/t) Σ (J + H_ii) δθ̇
//! ```
//!
//! Rotor and link, as one mass, follow the measured torque; every encoder edge corrects position and velocity with the gain of a Kalman
//! filter, and a position that leaves the count that was read is held back. The momentum of all corrections over a stretch of time is the
//! torque that the friction law lacks there: zero on average for the true law, whatever the motion was, standstill included.
//! Left out: the gap. While a rotor has lost its link the balance does not hold, and `balance` drops such parts of a window.

use std::ops::Range;

use super::rigid_body::RigidBody;
use super::signals::Signals;
use super::statistics::median;
use super::windows::Window;
use crate::gearhead::{Direction, FrictionLaw};

/// [s] Longest step of the mechanics.
const STEP: f64 = 1e-3;
/// Speed on top of a twentieth [rad/s or m/s] over which the slope of friction is taken.
const SLOPE_SPEED: f64 = 1e-6;
/// [s] Motion before a window in which the filter settles.
const LEAD: f64 = 0.25;
/// Standard deviation of what the model's torque lacks from sample to sample, as a part of the torque.
const MODEL_ERROR: f64 = 0.05;
/// The same once the law is nearly right and the motion is one of rotor and link together.
const SMALL_MODEL_ERROR: f64 = 0.005;
/// Standard deviation of an edge's position in counts.
const EDGE: f64 = 0.005;
/// Part of a count by which a predicted position may leave the count that is read before it is held back.
const HELD: f64 = 0.1;
/// Standard deviation of the constant torque that a law may lack, before it is known, as a part of the torque.
const FIRST_ERROR: f64 = 0.1;
/// Part of the velocity that is forgotten where the lacking torque opens: what the law lacked before does not count.
const RELEASED_SPEED: f64 = 0.05;
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
    /// `J + H_ii` [kg·m² or kg] over the window.
    inertia: f64,
    /// Size of a count [rad or m].
    count: f64,
    /// Variance of the torque's noise [N²·m² or N²].
    noise_variance: f64,
    /// Variance of what the model's torque lacks in one sample, noise included [N²·m² or N²].
    torque_variance: f64,
}

impl Track {
    /// The track of a window.
    pub fn of(signals: &Signals, rigid: &RigidBody, window: Window) -> Self {
        let lead = ((LEAD / signals.interval) as usize).min(window.start);
        let from = window.start - lead;
        let samples = from..window.end + 1;
        let gravity = rigid.gravity_along(samples.clone());
        let torque = signals.torque[samples.clone()].to_vec();
        let position = signals.position[samples].to_vec();
        let head = (lead / 2).max(1).min(position.len() - 1);
        let level = torque.iter().sum::<f64>() / torque.len() as f64;
        let noise_variance = signals.torque_noise.powi(2).max(white_noise(&torque).powi(2)).max((1e-4 * level).powi(2));
        Self {
            interval: signals.interval,
            start_velocity: (position[head] - position[0]) / (head as f64 * signals.interval),
            noise_variance,
            torque_variance: noise_variance + (MODEL_ERROR * level).powi(2),
            torque,
            gravity,
            position,
            lead,
            inertia: rigid.inertia(window),
            count: signals.count,
        }
    }

    /// Standard error of the mean torque by the sensor's noise alone [N·m or N].
    pub fn mean_torque_error(&self) -> f64 {
        (self.noise_variance / (self.position.len() - self.lead) as f64).sqrt()
    }

    /// First sample of a part of the window.
    fn part_start(&self, part: usize) -> usize {
        self.lead + part * (self.position.len() - 1 - self.lead) / PARTS
    }

    /// Constant torque that the law lacks over some parts of the window and its standard error [N·m or N]: the filter's third state,
    /// which opens when the first of these parts begins.
    pub fn lacking_over(&self, parts: &Range<usize>, law: &FrictionLaw, centrifugal: f64) -> (f64, f64) {
        let (first, last) = (self.part_start(parts.start), self.part_start(parts.end));
        let mut state = State::start(self);
        for k in 0..first {
            state.advance(self, k, law, centrifugal);
            state.correct(self, self.position[k], self.position[k + 1]);
        }
        state.release(self);
        for k in first..last {
            state.advance(self, k, law, centrifugal);
            state.correct(self, self.position[k], self.position[k + 1]);
        }
        (state.lacking, state.p22.sqrt() * state.surprise())
    }

    /// Mean torque that the law lacks over each of [`PARTS`] parts of the window [N·m or N], positive drives positively.
    pub fn lacking(&self, law: &FrictionLaw, centrifugal: f64) -> [f64; PARTS] {
        let mut state = State::start(self);
        let samples = self.position.len() - 1;
        let (mut momentum, mut parts) = (0.0, [0.0; PARTS]);
        let mut part = 0;
        let window = samples - self.lead;
        for k in 0..samples {
            state.advance(self, k, law, centrifugal);
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

/// Position and velocity, and their covariance.
#[derive(Debug, Clone, Copy)]
struct State {
    theta: f64,
    omega: f64,
    lacking: f64,
    p00: f64,
    p01: f64,
    p11: f64,
    p02: f64,
    p12: f64,
    p22: f64,
    noise: f64,
    /// Sum of the squared innovations of the edges over their variance, and their number.
    innovations: (f64, f64),
}

impl State {
    /// In the middle of its count, at the velocity of the lead-in.
    fn start(track: &Track) -> Self {
        let omega = track.start_velocity;
        let theta = track.position[0] + 0.5 * track.count;
        let p00 = track.count * track.count / 12.0;
        let noise = track.torque_variance;
        Self {
            theta,
            omega,
            lacking: 0.0,
            p00,
            p01: 0.0,
            p11: omega * omega,
            p02: 0.0,
            p12: 0.0,
            p22: 0.0,
            noise,
            innovations: (0.0, 0.0),
        }
    }

    /// From here on the lacking torque is a state, and the model is trusted.
    fn release(&mut self, track: &Track) {
        let level = track.torque.iter().map(|torque| torque.abs()).sum::<f64>() / track.torque.len() as f64;
        (self.p02, self.p12, self.p22) = (0.0, 0.0, (FIRST_ERROR * level).powi(2));
        self.p11 += (RELEASED_SPEED * self.omega).powi(2);
        self.noise = track.noise_variance + (SMALL_MODEL_ERROR * level).powi(2);
        self.innovations = (0.0, 0.0);
    }

    /// Over one sample interval, with the mean of the torques read at both of its ends.
    fn advance(&mut self, track: &Track, sample: usize, law: &FrictionLaw, centrifugal: f64) {
        let torque = 0.5 * (track.torque[sample] + track.torque[sample + 1])
            - 0.5 * (track.gravity[sample] + track.gravity[sample + 1])
            + self.lacking;
        let substeps = (track.interval / STEP - 1e-9).ceil().max(1.0);
        let dt = track.interval / substeps;
        let before = self.omega;
        for _ in 0..substeps as usize {
            let net = torque - centrifugal * self.omega * self.omega;
            let omega = slide(self.omega, net, track.inertia, dt, law);
            self.theta += 0.5 * dt * (self.omega + omega);
            self.omega = omega;
        }
        self.spread(track, law, before);
    }

    /// Covariance over one sample interval.
    fn spread(&mut self, track: &Track, law: &FrictionLaw, before: f64) {
        let dt = track.interval;
        let direction = Direction::of(before);
        let (low, high) = (0.95 * before.abs(), 1.05 * before.abs() + SLOPE_SPEED);
        let slope = (law.magnitude(direction, high) - law.magnitude(direction, low)) / (high - low);
        let growth = (-slope * dt / track.inertia).clamp(-0.5, 0.5).exp();
        let push = dt / track.inertia;
        self.p00 += dt * (2.0 * self.p01 + dt * self.p11);
        self.p01 = growth * (self.p01 + dt * self.p11) + push * (self.p02 + dt * self.p12);
        self.p02 += dt * self.p12;
        self.p11 = growth * growth * self.p11 + push * (2.0 * growth * self.p12 + push * (self.p22 + self.noise));
        self.p12 = growth * self.p12 + push * self.p22;
    }

    /// Factor by which the innovations are larger than the filter expects, at least 1.
    fn surprise(&self) -> f64 {
        let (sum, count) = self.innovations;
        (sum / count.max(1.0)).sqrt().max(1.0)
    }

    /// Takes the new reading in; returns the momentum of the correction [N·m·s or N·s].
    fn correct(&mut self, track: &Track, before: f64, now: f64) -> f64 {
        let dt = track.interval;
        let (low, high) = (now, now + track.count);
        let (innovation, variance) = if now == before {
            let slack = (HELD * track.count).max(2.0 * self.p00.sqrt()).min(0.5 * track.count);
            let held = self.theta.clamp(low - slack, high + slack);
            if held == self.theta {
                return 0.0;
            }
            (held - self.theta, (HELD * track.count).powi(2))
        } else {
            let boundary = if now > before { low } else { high };
            let speed = self.omega.abs();
            let travel = (0.5 * speed * dt).min(0.5 * track.count).copysign(now - before);
            (boundary + travel - self.theta, (speed * dt).powi(2) / 12.0 + (EDGE * track.count).powi(2))
        };
        let total = self.p00 + variance;
        self.innovations.0 += innovation * innovation / total;
        self.innovations.1 += 1.0;
        let [k0, k1, k2] = [self.p00, self.p01, self.p02].map(|p| p / total);
        let delta_omega = k1 * innovation;
        self.theta += k0 * innovation;
        self.omega += delta_omega;
        self.lacking += k2 * innovation;
        self.p22 -= k2 * self.p02;
        self.p12 -= k2 * self.p01;
        self.p11 -= k1 * self.p01;
        self.p02 *= 1.0 - k0;
        self.p01 *= 1.0 - k0;
        self.p00 *= 1.0 - k0;
        track.inertia * delta_omega
    }
}

/// Velocity after a step under dry friction, which holds the mass where it can stop it within the step; friction at the mean speed.
fn slide(velocity: f64, torque: f64, inertia: f64, dt: f64, law: &FrictionLaw) -> f64 {
    let free = velocity + dt * torque / inertia;
    let direction = Direction::of(free);
    let pass = |speed: f64| {
        let drop = dt * law.magnitude(direction, speed) / inertia;
        if free.abs() <= drop { 0.0 } else { free - drop.copysign(free) }
    };
    let first = pass(if velocity * free > 0.0 { velocity.abs() } else { 0.0 });
    if first == 0.0 || velocity * first <= 0.0 { first } else { pass(0.5 * (velocity + first).abs()) }
}

/// Standard deviation of the white noise of a signal that is smooth otherwise, from the median of its second differences.
fn white_noise(signal: &[f64]) -> f64 {
    let seconds = signal.windows(3).map(|x| (x[0] - 2.0 * x[1] + x[2]).abs()).collect();
    1.4826 * median(seconds).max(0.0) / 6f64.sqrt()
}

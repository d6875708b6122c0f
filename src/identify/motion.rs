//! Reconstructs the motion between encoder edges, and averages equation 11 over it.
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
//!
//! The encoder shows the rotor, which is ahead of that mass by the wind-up `δ` of a gear whose stiffness `k` and damping `d` are known:
//!
//! ```text
//!   θ_m = θ + (H_ii/(J + H_ii)) δ      k δ + d δ̇ = s F + H_ii θ̈        s: share of friction on the link
//! ```
//! Without it a joint of 2 kg·m² that swings at 2 Hz behind a gear of 2000 N·m/rad would seem to have 0.2 % less friction.
//! Left out: the gap. While a rotor has lost contact with its link, the balance is not valid, and `balance` drops such parts of a window.

use std::ops::Range;

use super::rigid_body::RigidBody;
use super::signals::Signals;
use super::statistics::typical;
use super::windows::Window;
use crate::gearhead::{Direction, FrictionLaw};
use crate::robot::JointModel;

/// [s] Longest step of the mechanics: a hundredth of the time in which the slope of friction moves a heavy arm.
const STEP: f64 = 4e-3;
/// [s] Motion before a window in which the filter settles.
const LEAD: f64 = 0.25;
/// Standard deviation of the error of the model's torque from sample to sample, as a part of the torque.
const MODEL_ERROR: f64 = 0.05;
/// The same once the law is nearly right and rotor and link move together.
pub(crate) const SMALL_MODEL_ERROR: f64 = 0.005;
/// Standard deviation of an edge's position in counts.
pub(crate) const EDGE: f64 = 0.005;
/// Part of a count by which a predicted position may leave the count that is read before it is held back.
const HELD: f64 = 0.1;
/// Standard deviation of the constant torque that a law may lack, before it is known, as a part of the torque.
const FIRST_ERROR: f64 = 0.1;
/// Standard deviation, as a part of the velocity, that is added when the lacking torque becomes a state: what the law lacked before
/// does not count.
const RELEASED_SPEED: f64 = 0.05;
/// [1] Share of friction on the link where the model does not give it: the middle of what is possible.
const LINK_SHARE: f64 = 0.5;
/// Number of parts of a window; the average over each part is a residual.
pub const PARTS: usize = 16;

/// The data of one window that do not depend on the friction law.
#[derive(Debug, Clone)]
pub struct Track {
    /// The samples, lead-in first, grouped from edge to edge.
    strides: Vec<Stride>,
    /// First stride of every part of the window, and the end of the last.
    parts: [usize; PARTS + 1],
    /// [rad or m] first reading, and [rad/s or m/s] velocity over the first half of the lead-in.
    start: (f64, f64),
    /// `J + H_ii` [kg·m² or kg] over the window.
    inertia: f64,
    gear: Gear,
    /// Size of a count [rad or m].
    count: f64,
    /// [N·m or N] mean size of the torque.
    level: f64,
    /// Variance of a sample's torque noise [N²·m² or N²].
    noise_variance: f64,
}

/// How far the rotor is ahead of rotor and link as one mass.
#[derive(Debug, Clone, Copy)]
struct Gear {
    /// `1/k` [rad/(N·m) or m/N]; 0 for a gear whose stiffness is not known.
    compliance: f64,
    /// `d/k` [s]
    relaxation: f64,
    /// `H_ii/(J + H_ii)` [1]
    of_link: f64,
    /// `s` [1]
    share: f64,
}

impl Gear {
    fn of(joint: &JointModel, inertia: f64) -> Self {
        let compliance = joint.gear_stiffness.map_or(0.0, f64::recip);
        Self {
            compliance,
            relaxation: joint.gear_damping.unwrap_or(0.0) * compliance,
            of_link: (1.0 - joint.reflected_inertia() / inertia).max(0.0),
            share: joint.friction.map_or(LINK_SHARE, |friction| friction.link_share),
        }
    }

    /// `δ` [rad or m] after a time under a torque of the motor and an acceleration, from `wound_up` on.
    fn wind_up(&self, wound_up: f64, torque: f64, inertia: f64, acceleration: f64, time: f64) -> f64 {
        let load = self.share * torque + (self.of_link - self.share) * inertia * acceleration;
        let remaining = if self.relaxation > 0.0 { (-time / self.relaxation).exp() } else { 0.0 };
        self.compliance * load + remaining * (wound_up - self.compliance * load)
    }
}

/// The samples from one encoder edge to the next, or a part of them no longer than [`STEP`].
#[derive(Debug, Clone, Copy)]
struct Stride {
    /// Number of samples.
    samples: f64,
    /// [s] its length, and that of the last sample interval in it.
    time: f64,
    last: f64,
    /// [N·m or N] mean of `τ − G`.
    torque: f64,
    /// [rad or m] reading at the end.
    position: f64,
    /// Direction of the edge at the end: +1, −1, or 0 where there is none.
    edge: f64,
}

/// What a law lacks over a stretch of motion.
#[derive(Debug, Clone)]
pub struct Lack {
    /// [N·m or N] the constant torque that it lacks; positive drives positively.
    pub torque: f64,
    /// [N·m or N] its standard error.
    pub std_error: f64,
    /// Shares of the time and velocities [rad/s or m/s] of the motion. If the shares sum to less than one, the joint stuck in the
    /// remaining time.
    pub velocities: Vec<(f64, f64)>,
}

impl Track {
    /// The track of a window.
    pub fn of(signals: &Signals, rigid: &RigidBody, window: Window) -> Self {
        let clock = &signals.clock;
        let lead = ((LEAD / clock.interval) as usize).min(window.start);
        let first = window.start - lead;
        let samples = first..window.end + 1;
        let gravity = rigid.gravity_along(samples.clone());
        let (torque, position) = (&signals.torque[samples.clone()], &signals.position[samples]);
        let head = (lead / 2).max(1).min(position.len() - 1);
        let mean = torque.iter().sum::<f64>() / torque.len() as f64;
        let noise_variance = signals.torque_noise.powi(2).max(white_noise(torque).powi(2)).max((1e-4 * mean).powi(2));
        let elapsed = |from: usize, to: usize| clock.elapsed(first + from, first + to);
        let most = (STEP / clock.interval + 1e-9) as usize;
        let (strides, ends) = strides(torque, &gravity, position, elapsed, most);
        let first_of = |part: usize| {
            let sample = lead + part * (position.len() - 1 - lead) / PARTS;
            ends.partition_point(|&end| end <= sample)
        };
        let inertia = rigid.inertia(window);
        Self {
            strides,
            parts: std::array::from_fn(first_of),
            start: (position[0], (position[head] - position[0]) / elapsed(0, head)),
            inertia,
            gear: Gear::of(rigid.joint_model(), inertia),
            count: signals.count,
            level: torque.iter().map(|torque| torque.abs()).sum::<f64>() / torque.len() as f64,
            noise_variance,
        }
    }

    /// Standard error of the mean torque by the sensor's noise alone [N·m or N].
    pub fn mean_torque_error(&self) -> f64 {
        (self.noise_variance / self.samples(0..PARTS)).sqrt()
    }

    /// Number of samples of some parts of the window.
    fn samples(&self, parts: Range<usize>) -> f64 {
        self.strides[self.parts[parts.start]..self.parts[parts.end]].iter().map(|stride| stride.samples).sum()
    }

    /// What the law lacks over some parts of the window: the filter's third state, which is estimated from the first of these parts on.
    pub fn lacking_over(&self, parts: &Range<usize>, law: &FrictionLaw, centrifugal: f64) -> Lack {
        let (first, last) = (self.parts[parts.start], self.parts[parts.end]);
        let mut state = State::start(self);
        for stride in &self.strides[..first] {
            state.advance(self, stride, law, centrifugal);
            state.correct(self, stride);
        }
        state.release(self);
        let mut velocities = Vec::with_capacity(last - first);
        for stride in &self.strides[first..last] {
            let before = state.omega;
            state.advance(self, stride, law, centrifugal);
            velocities.push((stride.time, 0.5 * (before + state.omega)));
            state.correct(self, stride);
        }
        Lack {
            torque: state.lacking,
            std_error: state.p22.sqrt() * state.surprise(),
            velocities: condensed(velocities),
        }
    }

    /// Mean torque that the law lacks over each of [`PARTS`] parts of the window [N·m or N], positive drives positively.
    pub fn lacking(&self, law: &FrictionLaw, centrifugal: f64) -> [f64; PARTS] {
        let mut state = State::start(self);
        let mut momentum = |strides: Range<usize>| {
            let (mut momentum, mut time) = (0.0, 0.0);
            for stride in &self.strides[strides] {
                state.advance(self, stride, law, centrifugal);
                momentum += state.correct(self, stride);
                time += stride.time;
            }
            momentum / time
        };
        momentum(0..self.parts[0]);
        std::array::from_fn(|part| momentum(self.parts[part]..self.parts[part + 1]))
    }
}

/// The strides of some samples, none of more than `most`, and the sample at which each ends.
fn strides(
    torque: &[f64],
    gravity: &[f64],
    position: &[f64],
    elapsed: impl Fn(usize, usize) -> f64,
    most: usize,
) -> (Vec<Stride>, Vec<usize>) {
    let (mut strides, mut ends) = (Vec::new(), Vec::new());
    let (mut from, mut sum) = (0, 0.0);
    for k in 1..position.len() {
        let last = elapsed(k - 1, k);
        sum += 0.5 * last * (torque[k - 1] + torque[k] - gravity[k - 1] - gravity[k]);
        let way = position[k] - position[k - 1];
        if way != 0.0 || k - from >= most || k + 1 == position.len() {
            let (samples, time) = ((k - from) as f64, elapsed(from, k));
            let edge = if way == 0.0 { 0.0 } else { way.signum() };
            strides.push(Stride { samples, time, last, torque: sum / time, position: position[k], edge });
            ends.push(k);
            (from, sum) = (k, 0.0);
        }
    }
    (strides, ends)
}

/// Velocities that represent a distribution: means of [`CLASSES`] equal shares of the strides in motion, in the order of speed.
fn condensed(mut velocities: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let all: f64 = velocities.iter().map(|(time, _)| time).sum();
    velocities.retain(|(_, velocity)| *velocity != 0.0);
    velocities.sort_by(|a, b| a.1.total_cmp(&b.1));
    let size = velocities.len().div_ceil(CLASSES).max(1);
    let class = |class: &[(f64, f64)]| {
        let time: f64 = class.iter().map(|(time, _)| time).sum();
        let way: f64 = class.iter().map(|(time, velocity)| time * velocity).sum();
        (time / all, way / time)
    };
    velocities.chunks(size).map(class).collect()
}

/// Number of velocities that represent the motion of a window.
const CLASSES: usize = 8;

/// Position, velocity and lacking torque, and their covariance.
#[derive(Debug, Clone, Copy)]
struct State {
    theta: f64,
    omega: f64,
    /// `δ` [rad or m]
    wound_up: f64,
    lacking: f64,
    p00: f64,
    p01: f64,
    p11: f64,
    p02: f64,
    p12: f64,
    p22: f64,
    /// Variance of what the model's torque lacks in one sample, noise included.
    noise: f64,
    /// Sum of the squared innovations of the edges over their variance, and their number.
    innovations: (f64, f64),
}

impl State {
    /// In the middle of its count, at the velocity of the lead-in.
    fn start(track: &Track) -> Self {
        let (position, omega) = track.start;
        let torque = track.strides.first().map_or(0.0, |stride| stride.torque);
        let wound_up = track.gear.compliance * track.gear.share * torque;
        Self {
            theta: position + 0.5 * track.count - track.gear.of_link * wound_up,
            omega,
            wound_up,
            lacking: 0.0,
            p00: track.count * track.count / 12.0,
            p01: 0.0,
            p11: omega * omega,
            p02: 0.0,
            p12: 0.0,
            p22: 0.0,
            noise: track.noise_variance + (MODEL_ERROR * track.level).powi(2),
            innovations: (0.0, 0.0),
        }
    }

    /// From here on the lacking torque is a state, and the model is trusted.
    fn release(&mut self, track: &Track) {
        (self.p02, self.p12, self.p22) = (0.0, 0.0, (FIRST_ERROR * track.level).powi(2));
        self.p11 += (RELEASED_SPEED * self.omega).powi(2);
        self.noise = track.noise_variance + (SMALL_MODEL_ERROR * track.level).powi(2);
        self.innovations = (0.0, 0.0);
    }

    /// Advances the state and its covariance over a stride.
    fn advance(&mut self, track: &Track, stride: &Stride, law: &FrictionLaw, centrifugal: f64) {
        let time = stride.time;
        let steps = (time / STEP - 1e-9).ceil().max(1.0);
        let dt = time / steps;
        for _ in 0..steps as usize {
            let net = stride.torque + self.lacking - centrifugal * self.omega * self.omega;
            let (omega, slope) = slide(self.omega, net, track.inertia, dt, law);
            self.theta += 0.5 * dt * (self.omega + omega);
            let acceleration = (omega - self.omega) / dt;
            self.wound_up = track.gear.wind_up(self.wound_up, net, track.inertia, acceleration, dt);
            self.omega = omega;
            self.spread(dt, dt / track.inertia, slope, self.noise * steps / stride.samples);
        }
    }

    /// Covariance after `dt` under a slope of friction and a variance of the torque; `push`: velocity per torque.
    fn spread(&mut self, dt: f64, push: f64, slope: f64, variance: f64) {
        let growth = (-slope * push).clamp(-0.5, 0.5).exp();
        self.p00 += dt * (2.0 * self.p01 + dt * self.p11);
        self.p01 = growth * (self.p01 + dt * self.p11) + push * (self.p02 + dt * self.p12);
        self.p02 += dt * self.p12;
        self.p11 = growth * growth * self.p11 + push * (2.0 * growth * self.p12 + push * (self.p22 + variance));
        self.p12 = growth * self.p12 + push * self.p22;
    }

    /// Factor by which the innovations are larger than the filter expects, at least 1.
    fn surprise(&self) -> f64 {
        let (sum, count) = self.innovations;
        (sum / count.max(1.0)).sqrt().max(1.0)
    }

    /// Processes the new reading; returns the momentum of the correction [N·m·s or N·s].
    fn correct(&mut self, track: &Track, stride: &Stride) -> f64 {
        let (low, high) = (stride.position, stride.position + track.count);
        let rotor = self.theta + track.gear.of_link * self.wound_up;
        let (innovation, variance) = if stride.edge == 0.0 {
            let slack = (HELD * track.count).max(2.0 * self.p00.sqrt()).min(0.5 * track.count);
            let held = rotor.clamp(low - slack, high + slack);
            if held == rotor {
                return 0.0;
            }
            (held - rotor, (HELD * track.count).powi(2))
        } else {
            // The edge lies anywhere within the last sample interval.
            let boundary = if stride.edge > 0.0 { low } else { high };
            let way = self.omega.abs() * stride.last;
            let travel = (0.5 * way).min(0.5 * track.count).copysign(stride.edge);
            (boundary + travel - rotor, way.powi(2) / 12.0 + (EDGE * track.count).powi(2))
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

/// Velocity after a step under dry friction, and the slope of friction. A mass that friction can stop within the step ends at rest.
/// Friction is that at the mean speed, to first order in the step.
fn slide(velocity: f64, torque: f64, inertia: f64, dt: f64, law: &FrictionLaw) -> (f64, f64) {
    let push = dt / inertia;
    let free = velocity + push * torque;
    let speed = if velocity * free > 0.0 { velocity.abs() } else { 0.0 };
    let (friction, slope) = law.magnitude_and_slope(Direction::of(free), speed);
    let left = free.abs() - push * friction;
    if left <= 0.0 {
        return (0.0, slope);
    }
    let at_mean = if speed == 0.0 { left } else { (left - 0.5 * push * slope * (left - speed)).max(0.0) };
    (at_mean.copysign(free), slope)
}

/// Standard deviation of the white noise of a signal that is smooth otherwise, from the median of its second differences.
fn white_noise(signal: &[f64]) -> f64 {
    typical(signal.windows(3).map(|x| x[0] - 2.0 * x[1] + x[2])).max(0.0) / 6f64.sqrt()
}

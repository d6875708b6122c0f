//! Reading of an incremental encoder: quantised position, and velocity from its counts.
//!
//! With the size of a count at the joint `δ = 2π/(counts · ratio)` and a phase `φ ∈ [0, 1)` that depends on the mounting,
//!
//! ```text
//!   c = ⌊θ/δ + φ⌋        position = (c + ½ − φ) δ          |position − θ| ≤ δ/2, zero on average
//! ```
//!
//! **Pulse period** (frequency measurement). With `t_e` the last edge and `t_p` the edge before it, both crossed in
//! direction `s`,
//!
//! ```text
//!   velocity(t) = s δ / max(t_e − t_p, t − t_e)
//! ```
//!
//! The value is outdated between edges, but never more than one count over the time since the last edge. It needs two
//! edges of equal direction: before these, and after a reversal until the second edge of the new direction, it is zero.
//!
//! **Low-pass.** `v ← v + (1 − e^{−Δt/τ}) ((p − p_last)/Δt − v)` at every reading, `p` the quantised position.
//!
//! Left out: interpolation errors between counts, bounce of the edges.
//! Reference: L. Márton, B. Lantos (2009), section IV ("measured frequency of the incremental encoder signals").

use super::{Encoder, VelocitySensor};

/// An encoder on a joint, with its phase: angles to counts and back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Counter {
    /// `δ` [rad or m] size of a count at the joint, > 0.
    pub step: f64,
    /// `φ` [1] where in a count the angle zero lies, 0 to 1.
    pub phase: f64,
}

impl Counter {
    /// An encoder on the motor shaft of a gear of this ratio.
    pub fn new(encoder: &Encoder, gear_ratio: f64, phase: f64) -> Self {
        Self { step: 2.0 * std::f64::consts::PI / (encoder.counts_per_turn * gear_ratio), phase }
    }

    /// `c` at a true position [rad or m].
    pub fn count(&self, position: f64) -> f64 {
        (position / self.step + self.phase).floor()
    }

    /// Position [rad or m] that is read at a count.
    pub fn position(&self, count: f64) -> f64 {
        (count + 0.5 - self.phase) * self.step
    }

    /// True position [rad or m] at which the count changes from `count − 1` to `count`.
    pub fn edge(&self, count: f64) -> f64 {
        (count - self.phase) * self.step
    }
}

/// A stretch of motion between two instants: a cubic through positions and velocities at its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// [s] start and end.
    pub time: [f64; 2],
    /// [rad or m] at start and end.
    pub position: [f64; 2],
    /// [rad/s or m/s] at start and end.
    pub velocity: [f64; 2],
}

impl Stretch {
    /// Time [s] at which a position between those of the ends is passed, for motion in one direction.
    pub fn time_at(&self, position: f64) -> f64 {
        let [p0, p1] = self.position;
        let h = self.time[1] - self.time[0];
        let (m0, m1) = (self.velocity[0] * h, self.velocity[1] * h);
        let (c2, c3) = (3.0 * (p1 - p0) - 2.0 * m0 - m1, m0 + m1 - 2.0 * (p1 - p0));
        let miss = |s: f64| p0 + s * (m0 + s * (c2 + s * c3)) - position;
        let rising = p1 > p0;
        let (mut low, mut high) = (0.0, 1.0);
        let mut s = (position - p0) / (p1 - p0);
        // Newton inside a bracket; 1e-13 of a step is below a femtosecond at the steps in use.
        for _ in 0..60 {
            let error = miss(s);
            if (error > 0.0) == rising {
                high = s
            } else {
                low = s
            }
            let slope = m0 + s * (2.0 * c2 + 3.0 * s * c3);
            let newton = s - error / slope;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let done = (next - s).abs() < 1e-13;
            s = next;
            if done {
                break;
            }
        }
        self.time[0] + s * h
    }
}

/// The velocity channel of an encoder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum VelocityMeter {
    /// Filtered differences of the position that was read.
    LowPass {
        /// `τ` [s] > 0.
        time_constant: f64,
        /// Time and position of the last reading.
        last: Option<(f64, f64)>,
        /// [rad/s or m/s] current value.
        velocity: f64,
    },
    /// One count over the time between edges.
    PulsePeriod {
        /// `t_e` [s] and direction of the last edge; the direction is 0 where there was none.
        last_edge: (f64, f64),
        /// `t_e − t_p` [s]; infinite while undefined.
        period: f64,
    },
}

impl VelocityMeter {
    /// A meter at rest.
    pub fn new(sensor: VelocitySensor) -> Self {
        match sensor {
            VelocitySensor::LowPass(time_constant) => Self::LowPass { time_constant, last: None, velocity: 0.0 },
            VelocitySensor::PulsePeriod => Self::PulsePeriod { last_edge: (0.0, 0.0), period: f64::INFINITY },
        }
    }

    /// Clears the memory of past motion.
    pub fn restart(&mut self) {
        match self {
            Self::LowPass { last, velocity, .. } => (*last, *velocity) = (None, 0.0),
            Self::PulsePeriod { last_edge, period } => (*last_edge, *period) = ((0.0, 0.0), f64::INFINITY),
        }
    }

    /// Processes a stretch of the true motion in which the count changes from `from` to `to`.
    pub fn watch(&mut self, counter: &Counter, stretch: &Stretch, from: f64, to: f64) {
        let Self::PulsePeriod { last_edge, period } = self else { return };
        if from == to {
            return;
        }
        let direction = (to - from).signum();
        // Rising into `to` passes the edge of `to`; falling into it passes the edge of `to + 1`.
        let line = if direction > 0.0 { to } else { to + 1.0 };
        let time = stretch.time_at(counter.edge(line));
        let before = if (to - from).abs() > 1.0 {
            Some(stretch.time_at(counter.edge(line - direction)))
        } else {
            (last_edge.1 == direction).then_some(last_edge.0)
        };
        *period = before.map_or(f64::INFINITY, |before| time - before);
        *last_edge = (time, direction);
    }

    /// Velocity [rad/s or m/s] at a reading of this position [rad or m] at `time` [s].
    pub fn read(&mut self, counter: &Counter, time: f64, position: f64) -> f64 {
        match self {
            Self::LowPass { time_constant, last, velocity } => {
                if let Some((last_time, last_position)) = *last {
                    let dt = time - last_time;
                    if dt > 0.0 {
                        let share = -(-dt / *time_constant).exp_m1();
                        *velocity += share * ((position - last_position) / dt - *velocity);
                    }
                }
                *last = Some((time, position));
                *velocity
            }
            Self::PulsePeriod { last_edge: (edge, direction), period } => {
                *direction * counter.step / period.max(time - *edge).max(f64::MIN_POSITIVE)
            }
        }
    }
}

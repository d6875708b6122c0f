//! Velocity from the edges of an incremental encoder and the commanded torque: a Kalman filter.
//!
//! At half a degree per second the encoder of a joint gives ten to fifteen edges a second, and a velocity measured from
//! their periods lags by one period. Between edges the torque is known, so the motion can be predicted:
//!
//! ```text
//!   q̇ = v,    J v̇ = τ − d,    ḋ = w          d: friction and everything else, a random walk
//! ```
//!
//! At an edge the position is known to a few per cent of a count `δ`. Between edges it is within the count
//! `[p − δ/2, p + δ/2]`; a prediction that leaves the count is set back to the border that it crossed (an edge that was
//! not observed). `J` is the inertia of rotor and link together: while the rotor is alone in the gap, the observer
//! treats its motion as that of the arm and responds slowly. Sign: `d > 0` brakes a motion in the positive direction.
//! Left out: coupling of the joints (it becomes part of `d`), delay of the current loop.

use nalgebra::{Matrix3, Vector3};

/// Noise parameters of the observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObserverNoise {
    /// [N·m/√s or N/√s] random walk of `d`, > 0.
    pub disturbance: f64,
    /// [(rad/s)/√s] random walk of the velocity, ≥ 0.
    pub velocity: f64,
    /// [1] standard deviation of an edge's position in counts, > 0.
    pub edge: f64,
}

/// State of one joint's observer.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeObserver {
    /// `δ` [rad or m] count of the encoder at the joint, > 0.
    count: f64,
    noise: ObserverNoise,
    /// `[q, v, d]`.
    x: Vector3<f64>,
    /// Its covariance.
    p: Matrix3<f64>,
    /// Position that the encoder read last.
    reading: f64,
}

impl EdgeObserver {
    /// At rest at an encoder position [rad or m].
    pub fn new(count: f64, noise: ObserverNoise, reading: f64) -> Self {
        let p = Matrix3::from_diagonal(&Vector3::new(count * count / 12.0, count * count, 1e-2));
        Self { count, noise, x: Vector3::new(reading, 0.0, 0.0), p, reading }
    }

    /// Estimated `q` [rad or m].
    pub fn position(&self) -> f64 {
        self.x[0]
    }

    /// Estimated `v` [rad/s or m/s].
    pub fn velocity(&self) -> f64 {
        self.x[1]
    }

    /// Estimated `d` [N·m or N].
    pub fn disturbance(&self) -> f64 {
        self.x[2]
    }

    /// Processes the encoder's position [rad or m] `h` [s] after the last one; in between, `τ` [N·m or N] drives an
    /// inertia `J`.
    pub fn update(&mut self, reading: f64, tau: f64, inertia: f64, h: f64) {
        self.predict(tau, inertia, h);
        let half = 0.5 * self.count;
        let moved = reading - self.reading;
        let (low, high) = (reading - half, reading + half);
        let border = if moved.abs() > half {
            Some(if moved > 0.0 { low } else { high })
        } else if self.x[0] < low {
            Some(low)
        } else if self.x[0] > high {
            Some(high)
        } else {
            None
        };
        self.reading = reading;
        if let Some(border) = border {
            self.correct(border, h);
        }
    }

    /// Moves the estimated position by a distance [rad or m] that the motor is made to go in addition, such as through its gap.
    pub fn displace(&mut self, distance: f64) {
        self.x[0] += distance;
    }

    /// `x ← A x + B τ`, `P ← A P Aᵀ + Q`.
    fn predict(&mut self, tau: f64, inertia: f64, h: f64) {
        let [q, v, d] = [self.x[0], self.x[1], self.x[2]];
        let a = (tau - d) / inertia;
        self.x = Vector3::new(q + h * (v + 0.5 * h * a), v + h * a, d);
        let transition = Matrix3::new(1.0, h, -0.5 * h * h / inertia, 0.0, 1.0, -h / inertia, 0.0, 0.0, 1.0);
        self.p = transition * self.p * transition.transpose();
        self.p[(1, 1)] += h * self.noise.velocity.powi(2);
        self.p[(2, 2)] += h * self.noise.disturbance.powi(2);
    }

    /// Processes a measured position: the edge lies anywhere within the last sampling interval.
    fn correct(&mut self, border: f64, h: f64) {
        let r = (self.noise.edge * self.count).powi(2) + (h * self.x[1]).powi(2) / 12.0;
        let gain = self.p.column(0) / (self.p[(0, 0)] + r);
        self.x += gain * (border - self.x[0]);
        self.p -= gain * self.p.row(0);
    }
}

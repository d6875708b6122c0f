//! Measurement points: equation 11 on the averages of one steady window.
//!
//! ```text
//!   τ_f + C_ii q̇² = ⟨ratio K_t i⟩ − ⟨G(q)⟩ − H_ii ⟨q̈⟩
//! ```
//!
//! The last term is not in the paper: it removes the rest of the transient. The velocity is the whole number of counts of the window
//! divided by the time between its first and its last edge. This is far better than the average of a velocity channel that is outdated
//! between edges. That average, which the paper uses, is given as well.

use serde::Serialize;

use super::rigid_body::RigidBody;
use super::signals::Signals;
use super::statistics::{mean, mean_with_error};
use super::windows::Window;
use crate::gearhead::Direction;

/// Part of a window at either end over which the velocity for its mean acceleration is taken.
const END_PART: f64 = 0.25;

/// A measurement point of the friction characteristic: what equation 11 yields for one steady window. Joint side, SI.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// Index of the session among the data.
    pub session: usize,
    /// [s] first and last sample of the window.
    pub window: [f64; 2],
    /// `q̇` [rad/s or m/s] counts of the window over its time.
    pub velocity: f64,
    /// [rad/s or m/s] standard error of the velocity.
    pub velocity_std_error: f64,
    /// [rad/s or m/s] average of the measured velocity, the paper's point; absent where no velocity was recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_measured_velocity: Option<f64>,
    /// `⟨τ⟩` [N·m or N] average motor torque on the joint side, with its sign.
    pub torque: f64,
    /// `⟨G + H_ii q̈⟩` [N·m or N] rigid-body torque of the model over the window, without the term of `C_ii`.
    pub rigid_body: f64,
    /// [N·m or N] friction with its sign at that velocity, and the centrifugal term: `⟨τ⟩ − ⟨G + H_ii q̈⟩`,
    /// corrected by the balance over the motion where there is one.
    pub friction: f64,
    /// [N·m or N] standard error of the friction, autocorrelation allowed for.
    pub std_error: f64,
}

impl Point {
    /// The point of a window.
    pub fn of(session: usize, signals: &Signals, rigid: &RigidBody, window: Window) -> Self {
        let Window { start, end } = window;
        let slope = |from: usize, to: usize| {
            (signals.position[to] - signals.position[from]) / (signals.time[to] - signals.time[from])
        };
        let time = signals.time[end] - signals.time[start];
        let velocity = slope(start, end);
        // An edge is seen at the first sample after it: a uniform delay of up to one sample at either end.
        let edge_time = signals.clock.interval / 12f64.sqrt();
        let velocity_std_error = velocity.abs() * 2f64.sqrt() * edge_time / time;
        let part = (END_PART * (end - start) as f64) as usize;
        let (early, late) = (signals.edge_after(start + part), signals.edge_after(end - part));
        let acceleration = (slope(late, end) - slope(start, early)) / ((1.0 - END_PART) * time);
        let acceleration_std_error = 2.0 * velocity.abs() * edge_time / (END_PART * (1.0 - END_PART) * time * time);
        let (torque, torque_std_error) = mean_with_error(&signals.torque[start..end]);
        let gravity = rigid.gravity(window);
        let inertia = rigid.inertia(window);
        let rigid_body = gravity + inertia * acceleration;
        Self {
            session,
            window: [signals.time[start], signals.time[end]],
            velocity,
            velocity_std_error,
            mean_measured_velocity: signals.velocity.map(|v| mean(&v[start..end])),
            torque,
            rigid_body,
            friction: torque - rigid_body,
            std_error: torque_std_error.hypot(inertia * acceleration_std_error),
        }
    }

    /// Direction of the motion.
    pub fn direction(&self) -> Direction {
        Direction::of(self.velocity)
    }
}

//! Measurement points: one average of friction torque and velocity a steady window.

use serde::Serialize;

/// A measurement point of the friction characteristic: what equation 11 yields for one steady window. Joint side, SI.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// Index of the session among the data.
    pub session: usize,
    /// [s] first and last sample of the window.
    pub window: [f64; 2],
    /// `q̇` [rad/s or m/s] slope of the encoder position over the window.
    pub velocity: f64,
    /// [rad/s or m/s] standard error of the velocity.
    pub velocity_std_error: f64,
    /// [rad/s or m/s] average of the measured velocity, the paper's point; absent where no velocity was recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_measured_velocity: Option<f64>,
    /// `τ` [N·m or N] average motor torque on the joint side, with its sign.
    pub torque: f64,
    /// `G` [N·m or N] average rigid-body torque of the model over the window: gravity, and inertia times the mean acceleration.
    pub rigid_body: f64,
    /// `τ − G` [N·m or N] friction with its sign, the centrifugal term not yet removed.
    pub friction: f64,
    /// [N·m or N] standard error of the friction, autocorrelation allowed for.
    pub std_error: f64,
}

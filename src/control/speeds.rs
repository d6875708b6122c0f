//! A sequence of constant velocities of one joint, each with its own length and braking.
//!
//! ```text
//!   q̇_d          ____
//!        ___    /    \              v_1, v_2, ..., signed: neighbours of one direction follow each other without a stop,
//!       /   \__/      \     /       neighbours of opposite directions reverse
//!   ___/               \___/
//! ```
//!
//! A joint that goes on in its direction keeps its flank, and its controller keeps its torque: it settles within a fraction of a second.
//! After a reversal it lags until the torque has changed by twice the friction. So a sequence shows friction at many speeds with few
//! reversals, and its gentle reversals show the gap. [`Staircase`](super::Staircase) reverses after every speed.

use super::Profile;

/// A constant velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedStep {
    /// [rad/s or m/s] with its sign, ≠ 0.
    pub velocity: f64,
    /// [s] for which it is constant, ≥ 0.
    pub duration: f64,
    /// [rad/s² or m/s²] with which it slows down to a lower speed or to rest, > 0.
    pub deceleration: f64,
}

/// A sequence of speeds of one joint while the others rest.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedSequence {
    /// Index of the joint.
    pub joint: usize,
    /// [rad/s² or m/s²] with which speed grows, > 0.
    pub acceleration: f64,
    /// The velocities in their order.
    pub steps: Vec<SpeedStep>,
}

impl SpeedSequence {
    /// Appends the sequence to the profile; it ends at rest.
    pub fn append(&self, profile: &mut Profile) {
        let start = profile.duration();
        let track = &mut profile.tracks_mut()[self.joint];
        track.coast(start - track.duration());
        let mut braking = self.acceleration;
        for SpeedStep { velocity, duration, deceleration } in &self.steps {
            if track.end().velocity * velocity < 0.0 {
                track.change_velocity(0.0, braking);
            }
            let slower = velocity.abs() < track.end().velocity.abs();
            track.change_velocity(*velocity, if slower { braking } else { self.acceleration });
            track.coast(*duration);
            braking = *deceleration;
        }
        track.change_velocity(0.0, braking);
    }
}

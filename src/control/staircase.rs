//! The paper's reference for friction and backlash: Figure 2.
//!
//! ```text
//!   q̇_d                 ____
//!          __          /    \               speeds v_1 < v_2 < ..., each in both directions
//!     ____/  \        /      \        /     steady for T + s/v: s is the distance by which the joint lags
//!             \__/            \______/      when it reverses against friction that the controller does not know
//! ```
//!
//! Every pair of steps ends where it began, or a little further on: if all reversals were at the same phase of an
//! encoder count, their gap measurements would share its error. The joint brakes gently, so that the link's own
//! friction keeps it on the flank that drives it, and the motor crosses the whole gap when it reverses ("uniform
//! deceleration, with low velocity rate change value"). It may accelerate faster, because then the flank pushes.
//! Reference: L. Márton, B. Lantos (2009), Figure 2 and section III.

use super::Profile;

/// The speeds of a staircase: `first`, `first + increment`, ... up to `last` [rad/s or m/s, all > 0].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steps {
    /// Slowest.
    pub first: f64,
    /// Fastest.
    pub last: f64,
    /// From one step to the next.
    pub increment: f64,
}

impl Steps {
    /// Number of speeds, a whole number; infinite if it is too large to count.
    pub fn count(&self) -> f64 {
        ((self.last - self.first) / self.increment + 1e-9).floor().max(0.0) + 1.0
    }

    /// The speeds, slowest first.
    pub fn speeds(&self) -> impl Iterator<Item = f64> + use<> {
        let Self { first, increment, .. } = *self;
        (0..self.count() as usize).map(move |k| first + k as f64 * increment)
    }
}

/// Steps at which the gap is measured: they brake so gently that the link, decelerated by its own friction, stays on
/// the flank that drives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gentle {
    /// [rad/s or m/s] Fastest step with gentle braking, ≥ 0.
    pub up_to: f64,
    /// [rad/s² or m/s²] > 0.
    pub deceleration: f64,
}

/// A staircase of one joint while the others rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Staircase {
    /// Index of the joint.
    pub joint: usize,
    /// Its speeds.
    pub steps: Steps,
    /// [rad/s² or m/s²] > 0.
    pub acceleration: f64,
    /// [rad/s² or m/s²] > 0.
    pub deceleration: f64,
    /// The steps that brake more gently; `None`: all steps brake in the same way.
    pub gentle: Option<Gentle>,
    /// `T` [s] minimum duration of every step, ≥ 0.
    pub steady_time: f64,
    /// `s` [rad or m] additional distance at constant velocity, ≥ 0.
    pub settling_way: f64,
    /// [rad or m] Distance by which each pair of steps ends beyond its start, in the direction of its first step, ≥ 0.
    pub advance: f64,
    /// Direction of each pair's first step: +1 or −1.
    pub direction: f64,
}

impl Staircase {
    /// Appends the staircase to the profile.
    pub fn append(&self, profile: &mut Profile) {
        let start = profile.duration();
        let track = &mut profile.tracks_mut()[self.joint];
        track.coast(start - track.duration());
        for speed in self.steps.speeds() {
            for (direction, shortfall) in [(self.direction, 0.0), (-self.direction, self.advance)] {
                let constant = (self.steady_time + (self.settling_way - shortfall) / speed).max(0.0);
                track.trapezoid(direction * speed, self.acceleration, constant, self.deceleration(speed));
            }
        }
    }
    /// Deceleration of a step of this speed.
    fn deceleration(&self, speed: f64) -> f64 {
        // Speeds are sums of increments: the last one must not be missed by rounding.
        let gentle = self.gentle.filter(|gentle| speed <= gentle.up_to * (1.0 + 1e-9));
        gentle.map_or(self.deceleration, |gentle| gentle.deceleration)
    }
}

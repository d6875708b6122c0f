//! The paper's reference for friction and backlash: Figure 2.
//!
//! ```text
//!   q̇_d                 ____
//!          __          /    \               speeds v_1 < v_2 < ..., each in both directions
//!     ____/  \        /      \        /     steady for T + s/v: s is the way that the joint lags behind
//!             \__/            \______/      when it reverses against friction that the controller does not know
//! ```
//!
//! The joint ends every pair of steps where it began, or a little further on: a gap measured at turns that all share one phase
//! of an encoder count would share its error as well. It brakes gently, so that the link's own friction keeps it pressed to
//! the flank that drives it and the gap is still whole when the motor reverses ("uniform deceleration, with low velocity
//! rate change value"); it may speed up faster, because then the flank pushes.
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
    /// How many speeds there are, a whole number; infinite where it is beyond counting.
    pub fn count(&self) -> f64 {
        ((self.last - self.first) / self.increment + 1e-9).floor().max(0.0) + 1.0
    }

    /// The speeds, slowest first.
    pub fn speeds(&self) -> impl Iterator<Item = f64> + use<> {
        let Self { first, increment, .. } = *self;
        (0..self.count() as usize).map(move |k| first + k as f64 * increment)
    }
}

/// Steps at which the gap is to be measured: they brake so gently that the link, braked by its own friction, stays on the flank that
/// drives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gentle {
    /// [rad/s or m/s] Fastest step that brakes so, ≥ 0.
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
    /// The steps that brake more gently than that; `None`: all steps brake alike.
    pub gentle: Option<Gentle>,
    /// `T` [s] every step at least, ≥ 0.
    pub steady_time: f64,
    /// `s` [rad or m] way at constant velocity on top of it, ≥ 0.
    pub settling_way: f64,
    /// [rad or m] how far each pair of steps ends beyond where it began, in the direction of its first step, ≥ 0.
    pub advance: f64,
    /// Direction of each pair's first step: +1 or −1.
    pub direction: f64,
}

impl Staircase {
    /// Appends the staircase after everything that the profile already holds.
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
    /// What a step of this speed brakes with.
    fn deceleration(&self, speed: f64) -> f64 {
        // Speeds are sums of increments: one that is meant to be the last must not miss it by rounding.
        let gentle = self.gentle.filter(|gentle| speed <= gentle.up_to * (1.0 + 1e-9));
        gentle.map_or(self.deceleration, |gentle| gentle.deceleration)
    }
}

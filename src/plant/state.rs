//! The state of a machine at an instant, and the situation in which its laws are evaluated.

use super::joint::{Phase, Power};
use super::mode::Mode;

/// The state of a machine at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// `t` [s].
    pub time: f64,
    /// One per joint.
    pub joints: Vec<Phase>,
    /// One per joint.
    pub modes: Vec<Mode>,
    /// One per barrier: whether it is touched.
    pub touching: Vec<bool>,
    /// [J] done and dissipated since the start.
    pub done: Power,
}

impl State {
    /// Copies another state without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.time = other.time;
        self.joints.copy_from_slice(&other.joints);
        self.modes.copy_from_slice(&other.modes);
        self.touching.copy_from_slice(&other.touching);
        self.done = other.done;
    }

    /// The state itself under these commands.
    pub fn under<'a>(&'a self, commands: &'a [f64]) -> Situation<'a> {
        self.moved_to(self.time, &self.joints, commands)
    }

    /// Joints that have moved on within the modes of the state.
    pub fn moved_to<'a>(&'a self, time: f64, joints: &'a [Phase], commands: &'a [f64]) -> Situation<'a> {
        Situation { time, joints, modes: &self.modes, commands }
    }
}

/// The situation in which the laws of all joints are evaluated.
#[derive(Debug, Clone, Copy)]
pub struct Situation<'a> {
    /// `t` [s].
    pub time: f64,
    /// One per joint.
    pub joints: &'a [Phase],
    /// One per joint.
    pub modes: &'a [Mode],
    /// [A] one per joint.
    pub commands: &'a [f64],
}

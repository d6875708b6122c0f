//! Actions of an effect in a simulated machine: where it acts, and which quantities it reads.

use crate::gearhead::{Memory, Mesh};

/// State of one joint at one instant, for the laws between rotor and link. Joint side, SI.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointState {
    /// `t` [s] since the start of the session.
    pub time: f64,
    /// `θ` [rad or m] Rotor angle divided by the gear ratio.
    pub motor_position: f64,
    /// `θ̇` [rad/s or m/s].
    pub motor_velocity: f64,
    /// `q` [rad or m] Link position; where axes are coupled, that of the gear's output, `(C q)_i`.
    pub link_position: f64,
    /// `q̇` [rad/s or m/s] Velocity of the same.
    pub link_velocity: f64,
    /// `T` [N·m or N] Torque through the gear; positive drives the link in positive direction.
    pub gear_torque: f64,
    /// `i` [A] motor current.
    pub current: f64,
    /// State of friction with memory ([`Memory`]); 0 without memory.
    pub memory: f64,
}

/// Action of an effect on a joint while it moves. Every method does nothing by default.
pub trait JointAction: Send + Sync {
    /// Friction level [N·m or N] (≥ 0) of the whole joint in the direction in which the state moves or is about to move. `level` is
    /// the level by the law and earlier effects, viscous part included. It acts on rotor and link in the law's shares;
    /// both velocities of the state are those of the side in question. A side at rest has the smallest nonzero velocity
    /// in the direction in which it is about to move, so the sign of a velocity always gives the direction.
    fn dry_friction(&self, _state: &JointState, level: f64) -> f64 {
        level
    }
    /// Torque added to the rotor [N·m or N], positive in positive direction; must be smooth in the state.
    fn motor_torque(&self, _state: &JointState) -> f64 {
        0.0
    }
    /// Torque added to the link [N·m or N], positive in positive direction; must be smooth in the state, whose link position and velocity are those
    /// of the joint also where axes are coupled.
    fn link_torque(&self, _state: &JointState) -> f64 {
        0.0
    }
    /// [rad/s] Fastest oscillation that it causes at a speed [rad/s or m/s] of the rotor: the time steps have to resolve it.
    fn fastest(&self, _speed: f64) -> f64 {
        0.0
    }
}

/// Action of an effect on the flanks of a gear.
pub trait GearAction: Send + Sync {
    /// Alters the position of the flanks at a time [s] and a rotor angle [rad or m]; smooth in both, with consistent slopes.
    fn alter(&self, time: f64, theta: f64, mesh: &mut Mesh);
    /// [rad/s] Fastest oscillation that it causes at a speed [rad/s or m/s] of the rotor: the time steps have to resolve it.
    fn fastest(&self, _speed: f64) -> f64 {
        0.0
    }
}

/// Action of an effect on the command of a drive.
pub trait DriveAction: Send + Sync {
    /// Current [A] that the power stage receives as its command, for a command [A] within its limit.
    fn command(&self, command: f64) -> f64;
}

/// Action of an effect between the motor shaft and its encoder.
pub trait EncoderAction: Send {
    /// Position [rad or m] and velocity [rad/s or m/s] that the encoder reads, before quantisation.
    fn seen(&self, position: f64, velocity: f64) -> (f64, f64);
}

/// A stop for a link, a one-sided spring: `k (q − place) + c q̇` while the link touches it; it never pulls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// +1 where it stops q > place, −1 where it stops q < place.
    pub side: f64,
    /// [rad or m] Position at which it is touched.
    pub place: f64,
    /// `k` [N·m/rad or N/m] > 0.
    pub stiffness: f64,
    /// `c` [N·m·s/rad or N·s/m] ≥ 0.
    pub damping: f64,
}

/// Readings of a joint's sensors at a sampling instant. Joint side, SI.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reading {
    /// [rad or m] quantised motor position.
    pub position: f64,
    /// [rad/s or m/s]
    pub velocity: f64,
    /// [A]
    pub current: f64,
    /// [rad or m] quantised link position, where the joint has a second encoder.
    pub link_position: Option<f64>,
}

/// Action of an effect on the readings of a joint, once per sampling instant, after the sensors.
pub trait SensorAction: Send {
    /// Alters a reading taken at `time` [s].
    fn alter(&mut self, time: f64, reading: &mut Reading);
}

/// An active effect in a simulated machine.
pub enum Action {
    /// On the joint with this index.
    Joint(usize, Box<dyn JointAction>),
    /// On the readings of the joint with this index.
    Sensor(usize, Box<dyn SensorAction>),
    /// On the flanks of the gear of the joint with this index.
    Gear(usize, Box<dyn GearAction>),
    /// On the commands of the drive of the joint with this index.
    Drive(usize, Box<dyn DriveAction>),
    /// On the encoder input of the joint with this index.
    Encoder(usize, Box<dyn EncoderAction>),
    /// On the friction of the joint with this index, which then has a memory: one memory per joint.
    Friction(usize, Memory),
    /// A stop in the way of the link of the joint with this index.
    Stop(usize, Stop),
}

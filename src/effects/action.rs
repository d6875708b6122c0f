//! What an effect does in a simulated machine: where it takes hold, and what it sees there.

use crate::gearhead::{Memory, Mesh};

/// One joint at one instant, as the laws between rotor and link see it. Joint side, SI.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointState {
    /// `t` [s] since the start of the session.
    pub time: f64,
    /// `θ` [rad or m] rotor angle divided by the gear ratio.
    pub motor_position: f64,
    /// `θ̇` [rad/s or m/s].
    pub motor_velocity: f64,
    /// `q` [rad or m] link.
    pub link_position: f64,
    /// `q̇` [rad/s or m/s].
    pub link_velocity: f64,
    /// `T` [N·m or N] through the gear, positive drives the link positively.
    pub gear_torque: f64,
    /// `i` [A] motor current.
    pub current: f64,
    /// State of what friction remembers ([`Memory`]), 0 where it remembers nothing.
    pub memory: f64,
}

/// What an effect does to a joint while it moves. Every method defaults to nothing.
pub trait JointAction: Send + Sync {
    /// Friction level [N·m or N] (≥ 0) of the whole joint in the direction that the state moves or is about to move, given
    /// the level, viscous part included, that the law and earlier effects yield. Acts on rotor and link in the law's shares;
    /// both velocities of the state are that of the side in question. A side at rest has the smallest velocity there is
    /// in the direction in which it is about to move, so that the sign of a velocity always tells the direction.
    fn dry_friction(&self, _state: &JointState, level: f64) -> f64 {
        level
    }
    /// Torque added to the rotor [N·m or N], positive drives positively; must be smooth in the state.
    fn motor_torque(&self, _state: &JointState) -> f64 {
        0.0
    }
    /// Torque added to the link [N·m or N], positive drives positively; must be smooth in the state.
    fn link_torque(&self, _state: &JointState) -> f64 {
        0.0
    }
    /// [rad/s] Fastest oscillation that it brings at a speed [rad/s or m/s] of the rotor: steps have to resolve it.
    fn fastest(&self, _speed: f64) -> f64 {
        0.0
    }
}

/// What an effect does to the flanks of a gear.
pub trait GearAction: Send + Sync {
    /// Alters where the flanks stand at a time [s] and a rotor angle [rad or m]; smooth in both, slopes in accordance.
    fn alter(&self, time: f64, theta: f64, mesh: &mut Mesh);
    /// [rad/s] Fastest oscillation that it brings at a speed [rad/s or m/s] of the rotor: steps have to resolve it.
    fn fastest(&self, _speed: f64) -> f64 {
        0.0
    }
}

/// What an effect does to the command of a drive.
pub trait DriveAction: Send + Sync {
    /// Current [A] that the power stage is told to make of a command [A] within its limit.
    fn command(&self, command: f64) -> f64;
}

/// What an effect does between the motor shaft and its encoder.
pub trait EncoderAction: Send {
    /// Position [rad or m] and velocity [rad/s or m/s] that the encoder sees, before it counts.
    fn seen(&self, position: f64, velocity: f64) -> (f64, f64);
}

/// Something that a link runs up against, a one-sided spring: `k (q − place) + c q̇` on the side on which it is touched, never pulling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// +1 where it stops q > place, −1 where it stops q < place.
    pub side: f64,
    /// [rad or m].
    pub place: f64,
    /// `k` [N·m/rad or N/m] > 0.
    pub stiffness: f64,
    /// `c` [N·m·s/rad or N·s/m] ≥ 0.
    pub damping: f64,
}

/// What a joint's sensors report at a sampling instant. Joint side, SI.
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

/// What an effect does to the readings of a joint, once a sampling instant, after the sensors themselves.
pub trait SensorAction: Send {
    /// Alters a reading taken at `time` [s].
    fn alter(&mut self, time: f64, reading: &mut Reading);
}

/// An effect at work in a simulated machine.
pub enum Action {
    /// On the joint of this index.
    Joint(usize, Box<dyn JointAction>),
    /// On the readings of the joint of this index.
    Sensor(usize, Box<dyn SensorAction>),
    /// On the flanks of the gear of this joint.
    Gear(usize, Box<dyn GearAction>),
    /// On the commands of the drive of this joint.
    Drive(usize, Box<dyn DriveAction>),
    /// On what the encoder of this joint sees.
    Encoder(usize, Box<dyn EncoderAction>),
    /// On the friction of this joint, which remembers its motion: one memory a joint.
    Friction(usize, Memory),
    /// In the way of the link of this joint.
    Stop(usize, Stop),
}

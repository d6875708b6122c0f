//! What an effect does in a simulated machine: where it takes hold, and what it sees there.

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
}

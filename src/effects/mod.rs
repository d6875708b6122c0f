//! The catalogue: what can make a measured arm differ from its simulation. One effect, one file.
//!
//! An effect has two faces. In the simulation it alters the model or acts on joints and readings ([`Effect::install`]).
//! In a diagnosis it says which torque it would add to the measured motion.

pub mod about;
pub mod motion;
mod parameters;

mod base_tilt;
mod cable_spring;
mod cogging;
mod coulomb_asymmetry;
mod current_offset;
mod load_dependent_friction;
mod payload;
mod position_dependent_friction;
mod quadratic_drag;
mod sensor_delay;
mod stribeck;
mod viscous_asymmetry;

pub use about::{About, Kind, ParameterSpec, Scope};
pub use motion::{JointMotion, Motion, SymmetricFriction};
pub use parameters::Parameters;

use std::collections::BTreeMap;

use crate::error::Result;
use crate::robot::Model;

/// Every effect that can be installed and diagnosed, in alphabetical order.
pub static CATALOGUE: &[&dyn Effect] = &[
    &base_tilt::BaseTilt,
    &cable_spring::CableSpring,
    &cogging::Cogging,
    &coulomb_asymmetry::CoulombAsymmetry,
    &current_offset::CurrentOffset,
    &load_dependent_friction::LoadDependentFriction,
    &payload::Payload,
    &position_dependent_friction::PositionDependentFriction,
    &quadratic_drag::QuadraticDrag,
    &sensor_delay::SensorDelay,
    &stribeck::Stribeck,
    &viscous_asymmetry::ViscousAsymmetry,
];

/// The effect of that name.
pub fn find(name: &str) -> Option<&'static dyn Effect> {
    CATALOGUE.iter().copied().find(|effect| effect.name() == name)
}

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

/// An entry of the catalogue.
///
/// In a diagnosis an effect adds `Σ c_k · column_k` to the torque that the baseline needs for the measured motion.
/// The coefficients `c_k` are linear; what is not linear (an order, a radius) is a *shape*: a few starting values to scan, then refined.
pub trait Effect: Sync {
    /// What is known about it.
    fn about(&self) -> &'static About;

    /// Its name, a contract: `lostmotion list effects`, model files, reports.
    fn name(&self) -> &'static str {
        self.about().name
    }

    /// Puts it into a machine: alters the model, returns what acts while it moves.
    ///
    /// # Errors
    /// A parameter is missing, unknown or out of its range; the joint is missing where one is needed.
    fn install(
        &self,
        model: &mut Model,
        joint: Option<usize>,
        parameters: &BTreeMap<String, f64>,
    ) -> Result<Vec<Action>>;

    /// Whether the nominal model lacks it on this joint and the recording could show it.
    fn applies(&self, _motion: &Motion, _joint: usize) -> bool {
        true
    }

    /// Shapes to scan; one empty shape where everything is linear.
    fn shapes(&self, _motion: &Motion, _joint: usize) -> Vec<Vec<f64>> {
        vec![Vec::new()]
    }

    /// Whether a shape may be refined between the scanned ones.
    fn refines(&self) -> bool {
        true
    }

    /// Whether a joint can have several of it, told apart by their shapes.
    fn repeats(&self) -> bool {
        false
    }

    /// Whether its two coefficients are a cosine and a sine of the motor angle, whose zero an incremental encoder sets anew in every session.
    fn phase_per_session(&self) -> bool {
        false
    }

    /// Torque on a joint [N·m or N] per unit of each coefficient, one value a row: what the motor must add to the baseline.
    /// For an effect of the whole machine the coefficients are the same on every joint.
    fn columns(&self, motion: &Motion, joint: usize, shape: &[f64]) -> Vec<Vec<f64>>;

    /// Its parameters where the current is seen to lag behind the motion by `lag` [s], if that is what it does.
    fn of_lag(&self, _lag: f64) -> Option<Vec<f64>> {
        None
    }

    /// [A] What the current sensor of its joint reads while no current flows.
    fn reading_at_rest(&self, _coefficients: &[f64]) -> f64 {
        0.0
    }

    /// Its parameters from the coefficients, in the order of [`About::parameters`]; those with a default may be missing at the end.
    fn parameters(&self, motion: &Motion, joint: usize, shape: &[f64], coefficients: &[f64]) -> Vec<f64>;
}

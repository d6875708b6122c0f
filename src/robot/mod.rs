//! What the machine is: kinematic tree, inertias, collision shapes, and the model file. No engine types.

pub mod model;
pub mod tree;

pub use model::{EffectEntry, JointModel, Model};
pub use tree::{Body, Geometry, Inertia, Joint, Limits, Robot, Shape};

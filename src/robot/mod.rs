//! The machine's description: kinematic tree, inertias, collision shapes, and the model file. No engine types.

mod accuracy;
mod coupling;
mod inertia;
mod joint;
pub mod model;
mod ranges;
mod read;
mod remark;
pub mod tree;
mod urdf;
mod write;

pub use accuracy::Accuracy;
pub use coupling::Coupling;
pub use model::{EffectEntry, JointModel, Load, Masses, Model, TorqueAt};
pub use remark::Remark;
pub use tree::{Body, Geometry, Inertia, Joint, Limits, Robot, Shape, UnreadShape};
pub use urdf::STANDARD_GRAVITY;

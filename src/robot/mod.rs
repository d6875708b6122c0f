//! The machine's description: kinematic tree, inertias, collision shapes, and the model file. No engine types.

mod accuracy;
mod coupling;
mod drives;
mod first;
mod format;
mod inertia;
mod joint;
mod mesh;
mod mjcf;
pub mod model;
mod placeholders;
mod ranges;
mod read;
mod remark;
mod robot_file;
pub mod tree;
mod urdf;
mod write;

pub use accuracy::{Accuracy, LEAST_FACTOR};
pub use coupling::Coupling;
pub use first::{First, two_digits};
pub use model::{EffectEntry, JointModel, Load, Masses, Model, TorqueAt, USUAL_RESONANCE};
pub use placeholders::{Placeholders, marked_lines};
pub use remark::Remark;
pub use tree::{Body, DrawnMesh, Geometry, Inertia, Joint, Limits, Robot, STANDARD_GRAVITY, Shape, UnreadShape};

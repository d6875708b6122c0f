//! Torque laws between rotor and link: friction, dead zone, mesh; pure functions of the state.
//!
//! Everything is on the joint side: rotor angle `θ = θ_m / ratio`, gear torque `T` positive when it drives the link positively.

pub mod dead_zone;
pub mod friction;
pub mod memory;
pub mod mesh;

pub use dead_zone::DeadZone;
pub use friction::{Direction, Exponential, Friction, FrictionLaw, Lines, TwoLines};
pub use memory::Memory;
pub use mesh::Mesh;

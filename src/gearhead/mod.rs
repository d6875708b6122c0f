//! Torque laws between rotor and link: friction and dead zone, pure functions of the state.
//!
//! Everything is on the joint side: rotor angle `θ = θ_m / ratio`, gear torque `T` positive when it drives the link positively.

pub mod dead_zone;
pub mod friction;

pub use dead_zone::DeadZone;
pub use friction::{Direction, Exponential, Friction, FrictionLaw, Lines, TwoLines};

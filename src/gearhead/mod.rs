//! The gearhead of a joint, between rotor and link: torque laws, pure functions of the state.
//!
//! ```text
//!            rotor side            flanks            link side
//!   J θ̈ ◄──── F_r(θ̇) ────┤ T(x, ẋ), gap b ├──── F_l(q̇) ────► link          x = θ − q
//! ```
//! [`Gearhead`] is the component: friction of the rotor side and of the link side ([`Grip`]), and the flanks between them
//! ([`DeadZone`]). The simulated machine, its effects, and the gear models of identification and diagnosis use these laws.
//! Everything is on the joint side: rotor angle `θ = θ_m / ratio`.
//! Sign: `T` positive drives the link positively and brakes the rotor; friction is subtracted from the torque that drives its side.
//! Left out: inertia, which belongs to the machine; losses that grow with the load are an effect.

pub mod component;
pub mod dead_zone;
pub mod friction;
pub mod grip;
pub mod memory;
pub mod mesh;
pub mod rigid;
pub mod slip;

pub use component::Gearhead;
pub use dead_zone::{DeadZone, Flank};
pub use friction::{Direction, Exponential, Friction, FrictionLaw, Lines, TwoLines, slowed};
pub use grip::Grip;
pub use memory::Memory;
pub use mesh::Mesh;
pub use slip::Slip;

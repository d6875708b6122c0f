//! Recordings → rows of smooth motion and torque, and which of them are fitted.

pub mod division;
pub mod gentlest;
pub mod inertia;
pub mod kernel;
pub mod observe;
pub mod reversals;
pub mod side_by_side;
pub mod standstill;
pub mod zones;

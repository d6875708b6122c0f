//! Recordings → rows of smooth motion and torque, and which of them are fitted.
//!
//! `observe` makes the rows, with the `kernel`; `division` says which rows are trained on and which are held out;
//! `zones` finds the rows in which the links follow the rotors; `reversals` gives times since reversals and rests;
//! `standstill` reads currents before the first motion; `gentlest` picks sessions with gentle reversals;
//! `inertia` gives a typical inertia of each joint; `side_by_side` runs work on joints in parallel within a memory limit.

pub mod division;
pub mod gentlest;
pub mod inertia;
pub mod kernel;
pub mod observe;
pub mod reversals;
pub mod side_by_side;
pub mod standstill;
pub mod zones;

//! Candidates → the effects that evidence and gain support.

pub mod candidates;
pub mod confirm;
pub mod findings;
pub mod own_gains;
pub mod selection;
pub mod substitutes;

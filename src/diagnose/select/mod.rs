//! Candidates → the effects that evidence and held-out gain support.
//!
//! Takes a regression problem and the catalogue. Gives the effects that are named, with gains, rivals and probability, and those withdrawn.
//! - `candidates`: the best term of each effect on each joint, with its evidence; its `loads`: those of the whole machine beside guessed torque constants
//! - `selection`: takes effects by evidence, one after the other
//! - `residues`: what moves little torque beside another effect, and comes back without it
//! - `masked`: two effects of one joint, neither of which has evidence without the other
//! - `substitutes`: withdraws names that a pattern describes better
//! - `confirm`: withdraws effects without a gain on held-out data; `own_gains`: these gains
//! - `naming`: both, and effects in the place of those withdrawn
//! - `certainty`: rivals and probability of a name
//! - `findings`: from the remaining terms to the entries of a report

pub mod candidates;
pub mod certainty;
pub mod confirm;
pub mod findings;
pub mod masked;
pub mod naming;
pub mod oddity;
pub mod own_gains;
pub mod residues;
pub mod selection;
pub mod substitutes;

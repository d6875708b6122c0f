//! Candidates → the effects that evidence and held-out gain support.
//!
//! `candidates` finds the best term of each effect; `selection` takes effects by evidence, one after the other; `substitutes` withdraws
//! names that a pattern describes better; `confirm` withdraws effects without a gain on held-out data, with the gains from `own_gains`;
//! `findings` turns the remaining terms into the entries of a report.

pub mod candidates;
pub mod confirm;
pub mod findings;
pub mod own_gains;
pub mod selection;
pub mod substitutes;

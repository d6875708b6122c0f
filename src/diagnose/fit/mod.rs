//! Rows and terms → a robust fit with its uncertainty.
//!
//! `pose` builds the regression `problem` from sessions; `baseline` has the free terms of the nominal model, `cause` the effects and
//! their changes; `regression` solves linear systems with a heavy-tailed error, `uncertainty` gives standard errors, `estimate` parameters
//! with these errors. `typical` scales an effect to a typical strength; `golden` is the golden section search.

pub mod baseline;
pub mod cause;
pub mod estimate;
pub mod golden;
pub mod pose;
pub mod problem;
pub mod regression;
pub mod typical;
pub mod uncertainty;

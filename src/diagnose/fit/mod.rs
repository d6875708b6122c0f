//! Rows and terms → a robust fit with its uncertainty.
//!
//! Takes rows and the terms of a model. Gives coefficients, shapes and Stribeck velocities with standard errors.
//! - `pose`: from sessions to the regression problem
//! - `posture`: what unknown gaps and wind-ups do to the weight of the links
//! - `problem`: rows, zones, parts of the data; `term`: a cause in a fit
//! - `assembly`: the system of equations of a fit, and its solution
//! - `stribeck`: the Stribeck velocities that suit the terms
//! - `new_sessions`: what is freed in held-out sessions without training rows
//! - `baseline`: the free parameters of the nominal model
//! - `inertial`: deviations of the nominal model within its stated accuracy; `view`: what one joint's rows can decide of them; `deviations`: fits
//!   with them; `expansion`: the product of two of them
//! - `extrapolation`: how far a fit can be off in rows that it does not contain
//! - `cause`: the cause of a term, an effect or the change of an effect
//! - `regression`: linear regression with a heavy-tailed error; `scanned`: some thousand of its rows, for scans of many shapes
//! - `uncertainty`: standard errors by a jackknife over blocks of time
//! - `estimate`: parameters with standard errors
//! - `torque_scale`: the scale of the torque that is computed from a current
//! - `typical`: an effect of typical strength
//! - `golden`: golden section search

pub mod assembly;
pub mod baseline;
pub mod cause;
mod deviations;
pub mod estimate;
mod expansion;
pub mod extrapolation;
pub mod golden;
pub mod inertial;
mod new_sessions;
pub mod pose;
mod posture;
pub mod problem;
pub mod regression;
pub mod scanned;
mod stribeck;
pub mod term;
pub mod torque_scale;
pub mod typical;
pub mod uncertainty;
mod view;

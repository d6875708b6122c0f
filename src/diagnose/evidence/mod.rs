//! A fit → evidence, probability, and separability of effects.
//!
//! Takes a fit and gives the evidence for an effect, its probability, and the rivals that the recording cannot separate from it.
//! - `prediction`: likelihood of rows that were not used for a fit, and the evidence from it
//! - `local_level`: independent samples of the residual for a line at a given order
//! - `prewhitened`: rows after a filter that makes their errors white
//! - `probability`: calibrated probability of a named effect
//! - `separability`: how well a recording separates an effect from all others
//! - `patterns`: shapes without physics; `oscillation`: one in time; `pattern_search`: the best of them for a residual

pub mod local_level;
mod oscillation;
pub mod pattern_search;
pub mod patterns;
pub mod prediction;
mod prewhitened;
pub mod probability;
pub mod separability;

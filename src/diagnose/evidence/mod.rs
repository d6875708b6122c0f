//! A fit → evidence, probability, and separability of effects.
//!
//! `prediction` gives the likelihood of held-out folds and the evidence from it; `probability` the calibrated probability;
//! `separability` how well a recording separates an effect from all others; `patterns` the shapes without physics, and
//! `pattern_search` the best of them for a residual.

pub mod pattern_search;
pub mod patterns;
pub mod prediction;
pub mod probability;
pub mod separability;

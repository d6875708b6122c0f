//! A fit → evidence, probability, and how well effects can be told apart.

pub mod pattern_search;
pub mod patterns;
pub mod prediction;
pub mod probability;
pub mod separability;

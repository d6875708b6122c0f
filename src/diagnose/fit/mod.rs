//! Rows and terms → a robust fit with its uncertainty.

pub mod baseline;
pub mod cause;
pub mod estimate;
pub mod golden;
pub mod pose;
pub mod problem;
pub mod regression;
pub mod typical;
pub mod uncertainty;

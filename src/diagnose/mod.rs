//! What the simulation gets wrong, and why: residual, candidates, selection, extension, gain.

/// What a diagnosis returns.
pub mod result;

pub use result::{
    Axis, BaselineEstimate, CandidateRecord, Diagnosis, FitError, FoundEffect, Measured, Method, OrderSpectrum,
    ReplayError, ResidualMap, ResidualSeries, Split, Unexplained, Verdict,
};

//! Rows and a fit → the residual: errors, gains, maps, shares, spectra, and the floor of the sensors.
//!
//! `errors` gives error figures and the residual per sample; `gains` the gains on held-out data, with the interval of `gain_interval`;
//! `maps` the mean residual in bins, with the bins of `axes`; `shares` the share of the error per zone and per quantity;
//! `spectra` the spectra against order and frequency; `floor` the error due to the sensors alone.

pub mod axes;
pub mod errors;
pub mod floor;
pub mod gain_interval;
pub mod gains;
pub mod maps;
pub mod shares;
pub mod spectra;

/// Residuals of all rows of one joint.
pub struct Residual {
    /// Residual of the nominal model, fitted by plain least squares.
    pub before: Vec<f64>,
    /// Residual with the effects.
    pub after: Vec<f64>,
}

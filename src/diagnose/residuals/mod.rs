//! Rows and a fit → the residual: errors, gains, maps, shares, spectra, and the floor of the sensors.
//!
//! Takes the rows and a finished fit. Gives the figures, maps and spectra of a report.
//! - `errors`: error figures, and the residual per sample; `carried_over`: what held-out data leave, beside training data
//! - `gains`: gains on held-out data; `gain_interval`: their confidence interval
//! - `maps`: mean residual in bins; `axes`: the quantities and their bins
//! - `shares`: share of the squared error per zone and per quantity
//! - `spectra`: spectra against order and frequency
//! - `floor`: the error due to the sensors alone

pub mod axes;
pub mod carried_over;
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

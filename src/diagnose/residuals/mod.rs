//! Rows and a fit → what is left: errors, gains, maps, shares, spectra, and the floor of the sensors.

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
    /// Without effects, fitted by plain least squares.
    pub before: Vec<f64>,
    /// With the effects.
    pub after: Vec<f64>,
}

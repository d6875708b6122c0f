//! Reading of the current sensor: noise, then rectification, then the converter.
//!
//! ```text
//!   a = i + n,  n ~ N(0, σ²)        the amplifier's noise adds to the voltage of the shunt
//!   a = |a|     sensing = absolute  the bridge's lower legs carry the current in one direction only; noise is rectified too
//!   reading = r round(a/r)          the converter comes last: what is stored is a multiple of r
//! ```
//!
//! The order matters near zero current: rectified noise has the mean `σ √(2/π)`, not zero.
//! Left out: offset and gain error of the amplifier, range of the converter.

use super::noise::Noise;
use super::{CurrentSensor, Sensing};

impl CurrentSensor {
    /// Reading [A] of a current [A].
    pub fn read(&self, current: f64, noise: &mut Noise) -> f64 {
        let mut a = current + if self.noise > 0.0 { self.noise * noise.gaussian() } else { 0.0 };
        if self.sensing == Sensing::Absolute {
            a = a.abs();
        }
        if self.resolution > 0.0 { self.resolution * (a / self.resolution).round() } else { a }
    }
}

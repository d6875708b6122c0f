//! An effect that is a line at an order: it repeats with an angle.

use super::Motion;

/// How an effect repeats with the angle of its joint.
///
/// Its two coefficients are a cosine and a sine of that angle, whose zero an incremental encoder sets anew in every session.
#[derive(Clone, Copy)]
pub struct Harmonic {
    /// Periods per turn (or metre) of the joint, of a motion, joint and shape.
    pub order: fn(&Motion, usize, &[f64]) -> f64,
    /// Whether a joint can have several of it, told apart by their orders.
    pub several: bool,
    /// Its columns if its line lay at another order. Given where it shows in the acceleration, at orders that wide kernels do not pass: it is
    /// then sought in narrow rows, and compared with its neighbours.
    pub in_narrow_rows: Option<fn(&Motion, usize, f64) -> Vec<Vec<f64>>>,
}

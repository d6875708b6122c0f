//! Harmonic effects: they repeat with an angle, so they are a line at an order.

use super::Motion;

/// Columns of a line, of a motion, joint and order.
pub type Columns = fn(&Motion, usize, f64) -> Vec<Vec<f64>>;

/// How an effect repeats with the angle of its joint.
///
/// Its two coefficients are a cosine and a sine of that angle. An incremental encoder sets the zero of the angle anew in every session.
#[derive(Clone, Copy)]
pub struct Harmonic {
    /// Periods per turn (or metre) of the joint, for a motion, joint and shape.
    pub order: fn(&Motion, usize, &[f64]) -> f64,
    /// Whether a joint can have several of them with different orders.
    pub several: bool,
    /// Its columns at any other order. Given if the effect shows in the acceleration at orders that wide kernels filter out: it is
    /// then sought in narrow rows, and compared with neighbouring orders.
    pub in_narrow_rows: Option<Columns>,
}

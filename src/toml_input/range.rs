//! Allowed range of a number in a file.

use std::fmt;

/// An interval with a unit. Numbers in files are always finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    min: f64,
    max: f64,
    /// Whether `min` itself is refused.
    open: bool,
    unit: &'static str,
}

impl Range {
    /// Any finite number.
    pub const fn any(unit: &'static str) -> Self {
        Self { min: f64::NEG_INFINITY, max: f64::INFINITY, open: false, unit }
    }

    /// Above zero.
    pub const fn positive(unit: &'static str) -> Self {
        Self { min: 0.0, max: f64::INFINITY, open: true, unit }
    }

    /// Zero or above.
    pub const fn non_negative(unit: &'static str) -> Self {
        Self { min: 0.0, max: f64::INFINITY, open: false, unit }
    }

    /// `min` to `max`, both allowed.
    pub const fn between(min: f64, max: f64, unit: &'static str) -> Self {
        Self { min, max, open: false, unit }
    }

    /// The same with an upper bound.
    pub const fn up_to(self, max: f64) -> Self {
        Self { max, ..self }
    }

    /// Whether a number is finite and inside the range.
    pub fn holds(&self, value: f64) -> bool {
        value.is_finite() && value >= self.min && value <= self.max && !(self.open && value == self.min)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [min, max] = [self.min, self.max].map(short);
        match (self.min.is_finite(), self.max.is_finite()) {
            (true, true) if self.open => write!(f, "a number > {min} and ≤ {max}")?,
            (true, true) => write!(f, "a number from {min} to {max}")?,
            (true, false) => write!(f, "a number {} {min}", if self.open { ">" } else { "≥" })?,
            (false, true) => write!(f, "a number ≤ {max}")?,
            (false, false) => write!(f, "a finite number")?,
        }
        write!(f, " [{}]", self.unit)
    }
}

/// A bound, written with its shortest digits.
fn short(value: f64) -> String {
    let plain = value == 0.0 || (1e-3..1e5).contains(&value.abs());
    if plain { value.to_string() } else { format!("{value:e}") }
}

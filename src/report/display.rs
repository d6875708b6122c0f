//! Units for readers: files use SI and radians, reports use degrees.

use crate::units::DEG;

use super::number;

/// The displayed unit of a quantity with that SI unit, and the factor from SI to it.
pub fn shown(unit: &str) -> (&str, f64) {
    match unit {
        "rad" => ("deg", 1.0 / DEG),
        "rad/s" => ("deg/s", 1.0 / DEG),
        "rad/s²" => ("deg/s²", 1.0 / DEG),
        "N·m·s/rad" => ("N·m·s/deg", DEG),
        "N·m/rad" => ("N·m/deg", DEG),
        "m" => ("mm", 1000.0),
        "m/s" => ("mm/s", 1000.0),
        "m/s²" => ("mm/s²", 1000.0),
        other => (other, 1.0),
    }
}

/// A value of that SI unit for readers, with four significant digits and the unit.
pub fn value(value: f64, unit: &str) -> String {
    let (unit, factor) = shown(unit);
    join(&number::significant(value * factor, 4), unit)
}

/// A value and its standard error for readers, with the unit.
pub fn estimate(value: f64, std_error: f64, unit: &str) -> String {
    let (unit, factor) = shown(unit);
    // A choice among a few values, such as the order of a harmonic, is exact.
    if std_error == 0.0 {
        let value = value * factor;
        let whole = value.fract() == 0.0;
        return join(&if whole { format!("{value:.0}") } else { number::significant(value, 6) }, unit);
    }
    let (value, std_error) = number::with_error(value * factor, std_error * factor);
    join(&format!("{value} ± {std_error}"), unit)
}

/// A number and its unit; a dimensionless number has none.
pub fn join(number: &str, unit: &str) -> String {
    match unit {
        "" | "1" => number.to_owned(),
        "deg" => format!("{number}°"),
        unit => format!("{number} {unit}"),
    }
}

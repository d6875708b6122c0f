//! Limits of a simulation: `--max-memory`, `--max-time`.

use clap::Args;

use crate::scenario::{Limits, STEPS_A_SECOND};

/// Options of every command that simulates.
#[derive(Debug, Clone, Copy, Args)]
pub struct LimitOptions {
    /// Refuse a simulation that would take more memory, such as 500MB or 16GB
    #[arg(long, value_name = "SIZE", default_value = "4GB", value_parser = size)]
    max_memory: f64,
    /// Refuse a simulation that would compute for longer on one core, by a cautious estimate
    #[arg(long, value_name = "MINUTES", default_value = "60", value_parser = minutes)]
    max_time: f64,
}

impl LimitOptions {
    /// The limits as a scenario has them.
    pub fn limits(self) -> Limits {
        Limits { memory: self.max_memory, steps: 60.0 * self.max_time * STEPS_A_SECOND }
    }
}

/// Units of memory, decimal and binary.
const UNITS: [(&str, f64); 10] = [
    ("kib", 1024.0),
    ("mib", 1_048_576.0),
    ("gib", 1_073_741_824.0),
    ("tib", 1_099_511_627_776.0),
    ("kb", 1e3),
    ("mb", 1e6),
    ("gb", 1e9),
    ("tb", 1e12),
    ("g", 1e9),
    ("m", 1e6),
];

/// A size of memory [B].
fn size(text: &str) -> Result<f64, String> {
    let expected = || "expected a size above zero with its unit, such as 500MB or 16GB".to_owned();
    let lower = text.trim().to_lowercase();
    let (number, unit) =
        UNITS.iter().find_map(|(unit, size)| Some((lower.strip_suffix(unit)?, *size))).ok_or_else(expected)?;
    let number: f64 = number.trim().parse().map_err(|_| expected())?;
    let size = number * unit;
    if size.is_finite() && size > 0.0 { Ok(size) } else { Err(expected()) }
}

/// A time [min].
fn minutes(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|number| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "expected a number of minutes above zero".to_owned())
}

//! How units are written in names of columns and in rows of units.

use crate::units;

/// A unit of a file, as a multiple of a unit of manifests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FileUnit {
    /// Name in manifests, see [`units::UNITS`].
    pub(super) name: &'static str,
    /// Size in that unit.
    pub(super) scale: f64,
}

impl FileUnit {
    /// Quantity of the unit, and its size in SI units.
    pub(super) fn si(self) -> Option<(units::Dimension, f64)> {
        units::unit(self.name).map(|(dimension, factor)| (dimension, factor * self.scale))
    }
}

/// Spellings in lower case, blanks left out; the unit of manifests; its size in that unit.
const SPELLINGS: [(&[&str], &str, f64); 31] = [
    (&["s", "sec", "secs", "second", "seconds"], "s", 1.0),
    (&["ms", "msec", "millis", "milliseconds"], "ms", 1.0),
    (&["us", "µs", "μs", "usec", "micros", "microseconds"], "us", 1.0),
    (&["ns", "nsec", "nanos", "nanoseconds"], "ns", 1.0),
    (&["rad", "rads", "radian", "radians"], "rad", 1.0),
    (&["mrad"], "rad", 1e-3),
    (&["deg", "degs", "degree", "degrees", "°"], "deg", 1.0),
    (&["mdeg"], "deg", 1e-3),
    (&["rev", "revs", "turn", "turns"], "deg", 360.0),
    (&["m", "meter", "meters", "metre", "metres"], "m", 1.0),
    (&["cm"], "mm", 10.0),
    (&["mm"], "mm", 1.0),
    (&["um", "µm", "μm"], "mm", 1e-3),
    (&["rad/s", "rad/sec", "rads/s", "rad*s^-1", "rads^-1", "rads-1", "rad·s⁻¹", "1/s"], "rad/s", 1.0),
    (&["mrad/s"], "rad/s", 1e-3),
    (&["deg/s", "deg/sec", "degs/s", "°/s", "°/sec", "deg·s⁻¹", "dps"], "deg/s", 1.0),
    (&["rev/s", "rps", "turns/s"], "rpm", 60.0),
    (&["rpm", "1/min", "min-1", "min^-1", "rev/min", "u/min"], "rpm", 1.0),
    (&["m/s", "m/sec"], "m/s", 1.0),
    (&["mm/s", "mm/sec"], "m/s", 1e-3),
    (&["a", "amp", "amps", "ampere", "amperes"], "A", 1.0),
    (&["ma"], "mA", 1.0),
    (&["v", "volt", "volts"], "V", 1.0),
    (&["mv"], "V", 1e-3),
    (&["n·m", "nm", "n*m", "n.m", "n-m", "n⋅m"], "N·m", 1.0),
    (&["mn·m", "mnm", "n·mm", "nmm"], "N·m", 1e-3),
    (&["kn·m", "knm"], "N·m", 1e3),
    (&["n", "newton", "newtons"], "N", 1.0),
    (&["kn"], "N", 1e3),
    (&["°c", "degc", "celsius", "c"], "°C", 1.0),
    (&["d", "day", "days"], "d", 1.0),
];

/// The unit with this spelling.
pub(super) fn unit_of(text: &str) -> Option<FileUnit> {
    let folded: String = text.chars().filter(|c| !c.is_whitespace()).flat_map(char::to_lowercase).collect();
    let known = SPELLINGS.iter().find(|(spellings, ..)| spellings.contains(&folded.as_str()));
    known.map(|&(_, name, scale)| FileUnit { name, scale })
}

/// The text without brackets around it.
pub(super) fn bare(text: &str) -> &str {
    let text = text.trim();
    let inside = [('[', ']'), ('(', ')'), ('{', '}'), ('<', '>')]
        .into_iter()
        .find_map(|(open, close)| text.strip_prefix(open)?.strip_suffix(close));
    inside.unwrap_or(text).trim()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_every_spelling_stands_for_a_unit_of_manifests() {
        let mut seen = std::collections::HashSet::new();
        for (spellings, name, _) in SPELLINGS {
            assert!(units::unit(name).is_some(), "{name}");
            for spelling in spellings {
                assert!(seen.insert(*spelling), "{spelling} twice");
                assert_eq!(
                    unit_of(&spelling.to_uppercase()).map(|unit| unit.name),
                    unit_of(spelling).map(|unit| unit.name)
                );
            }
        }
        assert_eq!(unit_of(bare(" [Deg / s] ")), Some(FileUnit { name: "deg/s", scale: 1.0 }));
        assert_eq!(unit_of("counts"), None);
    }
}

//! Units: everything in memory is SI and radians; conversions happen here and nowhere else.

use std::f64::consts::PI;

/// Radians in a degree.
pub const DEG: f64 = PI / 180.0;

/// [rad/s] in one revolution per minute.
pub const RPM: f64 = PI / 30.0;

/// Whether a joint turns or slides: it decides how its quantities are called.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// Position [rad], velocity [rad/s], effort [N·m].
    Revolute,
    /// Position [m], velocity [m/s], effort [N].
    Prismatic,
}

impl JointKind {
    /// Unit of position: `rad` or `m`.
    pub const fn position_unit(self) -> &'static str {
        match self {
            Self::Revolute => "rad",
            Self::Prismatic => "m",
        }
    }

    /// Unit of effort: `N·m` or `N`.
    pub const fn effort_unit(self) -> &'static str {
        match self {
            Self::Revolute => "N·m",
            Self::Prismatic => "N",
        }
    }
}

//! Units: everything in memory is SI and radians; conversions are made only here.

use std::f64::consts::PI;

/// Radians in a degree.
pub const DEG: f64 = PI / 180.0;

/// [rad/s] in one revolution per minute.
pub const RPM: f64 = PI / 30.0;

/// Whether a joint turns or slides; its quantities have different names and units.
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

    /// Unit of velocity: `rad/s` or `m/s`.
    pub const fn velocity_unit(self) -> &'static str {
        match self {
            Self::Revolute => "rad/s",
            Self::Prismatic => "m/s",
        }
    }

    /// Unit of viscous friction and of damping: `N·m·s/rad` or `N·s/m`.
    pub const fn damping_unit(self) -> &'static str {
        match self {
            Self::Revolute => "N·m·s/rad",
            Self::Prismatic => "N·s/m",
        }
    }

    /// Unit of stiffness: `N·m/rad` or `N/m`.
    pub const fn stiffness_unit(self) -> &'static str {
        match self {
            Self::Revolute => "N·m/rad",
            Self::Prismatic => "N/m",
        }
    }

    /// Unit of wind-up per torque: `rad/(N·m)` or `m/N`.
    pub const fn compliance_unit(self) -> &'static str {
        match self {
            Self::Revolute => "rad/(N·m)",
            Self::Prismatic => "m/N",
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

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// [s]
    Time,
    /// [rad]
    Angle,
    /// [m]
    Length,
    /// [rad/s]
    AngularVelocity,
    /// [m/s]
    Velocity,
    /// [A]
    Current,
    /// [V]
    Voltage,
    /// [N·m]
    Torque,
    /// [N]
    Force,
    /// [°C]
    Temperature,
}

/// The units that files may use: name, quantity, and size in SI units.
pub const UNITS: [(&str, Dimension, f64); 20] = [
    ("s", Dimension::Time, 1.0),
    ("ms", Dimension::Time, 1e-3),
    ("us", Dimension::Time, 1e-6),
    ("µs", Dimension::Time, 1e-6),
    ("ns", Dimension::Time, 1e-9),
    ("d", Dimension::Time, 86_400.0),
    ("rad", Dimension::Angle, 1.0),
    ("deg", Dimension::Angle, DEG),
    ("m", Dimension::Length, 1.0),
    ("mm", Dimension::Length, 1e-3),
    ("rad/s", Dimension::AngularVelocity, 1.0),
    ("deg/s", Dimension::AngularVelocity, DEG),
    ("rpm", Dimension::AngularVelocity, RPM),
    ("m/s", Dimension::Velocity, 1.0),
    ("A", Dimension::Current, 1.0),
    ("mA", Dimension::Current, 1e-3),
    ("V", Dimension::Voltage, 1.0),
    ("N·m", Dimension::Torque, 1.0),
    ("N", Dimension::Force, 1.0),
    ("°C", Dimension::Temperature, 1.0),
];

/// Looks a unit up in [`UNITS`].
pub fn unit(name: &str) -> Option<(Dimension, f64)> {
    UNITS.iter().find(|entry| entry.0 == name).map(|entry| (entry.1, entry.2))
}

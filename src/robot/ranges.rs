//! Ranges of the numbers of a model file. Every range is wider than that of real robots, most by a factor of a hundred or
//! more, and narrow enough that products and squares of its numbers stay finite. A value outside is an error of unit or
//! exponent.

use crate::toml_input::Range;
use crate::units::JointKind;

/// Motor turns per joint motion. A rotary gear of several stages reaches 1e4; a screw of 1 mm behind a gear 1:1000, 6e6 rad/m.
pub(super) fn gear_ratio(kind: JointKind) -> Range {
    match kind {
        JointKind::Revolute => Range::between(1e-4, 1e6, "rad/rad"),
        JointKind::Prismatic => Range::between(1e-3, 1e9, "rad/m"),
    }
}

/// A motor of 2 mm has 1e-12 kg·m², the rotor of a wind turbine 1e7.
pub(super) const ROTOR_INERTIA: Range = Range::between(1e-14, 1e7, "kg·m²");

/// The gear of a heavy robot has 1e7 N·m/rad, a steel screw 1e9 N/m.
pub(super) fn stiffness(kind: JointKind) -> Range {
    match kind {
        JointKind::Revolute => Range::between(1e-6, 1e11, "N·m/rad"),
        JointKind::Prismatic => Range::between(1e-6, 1e12, "N/m"),
    }
}

/// Damping of a gear: its stiffness times a thousandth of a second.
pub(super) fn damping(kind: JointKind) -> Range {
    match kind {
        JointKind::Revolute => Range::non_negative("N·m·s/rad").up_to(1e9),
        JointKind::Prismatic => Range::non_negative("N·s/m").up_to(1e10),
    }
}

/// A gap of more than one turn, or of a metre, is an error.
pub(super) fn backlash(kind: JointKind) -> Range {
    match kind {
        JointKind::Revolute => Range::between(0.0, std::f64::consts::TAU, "rad"),
        JointKind::Prismatic => Range::between(0.0, 1.0, "m"),
    }
}

/// A watch motor has 1e-6, a direct drive of a ton 1e3.
pub(super) const TORQUE_CONSTANT: Range = Range::between(1e-9, 1e5, "N·m/A");

/// Resistance of a winding.
pub(super) const RESISTANCE: Range = Range::positive("Ω").up_to(1e6);

/// Inductance of a winding.
pub(super) const INDUCTANCE: Range = Range::positive("H").up_to(1e4);

/// Voltage of a power stage; the grid has at most 1e5 V.
pub(super) const VOLTAGE: Range = Range::positive("V").up_to(1e6);

/// Current of a power stage.
pub(super) const CURRENT: Range = Range::positive("A").up_to(1e6);

/// Current loops switch at 1 MHz at most, so their time constant is not shorter; ten seconds is the upper bound.
pub(super) const CURRENT_TIME: Range = Range::between(1e-7, 10.0, "s");

/// Encoders resolve up to 2^32 counts a turn.
pub(super) const COUNTS: Range = Range::between(1.0, 1e11, "1/turn");

/// A glass scale resolves 1e-12 m.
pub(super) fn resolution(kind: JointKind) -> Range {
    match kind {
        JointKind::Revolute => Range::between(1e-13, std::f64::consts::TAU, "rad"),
        JointKind::Prismatic => Range::between(1e-13, 1.0, "m"),
    }
}

/// Time constant of a filter of velocities.
pub(super) const FILTER: Range = Range::between(1e-7, 100.0, "s");

/// Noise and resolution of a current sensor.
pub(super) const CURRENT_ERROR: Range = Range::non_negative("A").up_to(1e6);

/// Dry friction. A joint of a heavy robot has 1e3 N·m, a press 1e6 N.
pub(super) fn friction(kind: JointKind) -> Range {
    Range::non_negative(kind.effort_unit()).up_to(1e9)
}

/// Slope of friction against speed; negative if friction falls with speed.
pub(super) fn friction_slope(kind: JointKind) -> Range {
    Range::between(-1e10, 1e10, kind.damping_unit())
}

/// Speed scale of the fall of friction from rest.
pub(super) fn stribeck_velocity(kind: JointKind) -> Range {
    Range::between(1e-9, 1e4, kind.velocity_unit())
}

/// Gravity on the sun is 274 m/s².
pub(super) const GRAVITY: Range = Range::between(-1e3, 1e3, "m/s²");

/// Mass of a load.
pub(super) const MASS: Range = Range::positive("kg").up_to(1e6);

/// Position of a load.
pub(super) const PLACE: Range = Range::between(-1e3, 1e3, "m");

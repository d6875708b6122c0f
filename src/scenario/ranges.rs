//! Ranges of the numbers of a scenario file: wider than real robots by a factor of a hundred or more, and narrow enough
//! that times, distances and counts computed from them stay finite.

use crate::plant::FASTEST_MOTION;
use crate::toml_input::Range;
use crate::units::JointKind;

/// Time between two readings: a drive's own loop runs at up to 1 MHz, a position controller at 1 Hz at least.
pub(super) const CONTROL_PERIOD: Range = Range::between(1e-6, 1.0, "s");

/// Longest interval between two evaluations of the links.
pub(super) const PLANT_STEP: Range = Range::between(1e-6, 0.1, "s");

/// Duration of a rest, a steady time, a recording: at most four months.
pub(super) const DURATION: Range = Range::non_negative("s").up_to(1e7);

/// Duration of a recording.
pub(super) const LENGTH: Range = Range::positive("s").up_to(1e7);

/// [s] Longest session.
pub(super) const LONGEST_SESSION: f64 = 1e7;

/// Speed of a moving joint: from one turn in two months to the fastest motion that the plant allows.
pub(super) fn speed(kind: JointKind) -> Range {
    Range::between(1e-6, FASTEST_MOTION, kind.velocity_unit())
}

/// Acceleration of a joint: from a speed of 0.01 rad/s in 10⁴ s to a speed of 10⁴ rad/s in a millisecond.
pub(super) fn acceleration(kind: JointKind) -> Range {
    Range::between(
        1e-6,
        1e7,
        match kind {
            JointKind::Revolute => "rad/s²",
            JointKind::Prismatic => "m/s²",
        },
    )
}

/// [rad or m] Largest position: a hundred thousand turns, and longer than any axis.
const FARTHEST: f64 = 1e6;

/// Position of a joint.
pub(super) fn position(kind: JointKind) -> Range {
    Range::between(-FARTHEST, FARTHEST, kind.position_unit())
}

/// A position in degrees, in a range that holds that in radians.
pub(super) const DEGREES: Range = Range::between(-FARTHEST * 180.0, FARTHEST * 180.0, "°");

/// Distance travelled by a joint.
pub(super) fn way(kind: JointKind) -> Range {
    Range::between(0.0, FARTHEST, kind.position_unit())
}

/// Gain of a controller from a speed or an angle to a torque.
pub(super) fn gain(unit: &'static str) -> Range {
    Range::non_negative(unit).up_to(1e12)
}

/// The same, but not zero.
pub(super) fn positive_gain(unit: &'static str) -> Range {
    Range::positive(unit).up_to(1e12)
}

/// Torque that is imposed.
pub(super) fn torque(kind: JointKind) -> Range {
    Range::positive(kind.effort_unit()).up_to(1e6)
}

/// Period of a wave: a drive's own loop runs at up to 1 MHz.
pub(super) const PERIOD: Range = Range::between(1e-5, 1e6, "s");

/// Speed within which a controller is linear, or limit of a speed error.
pub(super) fn speed_error(kind: JointKind) -> Range {
    Range::positive(kind.velocity_unit()).up_to(FASTEST_MOTION)
}

/// Side of an obstacle.
pub(super) const SIDE: Range = Range::between(1e-4, 1e3, "m");

/// Position of an obstacle.
pub(super) const PLACE: Range = Range::between(-1e4, 1e4, "m");

/// Orientation of an obstacle.
pub(super) const TURN: Range = Range::between(-1e3, 1e3, "rad");

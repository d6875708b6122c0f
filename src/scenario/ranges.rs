//! What the numbers of a scenario file can be: a factor of a hundred or more wider than what robots do, and narrow enough that times, ways
//! and counts made of them stay numbers.

use crate::plant::FASTEST_MOTION;
use crate::toml_input::Range;
use crate::units::JointKind;

/// Between two readings: a drive's own loop runs at up to 1 MHz, a position controller at 1 Hz at least.
pub(super) const CONTROL_PERIOD: Range = Range::between(1e-6, 1.0, "s");

/// Longest interval between two evaluations of the links.
pub(super) const PLANT_STEP: Range = Range::between(1e-6, 0.1, "s");

/// Of a rest, a steady time, a recording: four months.
pub(super) const DURATION: Range = Range::non_negative("s").up_to(1e7);

/// Of a recording.
pub(super) const LENGTH: Range = Range::positive("s").up_to(1e7);

/// [s] Longest session.
pub(super) const LONGEST_SESSION: f64 = 1e7;

/// Of a joint that moves: a turn in two months, up to what a plant can mean.
pub(super) fn speed(kind: JointKind) -> Range {
    Range::between(1e-6, FASTEST_MOTION, speed_unit(kind))
}

/// Of a joint: from a speed in 10⁴ s to a speed of 10⁴ rad/s in a millisecond.
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

/// [rad or m] Farthest place: a hundred thousand turns, and beyond any axis.
const FARTHEST: f64 = 1e6;

/// Place of a joint.
pub(super) fn position(kind: JointKind) -> Range {
    Range::between(-FARTHEST, FARTHEST, kind.position_unit())
}

/// The same in degrees.
pub(super) const DEGREES: Range = Range::between(-FARTHEST * 180.0, FARTHEST * 180.0, "°");

/// Way of a joint.
pub(super) fn way(kind: JointKind) -> Range {
    Range::between(0.0, FARTHEST, kind.position_unit())
}

/// Gain of a controller from a speed or an angle to a torque.
pub(super) fn gain(unit: &'static str) -> Range {
    Range::non_negative(unit).up_to(1e12)
}

/// The same, and not zero.
pub(super) fn positive_gain(unit: &'static str) -> Range {
    Range::positive(unit).up_to(1e12)
}

/// Speed within which a controller is linear, error of a speed that it is shown.
pub(super) fn speed_error(kind: JointKind) -> Range {
    Range::positive(speed_unit(kind)).up_to(FASTEST_MOTION)
}

/// Side of an obstacle.
pub(super) const SIDE: Range = Range::between(1e-4, 1e3, "m");

/// Place of an obstacle.
pub(super) const PLACE: Range = Range::between(-1e4, 1e4, "m");

/// Attitude of an obstacle.
pub(super) const TURN: Range = Range::between(-1e3, 1e3, "rad");

pub(super) fn speed_unit(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Revolute => "rad/s",
        JointKind::Prismatic => "m/s",
    }
}

//! Checks for physically impossible numbers, and for positions outside the limits of a joint.

use std::path::Path;

use super::plan::PlannedJoint;
use super::{JointLimits, Note};
use crate::error::{Error, Place, Result};
use crate::timeseries::Channel;
use crate::units::JointKind;

/// Part of the range of a joint by which a position may exceed its limits without a note: 3.6° for a range of 180°. A
/// tracking error at the limit and the error of a zero set by eye are about 1° each.
const MARGIN: f64 = 0.02;

/// Size and speed of a jump of a position that no machine makes: more than a hundred turns at five times the speed of the fastest spindle,
/// 2e4 rad/s at the motor; more than 10 m at ten times that of the fastest linear axes. A count that overflows or wraps at a turn jumps less.
const JUMP_TURNING: (f64, f64) = (628.0, 1e5);
const JUMP_SLIDING: (f64, f64) = (10.0, 1e3);

/// Refuses a number that no machine reaches. The bound is a thousand times that of the largest machines, so a value in
/// a wrong unit may still pass.
///
/// # Errors
/// The first such number, with row and column.
pub(super) fn physical(file: &Path, name: &str, channel: Channel, kind: JointKind, values: &[f64]) -> Result<()> {
    let (low, high, unit) = range(channel, kind);
    match values.iter().position(|value| !(low..=high).contains(value)) {
        None => Ok(()),
        Some(row) => {
            let expected = format!("a number from {low:e} to {high:e} [{unit}]; no machine exceeds this range");
            Err(Error::input(file, Place::Row(row + 1), name, format!("{:e}", values[row]), expected))
        }
    }
}

/// Possible values of a channel, with their unit.
fn range(channel: Channel, kind: JointKind) -> (f64, f64, &'static str) {
    let turns = kind == JointKind::Revolute;
    let (size, unit) = match channel {
        // 1e8 rad: a spindle at 1000 rad/s for a day. 1e6 m: a gantry of a kilometre.
        Channel::Position | Channel::ReferencePosition | Channel::LinkPosition => {
            (if turns { 1e8 } else { 1e6 }, kind.position_unit())
        }
        // The fastest spindles reach 2e4 rad/s at the motor, the fastest linear axes 100 m/s.
        Channel::Velocity | Channel::ReferenceVelocity if turns => (1e7, "rad/s"),
        Channel::Velocity | Channel::ReferenceVelocity => (1e5, "m/s"),
        // The largest drives take 1e4 A.
        Channel::Current | Channel::CommandCurrent => (1e7, "A"),
        // The joints of the largest excavators bear 1e7 N·m and 1e7 N.
        Channel::Torque | Channel::LinkTorque => (1e10, kind.effort_unit()),
        // A motor burns at 300 °C.
        Channel::Temperature => return (-273.15, 1e4, "°C"),
        _ => (f64::MAX, "SI"),
    };
    (-size, size, unit)
}

/// Refuses a position that no machine reaches from the one before, see [`JUMP_TURNING`]: each number alone may be possible.
///
/// # Errors
/// The first such position, with row and column.
pub(super) fn continuous(
    file: &Path,
    name: &str,
    (channel, kind): (Channel, JointKind),
    time: &[f64],
    values: &[f64],
) -> Result<()> {
    if !matches!(channel, Channel::Position | Channel::ReferencePosition | Channel::LinkPosition) {
        return Ok(());
    }
    let (far, fast) = if kind == JointKind::Revolute { JUMP_TURNING } else { JUMP_SLIDING };
    let jumps = |row: &usize| {
        let by = (values[*row] - values[row - 1]).abs();
        by > far && by > fast * (time[*row] - time[row - 1])
    };
    let Some(row) = (1..values.len()).find(jumps) else { return Ok(()) };
    // Of the two samples, the one farther from the median of all is reported.
    let mut sorted = values.to_vec();
    let middle = sorted.len() / 2;
    let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
    let row = if (values[row - 1] - median).abs() > (values[row] - median).abs() { row - 1 } else { row };
    let expected =
        format!("a position near the other samples (their median is {median:.4e}): no machine is as fast as this jump");
    Err(Error::input(file, Place::Row(row + 1), name, format!("{:e}", values[row]), expected))
}

/// A note on a position that lies outside the limits of its joint.
pub(super) fn outside_limits(
    file: &Path,
    name: &str,
    channel: Channel,
    joint: &PlannedJoint,
    values: &[f64],
    limits: &JointLimits,
) -> Option<Note> {
    if !matches!(channel, Channel::Position | Channel::LinkPosition) {
        return None;
    }
    let limits = limits.get(&joint.name)?;
    let [lower, upper] = if channel == Channel::Position { limits.axis } else { limits.link };
    let margin = MARGIN * (upper - lower);
    if !margin.is_finite() {
        return None;
    }
    let outside = |value: &&f64| !(lower - margin..=upper + margin).contains(*value);
    let row = values.iter().position(|value| outside(&value))?;
    let (count, unit) = (values.iter().filter(outside).count(), joint.kind.position_unit());
    let text = format!(
        "{:.4} {unit} lies outside the limits of {} in the model, {lower:.4} to {upper:.4} {unit}, as {count} of {} rows do: \
         the unit, the zero or the sign of the position, or the limits, may be wrong",
        values[row],
        joint.name,
        values.len()
    );
    Some(Note { file: file.to_owned(), place: Place::Row(row + 1), column: name.to_owned(), text })
}

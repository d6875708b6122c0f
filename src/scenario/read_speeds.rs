//! The joints of a session of kind `speeds`: constant velocities in a given order.
//!
//! `velocities`, `durations` and `decelerations` are lists with one element per velocity; `acceleration` is one number.

use super::ranges;
use super::read_reference::{MOST_STEPS, of_motion, required};
use crate::control::{SpeedSequence, SpeedStep};
use crate::error::Result;
use crate::toml_input::{Range, Table};
use crate::units::{DEG, JointKind};

/// The sequence of a joint.
pub(super) fn read(table: &Table<'_>, joint: usize, kind: JointKind) -> Result<SpeedSequence> {
    let (speed, acceleration, _) = of_motion(kind);
    let (velocities, key) = list(table, ["velocities", "velocities_deg"], kind)?;
    if velocities.is_empty() || velocities.len() as f64 > MOST_STEPS {
        return Err(table.error(key, format!("1 to {MOST_STEPS} velocities, not {}", velocities.len())));
    }
    each(table, key, velocities.iter().map(|velocity| velocity.abs()), &speed)?;
    let durations = table.optional_numbers("durations", &ranges::DURATION)?;
    let durations = durations.ok_or_else(|| table.error("durations", "a list of times [s], one per velocity"))?;
    let (decelerations, braking) = list(table, ["decelerations", "decelerations_deg"], kind)?;
    each(table, braking, decelerations.iter().copied(), &acceleration)?;
    for (key, found) in [("durations", durations.len()), (braking, decelerations.len())] {
        if found != velocities.len() {
            return Err(table.error(key, format!("one per velocity, {} in all, not {found}", velocities.len())));
        }
    }
    let acceleration = required(table, "acceleration", kind, &acceleration)?;
    let steps = (velocities.iter().zip(durations).zip(decelerations))
        .map(|((&velocity, duration), deceleration)| SpeedStep { velocity, duration, deceleration })
        .collect();
    table.finish()?;
    Ok(SpeedSequence { joint, acceleration, steps })
}

/// The list under the first key in SI, or under the second one in degrees if the joint turns, with the key that the table has.
fn list<'k>(table: &Table<'_>, [key, degrees]: [&'k str; 2], kind: JointKind) -> Result<(Vec<f64>, &'k str)> {
    let (key, unit, scale) =
        if kind == JointKind::Revolute && table.has(degrees) { (degrees, "°", DEG) } else { (key, "SI", 1.0) };
    let found = table.optional_numbers(key, &Range::any(unit))?;
    let found = found.ok_or_else(|| table.error(key, "a list of numbers"))?;
    Ok((found.into_iter().map(|value| value * scale).collect(), key))
}

/// # Errors
/// A value that is out of the range.
fn each(table: &Table<'_>, key: &str, mut values: impl Iterator<Item = f64>, range: &Range) -> Result<()> {
    match values.find(|value| !range.holds(*value)) {
        Some(value) => Err(table.error(key, format!("each of a size that is {range}, not {value:e}"))),
        None => Ok(()),
    }
}

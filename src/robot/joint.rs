//! Reads the table of one joint in a model file: gear, motor, drive, sensors, friction.

use super::model::{JointModel, TorqueAt};
use super::ranges;
use super::tree::Body;
use crate::drive::{Amplifier, CurrentSensor, Encoder, LinkEncoder, Motor, Sensing, VelocitySensor};
use crate::error::Result;
use crate::gearhead::{Exponential, Friction, FrictionLaw, Lines};
use crate::toml_input::{Range, Table};
use crate::units::JointKind;

/// `T_i` [s] of the current loop if the model file gives none.
pub(super) const CURRENT_TIME_CONSTANT: f64 = 0.0004;

/// [1] Part of friction on the link side if the model file gives none.
pub(super) const LINK_SHARE: f64 = 0.1;

/// Reads the table of a joint.
///
/// # Errors
/// A key is missing, unknown or out of its range.
pub(super) fn read_joint(table: &Table<'_>, body: &Body) -> Result<JointModel> {
    let kind = body.joint.kind;
    Ok(JointModel {
        name: body.joint.name.clone(),
        kind,
        gear_ratio: table.number("gear_ratio", &ranges::gear_ratio(kind))?,
        rotor_inertia: table.optional_number("rotor_inertia", &ranges::ROTOR_INERTIA)?,
        gear_stiffness: table.optional_number("gear_stiffness", &ranges::stiffness(kind))?,
        gear_damping: table.optional_number("gear_damping", &ranges::damping(kind))?,
        end_stop_stiffness: table.optional_number("end_stop_stiffness", &ranges::stiffness(kind))?,
        backlash: table.optional_number("backlash", &ranges::backlash(kind))?,
        motor: table.optional_table("motor")?.map(|table| read(table, read_motor)).transpose()?,
        amplifier: table.optional_table("drive")?.map_or_else(
            || {
                let (voltage_limit, current_limit) = (f64::INFINITY, f64::INFINITY);
                Ok(Amplifier { voltage_limit, current_limit, current_time_constant: CURRENT_TIME_CONSTANT })
            },
            |table| read(table, read_amplifier),
        )?,
        encoder: table.optional_table("encoder")?.map(|table| read(table, read_encoder)).transpose()?,
        link_encoder: table
            .optional_table("link_encoder")?
            .map(|table| read(table, |table| read_link_encoder(table, kind)))
            .transpose()?,
        velocity_sensor: table
            .optional_table("velocity_sensor")?
            .map(|table| read(table, read_velocity_sensor))
            .transpose()?,
        current_sensor: table
            .optional_table("current_sensor")?
            .map(|table| read(table, read_current_sensor))
            .transpose()?,
        friction: table
            .optional_table("friction")?
            .map(|table| read(table, |table| read_friction(table, kind)))
            .transpose()?,
        torque_at: TorqueAt::Motor,
        constant_accuracy: None,
    })
}

/// Reads a table and refuses its unknown keys.
fn read<T>(table: Table<'_>, read: impl FnOnce(&Table<'_>) -> Result<T>) -> Result<T> {
    let value = read(&table)?;
    table.finish()?;
    Ok(value)
}

fn read_motor(table: &Table<'_>) -> Result<Motor> {
    let motor = Motor {
        torque_constant: table.number("torque_constant", &ranges::TORQUE_CONSTANT)?,
        resistance: table.optional_number("resistance", &ranges::RESISTANCE)?,
        inductance: table.optional_number("inductance", &ranges::INDUCTANCE)?,
    };
    if motor.resistance.is_none() && motor.inductance.is_some() {
        return Err(table.error("inductance", "a `resistance` beside it"));
    }
    Ok(motor)
}

fn read_amplifier(table: &Table<'_>) -> Result<Amplifier> {
    Ok(Amplifier {
        voltage_limit: table.number_or("voltage_limit", &ranges::VOLTAGE, f64::INFINITY)?,
        current_limit: table.number_or("current_limit", &ranges::CURRENT, f64::INFINITY)?,
        current_time_constant: table.number_or(
            "current_time_constant",
            &ranges::CURRENT_TIME,
            CURRENT_TIME_CONSTANT,
        )?,
    })
}

fn read_encoder(table: &Table<'_>) -> Result<Encoder> {
    Ok(Encoder { counts_per_turn: table.number("counts_per_turn", &ranges::COUNTS)? })
}

fn read_link_encoder(table: &Table<'_>, kind: JointKind) -> Result<LinkEncoder> {
    Ok(LinkEncoder { resolution: table.number("resolution", &ranges::resolution(kind))? })
}

fn read_velocity_sensor(table: &Table<'_>) -> Result<VelocitySensor> {
    if table.optional_choice("method", &[("pulse_period", true), ("low_pass", false)])? == Some(true) {
        return Ok(VelocitySensor::PulsePeriod);
    }
    Ok(VelocitySensor::LowPass(table.number("low_pass_time_constant", &ranges::FILTER)?))
}

fn read_current_sensor(table: &Table<'_>) -> Result<CurrentSensor> {
    let words = [("signed", Sensing::Signed), ("absolute", Sensing::Absolute)];
    Ok(CurrentSensor {
        noise: table.number_or("noise", &ranges::CURRENT_ERROR, 0.0)?,
        resolution: table.number_or("resolution", &ranges::CURRENT_ERROR, 0.0)?,
        sensing: table.optional_choice("sensing", &words)?.unwrap_or(Sensing::Signed),
    })
}

fn read_friction(table: &Table<'_>, kind: JointKind) -> Result<Friction> {
    let (level, slope) = (ranges::friction(kind), ranges::friction_slope(kind));
    let two_lines = table.optional_choice("law", &[("exponential", false), ("two_lines", true)])? == Some(true);
    let law = if two_lines {
        let [a1, b1] = [table.pair("a1", &level)?, table.pair("b1", &slope)?];
        let [a2, b2] = [table.pair("a2", &level)?, table.pair("b2", &slope)?];
        let lines = [0, 1].map(|i| Lines { a1: a1[i], b1: b1[i], a2: a2[i], b2: b2[i] });
        if lines.iter().any(|line| !meet(line)) {
            return Err(table.error("b2", "lines that meet at a speed > 0: (a1 − a2)/(b2 − b1) > 0"));
        }
        FrictionLaw::TwoLines(lines)
    } else {
        let coulomb = table.pair("coulomb", &level)?;
        let breakaway = table.optional_pair("breakaway", &level)?.unwrap_or(coulomb);
        let speed = ranges::stribeck_velocity(kind);
        let stribeck_velocity = match table.optional_pair("stribeck_velocity", &speed)? {
            Some(velocity) => velocity,
            // Without a Stribeck peak the law does not depend on this velocity.
            None if breakaway == coulomb => [1.0, 1.0],
            None => table.pair("stribeck_velocity", &speed)?,
        };
        let viscous = table.optional_pair("viscous", &slope)?.unwrap_or([0.0, 0.0]);
        FrictionLaw::Exponential([0, 1].map(|i| Exponential {
            coulomb: coulomb[i],
            breakaway: breakaway[i],
            stribeck_velocity: stribeck_velocity[i],
            viscous: viscous[i],
        }))
    };
    let link_share = table.number_or("link_share", &Range::between(0.0, 1.0, "1"), LINK_SHARE)?;
    Ok(Friction { law, link_share })
}

/// Whether the two lines meet at a speed above zero, or are one.
fn meet(line: &Lines) -> bool {
    let switch = line.switch_velocity();
    (switch.is_finite() && switch > 0.0) || (line.a1 == line.a2 && line.b1 == line.b2)
}

//! Reading a model file: `model.toml` and the URDF that it names.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::model::{EffectEntry, JointModel, Model};
use super::tree::Body;
use super::urdf::{STANDARD_GRAVITY, Urdf};
use crate::drive::{Amplifier, CurrentSensor, Encoder, Motor, Sensing, VelocitySensor};
use crate::error::{Error, Place, Result};
use crate::gearhead::{Exponential, Friction, FrictionLaw, Lines};
use crate::toml_input::{Document, Range, Table, nearest};
use crate::units::JointKind;

/// The schema that this reader understands.
pub(super) const SCHEMA: &str = "lostmotion/model/1";

/// `T_i` [s] of the current loop where the model file gives none.
pub(super) const CURRENT_TIME_CONSTANT: f64 = 0.0004;

/// [1] Part of friction on the link side where the model file gives none.
pub(super) const LINK_SHARE: f64 = 0.1;

impl Model {
    /// Reads a model file and the URDF that it names.
    ///
    /// # Errors
    /// A file cannot be read, a key is missing, unknown or out of its range, a joint is not in the URDF, an inertia is one
    /// that no body can have. The error names file, line, key, value and what was expected.
    pub fn load(file: &Path) -> Result<Self> {
        Self::from_changed(&Document::read(file)?)
    }

    /// A model from a model file that was read and perhaps changed, and the URDF that it names.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn from_changed(document: &Document) -> Result<Self> {
        let urdf = urdf_path(document)?;
        let text = read_text(&urdf)
            .map_err(|error| if urdf.exists() { error } else { document.root().error("urdf", "a file that exists") })?;
        Self::from_document(document, &urdf, &text)
    }

    /// A model from texts that are no files, such as those embedded in the program; `file` is what errors call it, and
    /// where a mesh is looked for.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn from_texts(model: &str, urdf: &str, file: &Path) -> Result<Self> {
        let document = Document::parse(file, model)?;
        Self::from_document(&document, &urdf_path(&document)?, urdf)
    }

    /// A model from a parsed model file and the text of its URDF.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn from_document(document: &Document, urdf_file: &Path, urdf_text: &str) -> Result<Self> {
        let root = document.root();
        check_schema(&root)?;
        let name = root.text("name")?.to_owned();
        root.text("urdf")?;
        let gravity = root.optional_vector::<3>("gravity", &Range::any("m/s²"))?;
        let table = root.table("joints")?;
        let tables = table.named_tables()?;
        if tables.is_empty() {
            return Err(root.error("joints", "at least one joint that moves"));
        }

        let urdf = Urdf::parse(urdf_file, urdf_text)?;
        let movable = urdf.movable_joints();
        for name in table.keys() {
            if !movable.contains(&name) && !urdf.mimics(name) {
                let near = nearest(name, movable.iter().copied()).map_or_else(
                    || format!("one of its movable joints {}", movable.join(", ")),
                    |near| format!("a movable joint of it, such as {near}"),
                );
                return Err(table.error(name, format!("a joint of {}: {near}", urdf_file.display())));
            }
        }
        let (mut robot, held) = urdf.tree(&table.keys().collect::<BTreeSet<_>>())?;
        robot.gravity = gravity.map_or(STANDARD_GRAVITY, Into::into);
        let mut joints = Vec::new();
        for body in &robot.bodies {
            let table = table.table(&body.joint.name)?;
            joints.push(read_joint(&table, body)?);
            table.finish()?;
        }
        let effects =
            root.tables("effects")?.iter().map(|table| read_effect(table, &robot.bodies)).collect::<Result<_>>()?;
        root.finish()?;
        Ok(Self {
            name,
            source: document.file().to_owned(),
            urdf: urdf_file.to_owned(),
            urdf_text: urdf_text.to_owned(),
            robot,
            joints,
            held,
            effects,
        })
    }

    /// A first model of a URDF: every movable joint with a gear and a drive of common size, to be replaced by the machine's
    /// own numbers. Friction and gap are unknown.
    ///
    /// # Errors
    /// The file cannot be read, or is refused as in [`Model::load`].
    pub fn from_urdf(file: &Path) -> Result<Self> {
        let text = read_text(file)?;
        let urdf = Urdf::parse(file, &text)?;
        let (robot, held) = urdf.tree(&urdf.movable_joints().into_iter().collect())?;
        if robot.bodies.is_empty() {
            return Err(Error::input(file, Place::File, "", "", "at least one joint that turns or slides"));
        }
        let joints = robot.bodies.iter().map(first_joint).collect();
        Ok(Self {
            name: robot.name.clone(),
            source: PathBuf::new(),
            urdf: file.to_owned(),
            urdf_text: text.clone(),
            robot,
            joints,
            held,
            effects: Vec::new(),
        })
    }
}

fn check_schema(root: &Table<'_>) -> Result<()> {
    root.optional_choice("schema", &[(SCHEMA, ())])?
        .ok_or_else(|| root.error("schema", format!("\"{SCHEMA}\" (missing)")))
}

fn urdf_path(document: &Document) -> Result<PathBuf> {
    check_schema(&document.root())?;
    let urdf = document.root().text("urdf")?;
    Ok(document.file().parent().unwrap_or(Path::new("")).join(urdf))
}

fn read_text(file: &Path) -> Result<String> {
    let bytes = std::fs::read(file).map_err(|source| Error::file(file, "read", source))?;
    String::from_utf8(bytes).map_err(|_| Error::input(file, Place::File, "", "", "UTF-8 text"))
}

/// A gear and a drive of common size.
fn first_joint(body: &Body) -> JointModel {
    let (gear_ratio, gear_stiffness, gear_damping) = match body.joint.kind {
        // A harmonic or planetary gear 1:100; a ball screw of 5 mm a turn.
        JointKind::Revolute => (100.0, 1e4, 10.0),
        JointKind::Prismatic => (2.0 * std::f64::consts::PI / 0.005, 1e7, 1e4),
    };
    JointModel {
        name: body.joint.name.clone(),
        kind: body.joint.kind,
        gear_ratio,
        rotor_inertia: 1e-5,
        gear_stiffness,
        gear_damping,
        backlash: None,
        motor: Motor { torque_constant: 0.05, resistance: None, inductance: None },
        amplifier: Amplifier {
            voltage_limit: f64::INFINITY,
            current_limit: f64::INFINITY,
            current_time_constant: CURRENT_TIME_CONSTANT,
        },
        encoder: Some(Encoder { counts_per_turn: 4096.0 }),
        velocity_sensor: None,
        current_sensor: None,
        friction: None,
    }
}

fn read_joint(table: &Table<'_>, body: &Body) -> Result<JointModel> {
    let (ratio, stiffness, damping) = match body.joint.kind {
        JointKind::Revolute => ("rad/rad", "N·m/rad", "N·m·s/rad"),
        JointKind::Prismatic => ("rad/m", "N/m", "N·s/m"),
    };
    Ok(JointModel {
        name: body.joint.name.clone(),
        kind: body.joint.kind,
        gear_ratio: table.number("gear_ratio", &Range::positive(ratio))?,
        rotor_inertia: table.number("rotor_inertia", &Range::positive("kg·m²"))?,
        gear_stiffness: table.number("gear_stiffness", &Range::positive(stiffness))?,
        gear_damping: table.number_or("gear_damping", &Range::non_negative(damping), 0.0)?,
        backlash: table.optional_number("backlash", &Range::non_negative(body.joint.kind.position_unit()))?,
        motor: read(table.table("motor")?, read_motor)?,
        amplifier: table.optional_table("drive")?.map_or_else(
            || {
                let (voltage_limit, current_limit) = (f64::INFINITY, f64::INFINITY);
                Ok(Amplifier { voltage_limit, current_limit, current_time_constant: CURRENT_TIME_CONSTANT })
            },
            |table| read(table, read_amplifier),
        )?,
        encoder: table.optional_table("encoder")?.map(|table| read(table, read_encoder)).transpose()?,
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
            .map(|table| read(table, |table| read_friction(table, body.joint.kind)))
            .transpose()?,
    })
}

/// Reads a table and refuses what is left of it.
fn read<T>(table: Table<'_>, read: impl FnOnce(&Table<'_>) -> Result<T>) -> Result<T> {
    let value = read(&table)?;
    table.finish()?;
    Ok(value)
}

fn read_motor(table: &Table<'_>) -> Result<Motor> {
    let motor = Motor {
        torque_constant: table.number("torque_constant", &Range::positive("N·m/A"))?,
        resistance: table.optional_number("resistance", &Range::positive("Ω"))?,
        inductance: table.optional_number("inductance", &Range::positive("H"))?,
    };
    if motor.resistance.is_none() && motor.inductance.is_some() {
        return Err(table.error("inductance", "a `resistance` beside it"));
    }
    Ok(motor)
}

fn read_amplifier(table: &Table<'_>) -> Result<Amplifier> {
    Ok(Amplifier {
        voltage_limit: table.number_or("voltage_limit", &Range::positive("V"), f64::INFINITY)?,
        current_limit: table.number_or("current_limit", &Range::positive("A"), f64::INFINITY)?,
        current_time_constant: table.number_or(
            "current_time_constant",
            &Range::positive("s"),
            CURRENT_TIME_CONSTANT,
        )?,
    })
}

fn read_encoder(table: &Table<'_>) -> Result<Encoder> {
    Ok(Encoder { counts_per_turn: table.number("counts_per_turn", &Range::positive("1/turn"))? })
}

fn read_velocity_sensor(table: &Table<'_>) -> Result<VelocitySensor> {
    if table.optional_choice("method", &[("pulse_period", true), ("low_pass", false)])? == Some(true) {
        return Ok(VelocitySensor::PulsePeriod);
    }
    Ok(VelocitySensor::LowPass(table.number("low_pass_time_constant", &Range::positive("s"))?))
}

fn read_current_sensor(table: &Table<'_>) -> Result<CurrentSensor> {
    let words = [("signed", Sensing::Signed), ("absolute", Sensing::Absolute)];
    Ok(CurrentSensor {
        noise: table.number_or("noise", &Range::non_negative("A"), 0.0)?,
        resolution: table.number_or("resolution", &Range::non_negative("A"), 0.0)?,
        sensing: table.optional_choice("sensing", &words)?.unwrap_or(Sensing::Signed),
    })
}

fn read_friction(table: &Table<'_>, kind: JointKind) -> Result<Friction> {
    let (slope_unit, speed_unit) = match kind {
        JointKind::Revolute => ("N·m·s/rad", "rad/s"),
        JointKind::Prismatic => ("N·s/m", "m/s"),
    };
    let (level, slope) = (Range::non_negative(kind.effort_unit()), Range::any(slope_unit));
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
        let speed = Range::positive(speed_unit);
        let stribeck_velocity = match table.optional_pair("stribeck_velocity", &speed)? {
            Some(velocity) => velocity,
            // Without a peak the law does not depend on it.
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

fn read_effect(table: &Table<'_>, bodies: &[Body]) -> Result<EffectEntry> {
    let effect = table.text("effect")?.to_owned();
    let joint = table.optional_text("joint")?;
    if let Some(name) = joint.filter(|name| bodies.iter().all(|body| body.joint.name != *name)) {
        let names: Vec<&str> = bodies.iter().map(|body| body.joint.name.as_str()).collect();
        let near = nearest(name, names.iter().copied()).map_or_else(|| names.join(", "), str::to_owned);
        return Err(table.error("joint", format!("a joint of this model: {near}")));
    }
    Ok(EffectEntry { effect, joint: joint.map(str::to_owned), parameters: table.remaining_numbers()? })
}

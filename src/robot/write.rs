//! Writes a model file that reads back as the same model.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::first::First;
use super::model::{JointModel, Masses, Model};
use super::placeholders::Placeholders;
use super::read::SCHEMA;
use super::tree::STANDARD_GRAVITY;
use crate::drive::{Sensing, VelocitySensor};
use crate::error::{Error, Place, Result};
use crate::gearhead::{Friction, FrictionLaw};
use crate::toml_input::{write_atomically, written_key, written_number, written_text};
use crate::units::JointKind;

impl Model {
    /// Writes a complete model file, or nothing if it fails. A URDF below the file's folder is named by its relative
    /// path, any other by its absolute path. A URDF that is not on disk (an embedded model) is written beside the
    /// file, without replacing another file.
    ///
    /// Changes of [`Model::robot`] after reading are not written: the tree is read from the URDF.
    ///
    /// # Errors
    /// The operating system refuses a file, or another file is in the place of the URDF.
    pub fn save(&self, file: &Path) -> Result<()> {
        let urdf = self.place_urdf(file)?;
        write_atomically(file, &self.to_toml(&urdf))
    }

    /// Path of the URDF for a model file at this place; a URDF that is not on disk is written.
    fn place_urdf(&self, file: &Path) -> Result<PathBuf> {
        let folder = file.parent().unwrap_or(Path::new(""));
        let urdf = match self.urdf.canonicalize() {
            Ok(urdf) => named_from(folder, urdf),
            Err(_) => {
                let name = self.urdf.file_name().filter(|name| Some(*name) != file.file_name());
                let name = PathBuf::from(name.unwrap_or("robot.urdf".as_ref()));
                let urdf = folder.join(&name);
                let same = || std::fs::read(&urdf).is_ok_and(|text| text == self.urdf_text.as_bytes());
                match urdf.symlink_metadata() {
                    Err(_) => write_atomically(&urdf, &self.urdf_text)?,
                    Ok(found) if found.is_file() && same() => {}
                    Ok(_) => {
                        return Err(Error::input(&urdf, Place::File, "", "", "no other file than this model's URDF"));
                    }
                }
                name
            }
        };
        Ok(urdf)
    }

    /// The text of the model file, with this path of its URDF.
    pub fn to_toml(&self, urdf: &Path) -> String {
        self.text(urdf, &Placeholders::default())
    }

    fn text(&self, urdf: &Path, placeholders: &Placeholders) -> String {
        let mut out = Text { out: String::new(), section: String::new(), placeholders };
        line(&mut out, "schema", &written_text(SCHEMA), "");
        line(&mut out, "name", &written_text(&self.name), "");
        line(&mut out, "urdf", &written_text(&urdf.to_string_lossy()), "");
        if self.masses == Masses::Estimated {
            line(&mut out, "masses", &written_text("estimated"), "guesses: torques are not used as evidence");
        }
        if self.robot.gravity != STANDARD_GRAVITY {
            let gravity: Vec<String> = self.robot.gravity.iter().copied().map(written_number).collect();
            line(&mut out, "gravity", &format!("[{}]", gravity.join(", ")), "[m/s²] seen from the base");
        }
        for joint in &self.joints {
            write_joint(&mut out, joint);
        }
        self.write_coupling(&mut out);
        out.section("accuracy");
        for (key, value, comment) in self.accuracy.entries() {
            number(&mut out, key, value, comment);
        }
        for effect in &self.effects {
            out.list("effects");
            line(&mut out, "effect", &written_text(&effect.effect), "");
            if let Some(joint) = &effect.joint {
                line(&mut out, "joint", &written_text(joint), "");
            }
            for (name, value) in &effect.parameters {
                number(&mut out, name, *value, "");
            }
        }
        for load in &self.loads {
            out.list("loads");
            line(&mut out, "session", &written_text(&load.session), "recording in which the last body carries it");
            number(&mut out, "mass", load.mass, "[kg]");
            for (axis, value) in ["x", "y", "z"].into_iter().zip(load.position) {
                number(&mut out, axis, value, "[m]");
            }
        }
        out.out
    }
}

impl First {
    /// As [`Model::save`], with a mark at every value that is a placeholder, and with guesses as comments.
    ///
    /// # Errors
    /// As [`Model::save`].
    pub fn save(&self, file: &Path) -> Result<()> {
        let urdf = self.model.place_urdf(file)?;
        write_atomically(file, &self.model.text(&urdf, &self.placeholders))
    }
}

/// The text of a model file while it is written.
struct Text<'p> {
    out: String,
    /// The table that is being written.
    section: String,
    placeholders: &'p Placeholders,
}

impl Text<'_> {
    /// Begins a table.
    fn section(&mut self, name: &str) {
        name.clone_into(&mut self.section);
        self.out.push_str(&format!("\n[{name}]\n"));
    }

    /// Begins a table that needs this key: a comment where the key's value is a guess.
    fn section_with(&mut self, name: &str, key: &str) {
        let (before, _) = self.placeholders.around(name, key, "");
        name.clone_into(&mut self.section);
        self.out.push_str(&format!("\n{before}[{name}]\n"));
    }

    /// Begins an entry of a list of tables.
    fn list(&mut self, name: &str) {
        name.clone_into(&mut self.section);
        self.out.push_str(&format!("\n[[{name}]]\n"));
    }
}

impl Model {
    /// The table of coupled axes, if there are any.
    fn write_coupling(&self, out: &mut Text<'_>) {
        let name = |index: usize| written_key(&self.joints[index].name);
        let Some(coupling) = &self.robot.coupling else { return };
        out.out.push_str("\n[coupling]  # motion of an axis (motor / gear ratio) per motion of each joint\n");
        for (axis, row) in coupling.rows() {
            let entries: Vec<String> =
                row.into_iter().map(|(joint, value)| format!("{} = {}", name(joint), written_number(value))).collect();
            line(out, &self.joints[axis].name, &format!("{{ {} }}", entries.join(", ")), "");
        }
    }
}

/// The relative path if it is below the folder, else the path itself.
fn named_from(folder: &Path, file: PathBuf) -> PathBuf {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let below = folder.canonicalize().ok().and_then(|folder| file.strip_prefix(folder).ok().map(Path::to_owned));
    below.unwrap_or(file)
}

fn line(out: &mut Text<'_>, key: &str, value: &str, comment: &str) {
    let (before, comment) = out.placeholders.around(&out.section, key, comment);
    let key = written_key(key);
    // Writing to a String cannot fail.
    let _ = match comment.as_str() {
        "" => writeln!(out.out, "{before}{key} = {value}"),
        _ => writeln!(out.out, "{before}{key} = {value}  # {comment}"),
    };
}

fn number(out: &mut Text<'_>, key: &str, value: f64, comment: &str) {
    line(out, key, &written_number(value), comment);
}

/// Writes a number only if it is known and finite.
fn known(out: &mut Text<'_>, key: &str, value: Option<f64>, comment: &str) {
    if let Some(value) = value.filter(|value| value.is_finite()) {
        number(out, key, value, comment);
    }
}

fn pair(out: &mut Text<'_>, key: &str, [positive, negative]: [f64; 2], comment: &str) {
    line(out, key, &format!("[{}, {}]", written_number(positive), written_number(negative)), comment);
}

fn write_joint(out: &mut Text<'_>, joint: &JointModel) {
    let (position, stiffness, damping) = match joint.kind {
        JointKind::Revolute => ("[rad] total gap", "[N·m/rad] at the joint, outside the gap", "[N·m·s/rad]"),
        JointKind::Prismatic => ("[m] total gap", "[N/m] at the joint, outside the gap", "[N·s/m]"),
    };
    let name = written_key(&joint.name);
    let section = |out: &mut Text<'_>, part: &str| {
        out.section(&format!("joints.{name}{part}"));
    };
    section(out, "");
    number(out, "gear_ratio", joint.gear_ratio, "motor turns [rad] per joint motion");
    known(out, "rotor_inertia", joint.rotor_inertia, "[kg·m²] at the motor shaft");
    known(out, "gear_stiffness", joint.gear_stiffness, stiffness);
    known(out, "gear_damping", joint.gear_damping, damping);
    known(out, "end_stop_stiffness", joint.end_stop_stiffness, "of the stops at the ends of its range");
    known(out, "backlash", joint.backlash, position);

    if let Some(motor) = &joint.motor {
        section(out, ".motor");
        number(out, "torque_constant", motor.torque_constant, "[N·m/A]");
        known(out, "resistance", motor.resistance, "[Ω]");
        known(out, "inductance", motor.inductance, "[H]");
    }

    section(out, ".drive");
    known(out, "voltage_limit", Some(joint.amplifier.voltage_limit), "[V]");
    known(out, "current_limit", Some(joint.amplifier.current_limit), "[A]");
    number(out, "current_time_constant", joint.amplifier.current_time_constant, "[s]");

    if let Some(encoder) = &joint.encoder {
        out.section_with(&format!("joints.{name}.encoder"), "counts_per_turn");
        number(out, "counts_per_turn", encoder.counts_per_turn, "motor shaft, after quadrature");
    }
    if let Some(encoder) = &joint.link_encoder {
        section(out, ".link_encoder");
        number(out, "resolution", encoder.resolution, position);
    }
    if let Some(sensor) = &joint.velocity_sensor {
        section(out, ".velocity_sensor");
        match sensor {
            VelocitySensor::LowPass(time) => number(out, "low_pass_time_constant", *time, "[s]"),
            VelocitySensor::PulsePeriod => line(out, "method", "\"pulse_period\"", ""),
        }
    }
    if let Some(sensor) = &joint.current_sensor {
        section(out, ".current_sensor");
        number(out, "noise", sensor.noise, "[A] standard deviation");
        number(out, "resolution", sensor.resolution, "[A]");
        let word = match sensor.sensing {
            Sensing::Signed => "\"signed\"",
            Sensing::Absolute => "\"absolute\"",
        };
        line(out, "sensing", word, "");
    }
    if let Some(friction) = &joint.friction {
        section(out, ".friction");
        write_friction(out, friction, joint.kind);
    }
}

fn write_friction(out: &mut Text<'_>, friction: &Friction, kind: JointKind) {
    let (level, slope, speed) = match kind {
        JointKind::Revolute => ("[N·m] positive, negative direction", "[N·m·s/rad]", "[rad/s]"),
        JointKind::Prismatic => ("[N] positive, negative direction", "[N·s/m]", "[m/s]"),
    };
    match &friction.law {
        FrictionLaw::Exponential(law) => {
            pair(out, "coulomb", law.map(|law| law.coulomb), level);
            pair(out, "breakaway", law.map(|law| law.breakaway), level);
            pair(out, "stribeck_velocity", law.map(|law| law.stribeck_velocity), speed);
            pair(out, "viscous", law.map(|law| law.viscous), slope);
        }
        FrictionLaw::TwoLines(lines) => {
            line(out, "law", "\"two_lines\"", "");
            pair(out, "a1", lines.map(|line| line.a1), level);
            pair(out, "b1", lines.map(|line| line.b1), slope);
            pair(out, "a2", lines.map(|line| line.a2), level);
            pair(out, "b2", lines.map(|line| line.b2), slope);
        }
    }
    number(out, "link_share", friction.link_share, "part of it on the link side of the gap");
}

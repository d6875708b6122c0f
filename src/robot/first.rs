//! A first model of a robot file: the drive data that the file states, and placeholders of common size for those that it does not state.
//!
//! ```text
//!   N   = ω_m / v_max           the gear ratio with which a common motor reaches the joint's speed limit
//!   K_t = τ_max / (N i_max)     the torque constant with which a common current gives the joint's effort limit
//!   J_r = I / N²                where the file gives the rotor's inertia I at the joint (`armature`)
//! ```
//! Rotors and gears that the file does not describe stay unknown here; `plant` gives them values that can be simulated.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use super::accuracy::Accuracy;
use super::drives::DriveData;
use super::joint::CURRENT_TIME_CONSTANT;
use super::model::{JointModel, Masses, Model, TorqueAt};
use super::placeholders::Placeholders;
use super::ranges;
use super::read::{MOST_JOINTS, read_robot_file};
use super::tree::Body;
use super::urdf::{Built, Urdf};
use crate::drive::{Amplifier, Encoder, Motor};
use crate::error::{Error, Place, Result};
use crate::files;
use crate::toml_input::Places;
use crate::units::JointKind;

/// `ω_m` [rad/s] Rated speed of a common servo motor, 3000 turns per minute.
const MOTOR_SPEED: f64 = 3000.0 * TAU / 60.0;

/// `i_max` [A] Peak current of a common drive of that size.
const MOTOR_CURRENT: f64 = 10.0;

/// [N·m/A] Torque constant of a common motor, where the file has no effort limit.
const TORQUE_CONSTANT: f64 = 0.05;

/// [N·m/A] Smallest torque constant that is written, whatever the effort limit: a watch motor.
const LEAST_CONSTANT: f64 = 1e-6;
/// [N·m/A] Largest one: a direct drive of ten tons.
const MOST_CONSTANT: f64 = 1e4;

/// Counts per turn of a common encoder, after quadrature. Recordings show what the machine's own has.
const COUNTS: f64 = 4096.0;

/// Ratio of a common gear where the file has no speed limit: 1:100 for a harmonic or planetary gear, a ball screw of 5 mm per turn.
const fn common_ratio(kind: JointKind) -> f64 {
    match kind {
        JointKind::Revolute => 100.0,
        JointKind::Prismatic => TAU / 0.005,
    }
}

/// Gear ratios of common gears [1 or rad/m]: direct drives to harmonic drives in series; screws of 60 mm to 1 mm per turn.
const fn common_ratios(kind: JointKind) -> [f64; 2] {
    match kind {
        JointKind::Revolute => [1.0, 1000.0],
        JointKind::Prismatic => [TAU / 0.06, TAU / 0.001],
    }
}

/// A first model, and which of its values are placeholders.
#[derive(Debug, Clone, PartialEq)]
pub struct First {
    /// The model.
    pub model: Model,
    /// Values that the user should replace by those of the machine.
    pub placeholders: Placeholders,
}

impl First {
    /// A first model of a robot file: every movable joint that moves a mass gets the drive that the file states, completed by placeholders.
    /// Rotor and gear stay unknown where the file does not state them, and so do friction and gap. `reasons` names the joints to hold at
    /// zero; each reason becomes a remark.
    ///
    /// # Errors
    /// The file cannot be read, or is refused as in [`Model::load`].
    pub fn of(file: &Path, reasons: &BTreeMap<String, String>) -> Result<Self> {
        let robot_file = read_robot_file(file)?;
        let urdf = Urdf::of(file, &robot_file)?;
        let movable = urdf.movable_joints().len();
        if movable > MOST_JOINTS {
            let expected = format!("at most {MOST_JOINTS} joints that move, not {movable}");
            return Err(Error::input(file, Place::File, "joints", "", expected));
        }
        let Built { mut robot, held, mut remarks } = urdf.whole_tree(reasons)?;
        if robot.bodies.is_empty() {
            return Err(Error::input(file, Place::File, "", "", "at least one joint that turns or slides"));
        }
        robot.gravity = robot_file.gravity;
        let drives = urdf.drives(&mut remarks);
        let mut placeholders = Placeholders::default();
        let of_body = |body: &Body| {
            let data = drives.get(&body.joint.name).or(robot_file.drives.get(&body.joint.name));
            first_joint(body, data.copied().unwrap_or_default(), &mut placeholders)
        };
        let joints = robot.bodies.iter().map(of_body).collect();
        let model = Model {
            name: first_name(&robot.name, file).to_owned(),
            source: PathBuf::new(),
            urdf: file.to_owned(),
            urdf_text: robot_file.text,
            robot,
            joints,
            held,
            remarks,
            masses: Masses::Known,
            accuracy: Accuracy::default(),
            effects: Vec::new(),
            loads: Vec::new(),
            places: Places::default(),
        };
        Ok(Self { model, placeholders })
    }
}

/// The robot's own name if it is valid for a folder, else the name of its file, else `robot`.
fn first_name<'a>(robot: &'a str, file: &'a Path) -> &'a str {
    let stem = file.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    [robot, stem].into_iter().find(|name| files::is_fit_name(name)).unwrap_or("robot")
}

/// The drive of a joint.
fn first_joint(body: &Body, data: DriveData, placeholders: &mut Placeholders) -> JointModel {
    let (name, kind, limits) = (&body.joint.name, body.joint.kind, body.joint.limits);
    let mut or_common = |key: &str, given: Option<f64>, common: f64| {
        given.unwrap_or_else(|| {
            placeholders.mark(name, key);
            common
        })
    };
    let [least, most] = common_ratios(kind);
    let for_speed = if limits.velocity.is_finite() { MOTOR_SPEED / limits.velocity } else { common_ratio(kind) };
    let gear_ratio = or_common("gear_ratio", data.gear_ratio, two_digits(for_speed.clamp(least, most)));
    let for_effort =
        if limits.effort.is_finite() { limits.effort / (gear_ratio * MOTOR_CURRENT) } else { TORQUE_CONSTANT };
    let torque_constant = or_common(
        "motor.torque_constant",
        data.torque_constant,
        two_digits(for_effort.clamp(LEAST_CONSTANT, MOST_CONSTANT)),
    );
    let current_limit = limits.effort / (gear_ratio * torque_constant);
    let current_limit = if ranges::CURRENT.holds(current_limit) { current_limit } else { f64::INFINITY };
    if current_limit.is_finite() && placeholders.marks(name, "motor.torque_constant") {
        placeholders.mark(name, "drive.current_limit");
    }
    let of_armature = data.armature.map(|armature| armature / (gear_ratio * gear_ratio));
    let rotor_inertia = data.rotor_inertia.or(of_armature).filter(|inertia| ranges::ROTOR_INERTIA.holds(*inertia));
    placeholders.mark(name, "drive.current_time_constant");
    placeholders.guess(name, "encoder.counts_per_turn");
    JointModel {
        name: name.clone(),
        kind,
        gear_ratio,
        rotor_inertia,
        gear_stiffness: None,
        gear_damping: None,
        end_stop_stiffness: None,
        backlash: None,
        motor: Some(Motor { torque_constant, resistance: None, inductance: None }),
        amplifier: Amplifier {
            voltage_limit: f64::INFINITY,
            current_limit,
            current_time_constant: CURRENT_TIME_CONSTANT,
        },
        encoder: Some(Encoder { counts_per_turn: COUNTS }),
        link_encoder: None,
        velocity_sensor: None,
        current_sensor: None,
        friction: None,
        torque_at: TorqueAt::Motor,
        constant_accuracy: None,
    }
}

/// A value rounded to two digits, as befits a guess.
pub fn two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

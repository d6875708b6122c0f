//! The model file: transmission, drives, sensors and friction of one machine, in addition to its URDF.

use std::collections::BTreeMap;
use std::path::PathBuf;

use nalgebra::Matrix3;

use super::{Accuracy, Inertia, Remark, Robot};
use crate::drive::{Amplifier, CurrentSensor, Encoder, LinkEncoder, Motor, VelocitySensor};
use crate::gearhead::{DeadZone, Friction, rigid};
use crate::toml_input::Places;
use crate::units::JointKind;

/// A machine: its kinematic tree and the drives of its joints, in the order of the tree's joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Name of the machine.
    pub name: String,
    /// The model file; empty for a model that was not read from a file.
    pub source: PathBuf,
    /// The URDF file.
    pub urdf: PathBuf,
    /// Text of the URDF.
    pub urdf_text: String,
    /// The tree of the movable joints that the model lists; all others are held at zero.
    pub robot: Robot,
    /// One per body of the tree, in the same order.
    pub joints: Vec<JointModel>,
    /// Movable joints of the URDF that the model does not list, held at zero.
    pub held: Vec<String>,
    /// Values of the URDF that are not taken as written.
    pub remarks: Vec<Remark>,
    /// Whether its masses and inertias are reliable.
    pub masses: Masses,
    /// How well its nominal values are known.
    pub accuracy: Accuracy,
    /// Effects that the nominal machine lacks.
    pub effects: Vec<EffectEntry>,
    /// Known masses that the last body carries in some recordings.
    pub loads: Vec<Load>,
    /// Lines of its values in the model file; empty for a model that was not read from a file.
    pub places: Places,
}

impl Model {
    /// The machine as it is in the recording of this name: with the load that it carries there.
    pub fn in_session(&self, name: &str) -> Self {
        let mut model = Self { loads: Vec::new(), ..self.clone() };
        for load in self.loads.iter().filter(|load| load.session == name) {
            if let Some(body) = model.robot.bodies.last_mut() {
                body.inertia = body.inertia.joined(&load.inertia());
            }
        }
        model
    }

    /// Axes that do not move only the joint of their own name.
    pub fn coupled_axes(&self) -> impl Iterator<Item = usize> {
        self.robot.coupling.iter().flat_map(|coupling| coupling.rows().map(|(axis, _)| axis))
    }

    /// Gives a joint its friction, which is the whole friction of the joint: the damping and friction of its URDF no longer act. Those of coupled
    /// joints stay, since they act on other axes as well.
    pub fn set_friction(&mut self, joint: usize, friction: Friction) {
        self.joints[joint].friction = Some(friction);
        if self.robot.coupling.is_none() {
            let link = &mut self.robot.bodies[joint].joint;
            (link.damping, link.friction) = (0.0, 0.0);
        }
    }

    /// The load of the machine in the recording of this name, as a tree in which nothing else has mass; `None` if there
    /// is no load.
    pub fn load_in(&self, name: &str) -> Option<Robot> {
        let mut robot = self.robot.clone();
        robot.bodies.iter_mut().for_each(|body| body.inertia = Inertia::zero());
        let alone = Self { robot, ..self.clone() };
        self.loads.iter().any(|load| load.session == name).then(|| alone.in_session(name).robot)
    }
}

/// An entry of the list `[[loads]]`: a known point mass on the last body in one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// Name of the recording; for a file, its name without the extension.
    pub session: String,
    /// [kg] > 0.
    pub mass: f64,
    /// [m] Its position `x, y, z` in the frame of the last body.
    pub position: [f64; 3],
}

impl Load {
    /// Its inertia in the frame of the last body.
    pub fn inertia(&self) -> Inertia {
        Inertia { mass: self.mass, com: self.position.into(), tensor: Matrix3::zeros() }
    }
}

/// Where the torque of a joint is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TorqueAt {
    /// At the motor: current times torque constant, or a torque of the drive. It drives rotor, gear and link against all friction.
    #[default]
    Motor,
    /// Behind the gear, by a joint torque sensor: it drives the link against the friction of its bearing.
    Link,
}

/// Origin of the masses and inertias of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Masses {
    /// Measured, identified or from a drawing.
    #[default]
    Known,
    /// Guessed, so that a simulation has the right order of magnitude. The torques that links need are then not used as evidence.
    Estimated,
}

/// Transmission, drive and sensors of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointModel {
    /// Name of the joint in the URDF.
    pub name: String,
    /// Turning or sliding.
    pub kind: JointKind,
    /// Motor turns [rad] per joint motion [rad or m], > 0.
    pub gear_ratio: f64,
    /// [kg·m²] at the motor shaft, > 0; `None`: unknown, to be fitted ([`rotor_beside`](Self::rotor_beside) in a simulation).
    pub rotor_inertia: Option<f64>,
    /// [N·m/rad or N/m] at the joint, outside the gap, > 0; `None`: the gear counts as rigid outside its gap
    /// ([`flanks`](Self::flanks)).
    pub gear_stiffness: Option<f64>,
    /// [N·m·s/rad or N·s/m] at the joint, outside the gap, ≥ 0; `None`: none, or that of a rigid gear ([`flanks`](Self::flanks)).
    pub gear_damping: Option<f64>,
    /// [N·m/rad or N/m] Stiffness of the stops at the ends of the URDF's range, > 0; `None`: there are no stops. A
    /// URDF's limit is the commanded range of a joint; whether a mechanical stop exists there is stated by the model
    /// file.
    pub end_stop_stiffness: Option<f64>,
    /// [rad or m] total gap at the joint, ≥ 0; `None`: unknown, to be identified.
    pub backlash: Option<f64>,
    /// The motor; `None`: torques are recorded, and a command is a torque at the joint.
    pub motor: Option<Motor>,
    /// The power stage.
    pub amplifier: Amplifier,
    /// The encoder on the motor shaft; `None`: exact.
    pub encoder: Option<Encoder>,
    /// The second encoder, on the link; `None`: there is none.
    pub link_encoder: Option<LinkEncoder>,
    /// How the velocity channel is made; `None`: exact.
    pub velocity_sensor: Option<VelocitySensor>,
    /// The current sensor; `None`: exact.
    pub current_sensor: Option<CurrentSensor>,
    /// Friction; `None`: unknown, to be identified.
    pub friction: Option<Friction>,
    /// Where the recordings at hand measure its torque; no key of the model file.
    pub torque_at: TorqueAt,
    /// `s_K` [1] Accuracy of its torque constant, where recordings told the constant better than `[accuracy]` says; no key of the model file.
    pub constant_accuracy: Option<f64>,
}

/// [rad/s] Resonance of a link on its gear, the rotor held, that is asked of hand axes, SCARA and welding robots: 15 Hz (Harmonic Drive AG,
/// Engineering Data HFUS-2A, 2014).
pub const USUAL_RESONANCE: f64 = 15.0 * std::f64::consts::TAU;

impl JointModel {
    /// The joint as a torque sensor behind its gear sees it: without rotor and motor, and with the link-side part of its friction only.
    #[must_use]
    pub fn behind_gear(&self) -> Self {
        Self {
            rotor_inertia: Some(0.0),
            motor: None,
            current_sensor: None,
            friction: self.friction.map(|friction| friction.of_link()),
            torque_at: TorqueAt::Link,
            ..self.clone()
        }
    }

    /// Rotor inertia on the joint side, `ratio² · J_r` [kg·m² or kg]; 0 where it is unknown.
    pub fn reflected_inertia(&self) -> f64 {
        self.gear_ratio * self.gear_ratio * self.rotor_inertia.unwrap_or(0.0)
    }

    /// [rad/s] Resonance `√(k/M)` of a link of this inertia [kg·m² or kg] on its gear, the rotor held; where the stiffness is unknown, the
    /// [usual](USUAL_RESONANCE) one.
    pub fn resonance(&self, link_inertia: f64) -> f64 {
        self.gear_stiffness.map_or(USUAL_RESONANCE, |k| (k / link_inertia).sqrt())
    }

    /// [rad/(N·m) or m/N] Standard error of the gear's compliance `1/k` before a link of this inertia [kg·m² or kg], if a stated stiffness is known
    /// to this share [1]. An unknown one is taken as rigid, and may be as low as the [usual](USUAL_RESONANCE) resonance has it.
    pub fn compliance_error(&self, accuracy: f64, link_inertia: f64) -> f64 {
        self.gear_stiffness.map_or_else(|| (USUAL_RESONANCE.powi(2) * link_inertia).recip(), |k| accuracy / k)
    }

    /// Rotor inertia on the joint side [kg·m² or kg] that a simulation uses with a link of this inertia: where the rotor inertia
    /// is unknown, the share [`rigid::ROTOR_SHARE`] of the link inertia.
    pub fn rotor_beside(&self, link_inertia: f64) -> f64 {
        if self.rotor_inertia.is_some() { self.reflected_inertia() } else { rigid::ROTOR_SHARE * link_inertia }
    }

    /// The flanks of the gear around a gap [rad or m]. If the stiffness is unknown, the gear is rigid ([`rigid`]) for the `inertia`
    /// `J + M` [kg·m² or kg] of rotor and link and their `mobility` `1/J + W` [1/(kg·m²) or 1/kg]. If only the damping is
    /// unknown, it is zero.
    pub fn flanks(&self, backlash: f64, inertia: f64, mobility: f64) -> DeadZone {
        let rigid = DeadZone::rigid(backlash, inertia, mobility);
        match self.gear_stiffness {
            Some(stiffness) => DeadZone { backlash, stiffness, damping: self.gear_damping.unwrap_or(0.0) },
            None => DeadZone { damping: self.gear_damping.unwrap_or(rigid.damping), ..rigid },
        }
    }

    /// Stiffness and damping of the stops at the ends of the range, [N·m/rad or N/m] and [N·m·s/rad or N·s/m]. The
    /// ratio of damping to stiffness equals that of the gear, if that is known.
    pub fn end_stop(&self) -> Option<(f64, f64)> {
        let stiffness = self.end_stop_stiffness?;
        let damping = match self.gear_stiffness {
            Some(of_gear) => self.gear_damping.unwrap_or(0.0) * stiffness / of_gear,
            None => rigid::RELAXATION * stiffness,
        };
        Some((stiffness, damping))
    }

    /// Motor torque on the joint side per unit of current, `ratio · K_t` [N·m/A or N/A]; 1 without a motor, whose
    /// "current" is a torque at the joint.
    pub fn torque_per_ampere(&self) -> f64 {
        self.motor.map_or(1.0, |motor| self.gear_ratio * motor.torque_constant)
    }

    /// Size of an encoder count at the joint [rad or m]; 0 if the encoder is exact.
    pub fn encoder_step(&self) -> f64 {
        self.encoder.map_or(0.0, |encoder| 2.0 * std::f64::consts::PI / (encoder.counts_per_turn * self.gear_ratio))
    }
}

/// An entry of the list `[[effects]]`: an effect of the catalogue, its joint, and its parameters.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct EffectEntry {
    /// Name of the effect in the catalogue.
    pub effect: String,
    /// Joint it acts on; `None` for effects of the whole machine.
    pub joint: Option<String>,
    /// Its parameters by name, SI.
    pub parameters: BTreeMap<String, f64>,
}

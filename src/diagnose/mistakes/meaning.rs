//! Names of a factor between position and velocity.

use std::f64::consts::PI;

use super::kinematics::FAR;
use crate::robot::Model;
use crate::units::{DEG, JointKind, RPM};

/// Relative difference up to which two factors count as equal: low-pass and quantisation cause some percent.
pub const SAME: f64 = 0.1;

/// Meaning of a factor between position and velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Meaning {
    /// One of the two has the opposite sign.
    Sign,
    /// Position in this unit: `degrees_for_radians` and the like.
    Position(&'static str),
    /// Velocity in this unit.
    Velocity(&'static str),
    /// A factor without a name.
    Unknown,
}

/// The meaning of a factor `b` of a joint.
pub fn meaning(model: &Model, joint: usize, b: f64) -> Meaning {
    let (n, kind) = (model.joints[joint].gear_ratio, model.joints[joint].kind);
    if (b.abs() - 1.0).abs() < 1.0 - 1.0 / FAR && b < 0.0 {
        return Meaning::Sign;
    }
    let mut names = vec![
        (n, Meaning::Position("motor_angle_for_joint_angle")),
        (n / DEG, Meaning::Position("motor_degrees_for_joint_angle")),
        (n / (2.0 * PI), Meaning::Position("motor_turns_for_joint_angle")),
        (1.0 / n, Meaning::Velocity("motor_velocity_for_joint_velocity")),
        (RPM / n, Meaning::Velocity("motor_rpm_for_joint_velocity")),
        (DEG / n, Meaning::Velocity("motor_degrees_for_joint_velocity")),
    ];
    match kind {
        JointKind::Revolute => names.extend([
            (1.0 / DEG, Meaning::Position("degrees_for_radians")),
            (DEG, Meaning::Velocity("degrees_for_radians")),
            (RPM, Meaning::Velocity("rpm_for_radians_per_second")),
        ]),
        JointKind::Prismatic => names.extend([
            (1e3, Meaning::Position("millimetres_for_metres")),
            (1e-3, Meaning::Velocity("millimetres_for_metres")),
        ]),
    }
    let off = |factor: f64| (b / factor).abs().ln().abs();
    names
        .into_iter()
        .rev()
        .filter(|(factor, _)| b > 0.0 && factor.ln().abs() > FAR.ln() && off(*factor) < SAME)
        .min_by(|a, b| off(a.0).total_cmp(&off(b.0)))
        .map_or(Meaning::Unknown, |found| found.1)
}

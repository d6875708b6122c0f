//! The report of a mistake that the torque balance shows: name, evidence and remedy of a change.

use super::balance::SIZE_FACTOR;
use super::change::{Change, Culprit, Evidence, Quantity};
use super::rows::Rows;
use super::search;
use super::words::{figure, name, position_remedy};
use crate::diagnose::result::Mistake;
use crate::robot::Model;
use crate::units::DEG;

/// The name of a change, with the joints and the factor that go with it.
fn named(model: &Model, rows: &[Rows], change: Change) -> (&'static str, Vec<usize>, Option<f64>) {
    let everyone = || (0..model.joints.len()).collect::<Vec<_>>();
    let of = |which: Option<usize>| which.map_or_else(everyone, |joint| vec![joint]);
    let from_current = rows.iter().all(|session| session.from_current);
    match change {
        Change::TorqueSign(joint) => {
            (if from_current { "sign_of_current" } else { "sign_of_torque" }, vec![joint], Some(-1.0))
        }
        Change::MotionSign(joint) | Change::AxisSign(joint) => ("sign_of_joint", vec![joint], Some(-1.0)),
        Change::SwapTorque(i, j) | Change::SwapMotion(i, j) | Change::SwapJoints(i, j) => {
            ("joints_swapped", vec![i, j], None)
        }
        Change::TorqueScale(which, -1.0) => {
            (if from_current { "sign_of_current" } else { "sign_of_torque" }, of(which), Some(-1.0))
        }
        Change::TorqueScale(which, factor) => (scale(model, which, factor, from_current), of(which), Some(factor)),
        Change::AllTorques(quantity) => (another(quantity), everyone(), None),
        Change::MotionScale(which, factor) => (motion(factor), of(which), Some(factor)),
        Change::MotorMotions(_) => ("motor_angle_for_joint_angle", everyone(), None),
        Change::TimeScale(factor) => ("time_base", everyone(), Some(factor)),
        Change::Gravity => ("gravity_upside_down", everyone(), Some(-1.0)),
        Change::Ratio(joint, factor) => ("gear_ratio", vec![joint], Some(factor)),
        Change::TorqueLag(which, _) => ("late_channel", of(which), None),
        Change::MotionLag(joint, _) => ("late_channel", vec![joint], None),
        Change::Unsigned(which) => ("unsigned_current", of(which), None),
    }
}

const fn another(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::JointTorqueAsCurrent | Quantity::MotorTorqueAsCurrent => "torque_recorded_as_current",
        Quantity::CurrentAsTorque => "current_recorded_as_torque",
        Quantity::MotorTorqueAsJointTorque => "motor_torque_for_joint_torque",
    }
}

fn motion(factor: f64) -> &'static str {
    let is = |other: f64| (factor / other).ln().abs() < 1e-6;
    if is(DEG) {
        "degrees_for_radians"
    } else if is(1.0 / DEG) {
        "radians_for_degrees"
    } else if is(1e-3) {
        "millimetres_for_metres"
    } else if is(1e3) {
        "metres_for_millimetres"
    } else {
        "motor_angle_for_joint_angle"
    }
}

fn scale(model: &Model, which: Option<usize>, factor: f64, from_current: bool) -> &'static str {
    let is = |other: f64| (factor / other).ln().abs() < 0.25;
    let ratio = which.map(|joint| model.joints[joint].gear_ratio);
    let gain = which.and_then(|joint| {
        let joint = &model.joints[joint];
        Some((joint.torque_per_ampere(), joint.motor?.torque_constant))
    });
    match (gain, ratio) {
        (Some((gain, constant)), _) if from_current && (is(1.0 / gain) || is(1.0 / constant)) => {
            "torque_recorded_as_current"
        }
        (Some((gain, _)), _) if !from_current && is(gain) => "current_recorded_as_torque",
        (_, Some(n)) if !from_current && is(n) => "motor_torque_for_joint_torque",
        _ if is(1e-3) && from_current => "milliampere_for_ampere",
        _ if is(1e3) && from_current => "ampere_for_milliampere",
        _ => "torque_scale",
    }
}

/// A change that makes the torque balance fit.
pub fn balance(model: &Model, rows: &[Rows], found: &Culprit) -> Mistake {
    let (mistake, joints, factor) = named(model, rows, found.change);
    let mut alternatives: Vec<&'static str> =
        found.alternatives.iter().map(|other| named(model, rows, *other).0).collect();
    alternatives.retain(|other| *other != mistake);
    // A torque that is never negative may be a magnitude instead.
    if let Change::TorqueSign(joint) | Change::MotionSign(joint) = found.change
        && search::never_negative(rows, joint)
    {
        alternatives.push("unsigned_current");
    }
    let mut seen = Vec::new();
    alternatives.retain(|other| {
        !seen.contains(other) && {
            seen.push(*other);
            true
        }
    });
    let names: Vec<String> = joints.iter().map(|joint| name(model, *joint)).collect();
    let mut evidence = evidence(&name(model, found.joint), found.evidence);
    let same = found.alternatives.iter().map(|other| named(model, rows, *other)).filter(|other| other.0 == mistake);
    let mut others: Vec<usize> = same.flat_map(|other| other.1).filter(|joint| !joints.contains(joint)).collect();
    others.sort_unstable();
    others.dedup();
    if !others.is_empty() {
        let list: Vec<String> = others.iter().map(|joint| name(model, *joint)).collect();
        evidence += &format!(" The same mistake on {} instead would explain the data equally well.", list.join(" or "));
    }
    Mistake {
        remedy: remedy(model, rows, found.change, &names),
        mistake,
        joints: names,
        factor,
        evidence,
        alternatives,
    }
}

fn evidence(joint: &str, evidence: Evidence) -> String {
    match evidence {
        Evidence::Residual([before, after]) => format!(
            "Inertia, weight and friction leave {before:.0} % of the torque of {joint} unexplained as recorded, and {after:.0} % with this mistake corrected."
        ),
        Evidence::Size([times, least, largest]) => {
            let bound = if times > 1.0 {
                format!("at least {}", figure(least))
            } else {
                format!("at most {}", figure(largest))
            };
            format!(
                "{joint}: the torque of inertia and weight is {} times that of the model, {bound}; a model is off by a factor of {SIZE_FACTOR} at most.",
                figure(times)
            )
        }
    }
}

fn remedy(model: &Model, rows: &[Rows], change: Change, names: &[String]) -> String {
    let (mistake, _, factor) = named(model, rows, change);
    let list = names.join(", ");
    let column = if rows.iter().all(|session| session.from_current) { "current" } else { "torque" };
    let factor = factor.unwrap_or(1.0);
    match change {
        Change::TorqueSign(_) => format!("`scale = -1` for `{column}` in the manifest"),
        Change::MotionSign(_) => "`scale = -1` for `position` and `velocity` in the manifest, or reverse the joint's `<axis>` in the URDF".to_owned(),
        Change::AxisSign(_) => "reverse the joint's `<axis>` in the URDF, or `scale = -1` for all its channels in the manifest".to_owned(),
        Change::SwapTorque(..) => format!("exchange the columns `{column}` of {list} in the manifest"),
        Change::SwapMotion(..) => format!("exchange the columns `position` and `velocity` of {list} in the manifest"),
        Change::SwapJoints(..) => format!("exchange all columns of {list} in the manifest"),
        Change::Gravity => "`gravity` in the model file points the wrong way, or the robot hangs: `gravity = [0, 0, 9.81]`".to_owned(),
        Change::TorqueLag(_, lag) if lag > 0.0 => format!("`{column}` is late by about {lag:.2} s against position: shift it to earlier times, or record both by one clock"),
        Change::MotionLag(_, lag) if lag > 0.0 => format!("position and velocity of {list} are late by about {lag:.2} s against `{column}` and the other joints: shift them to earlier times, or record all by one clock"),
        Change::MotionLag(_, lag) => format!("position and velocity of {list} are early by about {:.2} s against `{column}` and the other joints: shift them to later times, or record all by one clock", -lag),
        Change::TorqueLag(_, lag) => format!("position is late by about {:.2} s against `{column}`: shift it to earlier times, or record both by one clock", -lag),
        Change::Unsigned(_) => "the current is recorded without its sign: `sensing = \"absolute\"` in the model file's `current_sensor`, or record it signed".to_owned(),
        Change::Ratio(joint, _) => format!("`gear_ratio = {}` instead of {} in the model file", figure(model.joints[joint].gear_ratio * factor), figure(model.joints[joint].gear_ratio)),
        Change::TimeScale(_) => format!("multiply the column `time` by {}: its unit or the sample rate is not what the file says", figure(factor)),
        Change::MotionScale(..) if mistake == "motor_angle_for_joint_angle" => position_remedy("motor"),
        Change::MotorMotions(factor) => position_remedy("motor") + if factor == DEG { "; and they are in degrees" } else { "" },
        Change::MotionScale(..) if mistake == "degrees_for_radians" => "positions are in degrees: `unit = \"deg\"` for `position` and `unit = \"deg/s\"` for `velocity` in the manifest".to_owned(),
        Change::MotionScale(..) => format!("`scale = {}` for `position` and `velocity` in the manifest: they are in another unit than stated", figure(factor)),
        Change::TorqueScale(..) | Change::AllTorques(_) => match mistake {
            "sign_of_current" | "sign_of_torque" => format!("`scale = -1` for `{column}` in the manifest"),
            "milliampere_for_ampere" => "currents are in mA: `unit = \"mA\"` for `current` in the manifest".to_owned(),
            "torque_recorded_as_current" => "the channel holds a torque: name it `torque` in the manifest, with `scale` where it is that of the motor".to_owned(),
            "current_recorded_as_torque" => "the channel holds a current: name it `current` in the manifest".to_owned(),
            "motor_torque_for_joint_torque" => "torques are those of the motor: `scale` of `torque` is the gear ratio".to_owned(),
            _ => format!("`scale = {}` for `{column}` in the manifest, or `torque_constant` or `gear_ratio` of the model file are off by that factor", figure(factor)),
        },
    }
}
